#include "planner/problem/ompl_app/body_origin.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>

#include "leeway/robots/input_error.h"

namespace leeway::planner {
namespace {

struct VertexSum {
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  double count = 0;
};

/// Adds the vertices of a node and of those below it.
void add(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent, VertexSum& sum) {
  Eigen::Matrix4d local;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      local(static_cast<int>(row), static_cast<int>(column)) =
          static_cast<double>(node.mTransformation[row][column]);
  const Eigen::Matrix4d X = parent * local;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    for (unsigned k = 0; k < mesh.mNumVertices; ++k) {
      const aiVector3D& v = mesh.mVertices[k];
      sum.total += (X * Eigen::Vector4d(static_cast<double>(v.x), static_cast<double>(v.y),
                                        static_cast<double>(v.z), 1))
                       .head<3>();
    }
    sum.count += mesh.mNumVertices;
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) add(scene, *node.mChildren[i], X, sum);
}

}  // namespace

Eigen::Vector3d bodyOrigin(const std::string& mesh, const std::string& referrer, int line) {
  const auto fail = [&](const std::string& what) {
    throw robots::InputError(
        referrer, line,
        fmt::format("mesh {} {}; an intact STL, OBJ, PLY, DAE or glTF file would be accepted", mesh,
                    what));
  };
  Assimp::Importer importer;
  // Bones without a mesh have no shape.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* const scene = importer.ReadFile(
      mesh, aiProcess_GenNormals | aiProcess_Triangulate | aiProcess_JoinIdenticalVertices |
                aiProcess_SortByPType | aiProcess_OptimizeGraph);
  if (scene == nullptr) fail(fmt::format("cannot be read: {}", importer.GetErrorString()));
  VertexSum sum;
  if (scene->mRootNode != nullptr) add(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), sum);
  if (sum.count == 0) fail("has no vertices");
  return sum.total / sum.count;
}

}  // namespace leeway::planner
