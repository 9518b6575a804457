// Reads formats without a reader in this library. Assimp's importers round to single precision.

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>
#include <exception>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

/// Provides importers with a file from memory, and with other files from disk, except materials,
/// which have no shapes. Sets `reads_others` if other files are read.
class Files final : public Assimp::IOSystem {
 public:
  Files(const MeshSource& source, bool& reads_others)
      : source_(source), reads_others_(reads_others) {}

  bool Exists(const char* file) const override {
    return file == source_.path() || (!isMaterial(file) && disk_.Exists(file));
  }
  char getOsSeparator() const override { return disk_.getOsSeparator(); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (file == source_.path())
      return new Assimp::MemoryIOStream(
          reinterpret_cast<const std::uint8_t*>(source_.bytes().data()), source_.bytes().size());
    if (isMaterial(file)) return nullptr;
    reads_others_ = true;
    return disk_.Open(file, mode);
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  static bool isMaterial(std::string_view file) {
    return file.ends_with(".mtl") || file.ends_with(".MTL");
  }

  const MeshSource& source_;
  bool& reads_others_;
  Assimp::DefaultIOSystem disk_;
};

/// Ends an import when a stop is requested, because its importer reports progress now and then. The
/// importer treats an exception as an error in the file, so `ended` stores it.
class Questions final : public Assimp::ProgressHandler {
 public:
  Questions(const MeshSource& source, std::exception_ptr& ended) : source_(source), ended_(ended) {}
  bool Update(float) override {
    if (ended_) std::rethrow_exception(ended_);
    try {
      source_.pause();
    } catch (...) {
      ended_ = std::current_exception();
      throw;
    }
    return true;
  }

 private:
  const MeshSource& source_;
  std::exception_ptr& ended_;
};

/// An importer with a scene in it.
class Import {
 public:
  /// `ignore_up_axis` and `steps` are Assimp's.
  Import(const MeshSource& source, bool& reads_others, bool ignore_up_axis, unsigned steps) {
    // Both are the importer's from here on.
    importer_.SetIOHandler(new Files(source, reads_others));
    importer_.SetProgressHandler(new Questions(source, ended_));
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, ignore_up_axis);
    // Bones without a mesh have no shape.
    importer_.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    scene_ = importer_.ReadFile(source.path(), steps);
    if (ended_) std::rethrow_exception(ended_);
    if (scene_ == nullptr)
      source.fail("cannot be read: " + std::string(importer_.GetErrorString()) +
                  "; an intact STL, OBJ, PLY, DAE or glTF file would be accepted");
  }
  const aiScene& scene() const { return *scene_; }

 private:
  std::exception_ptr ended_;  // outlives the importer
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;
};

Eigen::Matrix4d toEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      result(static_cast<int>(row), static_cast<int>(column)) = static_cast<double>(m[row][column]);
  return result;
}

FileMesh meshOf(const MeshSource& source, const aiMesh& given, NotSolid& left_out) {
  FileMesh mesh;
  requireCountable(source, given.mNumVertices, {});
  mesh.vertices.reserve(given.mNumVertices);
  for (unsigned i = 0; i < given.mNumVertices; ++i) {
    const aiVector3D& v = given.mVertices[i];
    mesh.vertices.emplace_back(static_cast<double>(v.x), static_cast<double>(v.y),
                               static_cast<double>(v.z));
    if (!mesh.vertices.back().allFinite())
      source.fail("has a vertex that is not finite; finite coordinates would be accepted");
  }
  mesh.faces.reserve(given.mNumFaces);
  for (unsigned i = 0; i < given.mNumFaces; ++i) {
    const aiFace& face = given.mFaces[i];
    if (face.mNumIndices == 1) left_out.count(left_out.points, {});
    if (face.mNumIndices == 2) left_out.count(left_out.lines, {});
    if (face.mNumIndices < 3) continue;
    requireCountable(source, mesh.corners.size() + face.mNumIndices, {});
    mesh.faces.push_back({static_cast<std::int32_t>(mesh.corners.size()),
                          static_cast<std::int32_t>(face.mNumIndices),
                          {}});
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= given.mNumVertices)
        source.fail("has a face that names vertex " + std::to_string(face.mIndices[k]) + "; 0 to " +
                    std::to_string(given.mNumVertices) + " - 1 would be accepted");
      mesh.corners.push_back(static_cast<std::int32_t>(face.mIndices[k]));
    }
  }
  return mesh;
}

void place(const aiNode& node, const Eigen::Matrix4d& parent, MeshContents& contents) {
  const Eigen::Matrix4d X = parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    contents.instances.push_back({node.mMeshes[i], X.topRows<3>()});
  for (unsigned i = 0; i < node.mNumChildren; ++i) place(*node.mChildren[i], X, contents);
}

void sum(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent,
         Eigen::Vector3d& total, double& count) {
  const Eigen::Matrix4d X = parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    for (unsigned k = 0; k < mesh.mNumVertices; ++k) {
      const aiVector3D& v = mesh.mVertices[k];
      total += (X * Eigen::Vector4d(static_cast<double>(v.x), static_cast<double>(v.y),
                                    static_cast<double>(v.z), 1))
                   .head<3>();
    }
    count += mesh.mNumVertices;
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) sum(scene, *node.mChildren[i], X, total, count);
}

}  // namespace

MeshContents readByAssimp(const MeshSource& source, bool& reads_others) {
  const Import import(source, reads_others, true, 0);
  const aiScene& scene = import.scene();
  MeshContents contents;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i)
    contents.meshes.push_back(meshOf(source, *scene.mMeshes[i], contents.not_solid));
  if (scene.mRootNode != nullptr) place(*scene.mRootNode, Eigen::Matrix4d::Identity(), contents);
  return contents;
}

Eigen::Vector3d meanOfAssimpsVertices(const MeshSource& source) {
  bool reads_others = false;
  const Import import(source, reads_others, false,
                      aiProcess_GenNormals | aiProcess_Triangulate |
                          aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                          aiProcess_OptimizeGraph);
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  double count = 0;
  if (import.scene().mRootNode != nullptr)
    sum(import.scene(), *import.scene().mRootNode, Eigen::Matrix4d::Identity(), total, count);
  if (count == 0) source.fail("has no vertices; at least one would be accepted");
  return total / count;
}

}  // namespace leeway::robots
