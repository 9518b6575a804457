#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "collision/base/byte_stream.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

struct BallCover;  // ball_cover.h

/// A mesh and what a file keeps of its tree.
struct BuiltMesh {
  std::shared_ptr<const TriangleMesh> mesh;
  MeshTreePlan plan;
};

/// What files read and write of a TriangleMesh.
struct MeshFile {
  using Meanwhile = std::function<void(const std::shared_ptr<const TriangleMesh>&)>;
  /// Called between stages, in any thread; what it throws ends the work. A million triangles take a
  /// second or two between two calls.
  using Checkpoint = std::function<void()>;

  /// As TriangleMesh::make(). `meanwhile` is called, perhaps in a thread of its own, with the mesh
  /// as soon as it has its triangles, hierarchy of nodes and hullExcess(): no query must be asked
  /// then.
  static BuiltMesh build(std::span<const Eigen::Vector3d> vertices,
                         std::span<const TriangleMesh::Triangle> triangles,
                         const MeshOptions& options = {}, const Meanwhile& meanwhile = {},
                         const Checkpoint& checkpoint = {});
  /// All of a mesh that takes time to find. O(n).
  static void pack(const BuiltMesh& built, ByteWriter& to);
  /// The mesh that pack() wrote, the same in every byte that queries read. Null where the bytes are
  /// none that queries could use: every index is checked, trees are trees, numbers are finite, and
  /// what is cheap to find is found anew (boxes of nodes, for one). That volumes hold what they
  /// should is not looked at: a checksum guards it. O(n).
  static std::shared_ptr<TriangleMesh> unpack(ByteReader& from);
  /// Gives a new mesh the cover that coverOf() would make.
  static void setCover(const TriangleMesh& mesh, std::shared_ptr<const BallCover> cover);
};

}  // namespace leeway::collision
