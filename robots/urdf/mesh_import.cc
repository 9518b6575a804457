// Meshes through Assimp. Its importers round vertices to single precision; the rest is in double.

#include "robots/urdf/mesh_import.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>
#include <cctype>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "collision/cover/mesh_bytes.h"
#include "collision/mesh/mesh_file.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/model.h"
#include "robots/base/interruptible.h"
#include "robots/cache/content_key.h"
#include "robots/cache/disk_cache.h"

namespace leeway::robots {

namespace {

using collision::TriangleMesh;

// Smaller files are imported about as fast as a file from the cache is read [B].
constexpr std::size_t kLeastKept = 4096;
constexpr const char* kReading = "meshes were read";

struct Soup {
  std::pmr::vector<Eigen::Vector3d> vertices{collision::largeArrays()};
  std::pmr::vector<TriangleMesh::Triangle> triangles{collision::largeArrays()};
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
  if (first == 0) {
    soup.vertices.reserve(mesh.mNumVertices);
    soup.triangles.reserve(mesh.mNumFaces);
  }
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

/// What is after the last dot, in lower case: importers are chosen by it.
std::string endingOf(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

std::optional<collision::LargeBuffer> contentsOf(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  collision::LargeBuffer bytes(static_cast<std::size_t>(size));
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    return std::nullopt;
  return bytes;
}

/// Gives importers a file from memory, and other files from the disk: but for materials, which say
/// nothing of shapes. Tells whether others were read: then the file's bytes are not all that the
/// mesh depends on.
class Files final : public Assimp::IOSystem {
 public:
  Files(std::string path, std::span<const std::byte> bytes, bool& reads_others)
      : path_(std::move(path)), bytes_(bytes), reads_others_(reads_others) {}

  bool Exists(const char* file) const override {
    return file == path_ || (endingOf(file) != ".mtl" && disk_.Exists(file));
  }
  char getOsSeparator() const override { return disk_.getOsSeparator(); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (file == path_)
      return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                        bytes_.size());
    if (endingOf(file) == ".mtl") return nullptr;
    reads_others_ = true;
    return disk_.Open(file, mode);
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string path_;
  std::span<const std::byte> bytes_;
  bool& reads_others_;
  Assimp::DefaultIOSystem disk_;
};

/// The key of a mesh that depends on no file but this one.
std::string keyOf(const std::string& path, const Eigen::Vector3d& scale,
                  std::span<const std::byte> bytes) {
  ContentKey key("mesh");
  // Importers are chosen by what follows a dot, be it the first or the last.
  const std::string name = std::filesystem::path(path).filename().string();
  key.add(std::string_view(name).substr(std::min(name.find('.'), name.size())));
  for (const double factor : scale) key.add(factor);
  key.add(bytes);
  return key.finish();
}

/// Ends an import, whose importer reports now and then how far it is. It takes what is thrown for
/// trouble with the file: `ended` keeps it.
class Questions final : public Assimp::ProgressHandler {
 public:
  Questions(const Stop& stop, std::exception_ptr& ended) : stop_(stop), ended_(ended) {}
  bool Update(float) override {
    if (ended_) std::rethrow_exception(ended_);
    try {
      throwIfStopped(stop_, kReading);
    } catch (...) {
      ended_ = std::current_exception();
      throw;
    }
    return true;
  }

 private:
  const Stop& stop_;
  std::exception_ptr& ended_;
};

/// Whose reading of a file it is to be.
enum class Reader { kRviz, kOmplApp };

/// Reads a file's bytes through Assimp. `fail` takes a message and throws.
template <class Fail>
Soup readSoup(const std::string& path, const Eigen::Vector3d& scale,
              std::span<const std::byte> bytes, bool& reads_others, const Fail& fail,
              const Stop& stop, Reader reader = Reader::kRviz) {
  std::exception_ptr ended;  // outlives the importer
  Assimp::Importer importer;
  // Both are the importer's from here on.
  importer.SetIOHandler(new Files(path, bytes, reads_others));
  importer.SetProgressHandler(new Questions(stop, ended));
  // As RViz and MoveIt do: ignore the file's up axis, apply its unit of length.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, reader == Reader::kRviz);
  const unsigned steps = reader == Reader::kRviz
                             ? aiProcess_Triangulate
                             : aiProcess_GenNormals | aiProcess_Triangulate |
                                   aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                                   aiProcess_OptimizeGraph;
  const aiScene* scene = importer.ReadFile(path, steps);
  if (ended) std::rethrow_exception(ended);
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
  return soup;
}

template <class Fail>
collision::LargeBuffer readBytes(const std::string& path, const Fail& fail) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    fail(std::string(std::filesystem::exists(path, error) ? "is a folder or a device"
                                                          : "is not there") +
         "; the path of a mesh file (STL, OBJ, DAE) would be accepted");
  std::optional<collision::LargeBuffer> contents = contentsOf(path);
  if (!contents) fail("cannot be read; an intact STL, OBJ or DAE file would be accepted");
  return std::move(*contents);
}

}  // namespace

CenteredMesh importForOmplApp(const std::string& path, const std::string& referrer, int line) {
  const auto fail = [&](const std::string& message) {
    throw InputError(referrer, line, "mesh " + path + ' ' + message);
  };
  const collision::LargeBuffer contents = readBytes(path, fail);
  bool reads_others = false;
  const Soup soup = readSoup(path, Eigen::Vector3d::Ones(), {contents.data(), contents.size()},
                             reads_others, fail, {}, Reader::kOmplApp);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : soup.vertices) sum += v;
  try {
    return {collision::Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles)),
            sum / static_cast<double>(soup.vertices.size())};
  } catch (const collision::InvalidShape& invalid) {
    fail("cannot be used: " + std::string(invalid.what()));
  }
  throw InputError(referrer, line, path);  // not reached: fail() throws
}

ImportedMesh importMesh(const std::string& path, const Eigen::Vector3d& scale,
                        const std::string& referrer, int line, const DiskCache& cache,
                        const Stop& stop) {
  throwIfStopped(stop, kReading);
  const auto fail = [&](const std::string& message) {
    throw InputError(referrer, line, "mesh " + path + ' ' + message);
  };
  if (!scale.allFinite() || (scale.array() == 0).any())
    fail("has a scale that is zero or not finite; three other numbers would be accepted");
  const collision::LargeBuffer contents = readBytes(path, fail);
  const std::span<const std::byte> bytes(contents.data(), contents.size());
  std::string key;
  const bool is_kept = bytes.size() >= kLeastKept;
  if (cache.isOn()) {
    key = keyOf(path, scale, bytes);
    if (const auto kept = is_kept ? cache.read(key) : std::nullopt)
      if (auto mesh = collision::meshFromBytes({kept->data(), kept->size()}))
        return {collision::Shape::mesh(std::move(mesh)), std::move(key)};
  }
  bool reads_others = false;
  const Soup soup = readSoup(path, scale, bytes, reads_others, fail, stop);
  if (reads_others) key.clear();
  throwIfStopped(stop, kReading);
  const auto checkpoint = [&] { throwIfStopped(stop, kReading); };
  const auto alone = [&]() -> ImportedMesh {
    auto built = collision::MeshFile::build(soup.vertices, soup.triangles, {}, {}, checkpoint);
    return {collision::Shape::mesh(std::move(built.mesh)), std::move(key)};
  };
  try {
    if (key.empty() || !is_kept) return alone();
    try {
      collision::MeshAndBytes made =
          collision::makeMeshAndBytes(soup.vertices, soup.triangles, {}, checkpoint);
      cache.write(key, made.bytes);
      return {collision::Shape::mesh(std::move(made.mesh)), std::move(key)};
    } catch (const std::bad_alloc&) {  // keeping takes more memory than the mesh itself
      return alone();
    }
  } catch (const collision::InvalidShape& invalid) {
    fail("cannot be used: " + std::string(invalid.what()));
  }
  throw InputError(referrer, line, path);  // not reached: fail() throws
}

collision::Shape loadMesh(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line, const LoadOptions& options) {
  const DiskCache cache(options.cache);
  std::error_code error;
  if (const std::uintmax_t bytes = std::filesystem::file_size(path, error);
      error || bytes < kWorthAsking) {
    throwIfStopped(options.stop, kReading);
    return importMesh(path, scale, referrer, line, cache, {}).shape;
  }
  std::optional<ImportedMesh> mesh;
  workInterruptibly(options.stop, [&](const Stop& asked) {
    mesh = importMesh(path, scale, referrer, line, cache, asked);
  });
  return std::move(mesh->shape);
}

}  // namespace leeway::robots
