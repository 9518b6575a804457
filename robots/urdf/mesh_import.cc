// Meshes through Assimp. Its importers round vertices to single precision; the rest is in double.

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <utility>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/model.h"

namespace leeway::robots {

namespace {

using collision::TriangleMesh;

struct Soup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
};

Eigen::Matrix4d toEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      result(static_cast<int>(row), static_cast<int>(column)) = static_cast<double>(m[row][column]);
  return result;
}

/// Appends a node's mesh. A face of one or two corners (a point, a line) becomes a triangle without
/// area: it takes part in collisions.
void append(const aiMesh& mesh, const Eigen::Matrix4d& transform, const Eigen::Vector3d& scale,
            Soup& soup) {
  const auto first = static_cast<std::int32_t>(soup.vertices.size());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& v = mesh.mVertices[i];
    const Eigen::Vector4d p =
        transform * Eigen::Vector4d(static_cast<double>(v.x), static_cast<double>(v.y),
                                    static_cast<double>(v.z), 1);
    soup.vertices.push_back(p.head<3>().cwiseProduct(scale));
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    if (face.mNumIndices == 0) continue;
    const auto corner = [&](unsigned k) {
      return first + static_cast<std::int32_t>(face.mIndices[std::min(k, face.mNumIndices - 1)]);
    };
    soup.triangles.push_back({corner(0), corner(1), corner(2)});
  }
}

void append(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent,
            const Eigen::Vector3d& scale, Soup& soup) {
  const Eigen::Matrix4d transform = parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    append(*scene.mMeshes[node.mMeshes[i]], transform, scale, soup);
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    append(scene, *node.mChildren[i], transform, scale, soup);
}

}  // namespace

collision::Shape loadMesh(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line) {
  const auto fail = [&](const std::string& message) {
    throw InputError(referrer, line, "mesh " + path + ' ' + message);
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    fail("is not there; the path of a mesh file (STL, OBJ, DAE) would be accepted");
  if (!scale.allFinite() || (scale.array() == 0).any())
    fail("has a scale that is zero or not finite; three other numbers would be accepted");
  Assimp::Importer importer;
  // As RViz and MoveIt do: ignore the file's up axis, apply its unit of length.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (scene == nullptr)
    fail("cannot be read: " + std::string(importer.GetErrorString()) +
         "; an intact STL, OBJ or DAE file would be accepted");
  Soup soup;
  if (scene->mRootNode != nullptr)
    append(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), scale, soup);
  if (soup.triangles.empty()) fail("has no triangles; at least one would be accepted");
  for (const Eigen::Vector3d& v : soup.vertices)
    if (!v.allFinite())
      fail("has a vertex that is not finite; finite coordinates would be accepted");
  try {
    return collision::Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles));
  } catch (const collision::InvalidShape& invalid) {
    fail("cannot be used: " + std::string(invalid.what()));
  }
  throw InputError(referrer, line, path);  // not reached: fail() throws
}

}  // namespace leeway::robots
