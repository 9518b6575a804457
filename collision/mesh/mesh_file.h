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

/// A mesh and the data of its tree that a file stores.
struct BuiltMesh {
  std::shared_ptr<const TriangleMesh> mesh;
  MeshTreePlan plan;
};

/// Access to a TriangleMesh for writing and reading files.
struct MeshFile {
  using Meanwhile = std::function<void(const std::shared_ptr<const TriangleMesh>&)>;
  /// Called between stages, in any thread; an exception from it ends the work. A million triangles
  /// take a second or two between two calls.
  using Checkpoint = std::function<void()>;

  /// As TriangleMesh::make(). `meanwhile` is called, perhaps in a separate thread, with the mesh as
  /// soon as it has its triangles, hierarchy of nodes and hullExcess(). It must not query the mesh.
  static BuiltMesh build(std::span<const Eigen::Vector3d> vertices,
                         std::span<const TriangleMesh::Triangle> triangles,
                         const MeshOptions& options = {}, const Meanwhile& meanwhile = {},
                         const Checkpoint& checkpoint = {});
  /// Writes all data of a mesh that takes time to compute. O(n).
  static void pack(const BuiltMesh& built, ByteWriter& to);
  /// Reads the mesh that pack() wrote, identical in every byte that queries read. Null if the bytes
  /// are not usable for queries: every index is checked, trees must be valid, numbers must be
  /// finite, and data that is cheap to compute (for example boxes of nodes) is computed again. It
  /// does not check that volumes contain their contents; a checksum protects that. O(n).
  static std::shared_ptr<TriangleMesh> unpack(ByteReader& from);
  /// Gives a new mesh the cover that coverOf() would make.
  static void setCover(const TriangleMesh& mesh, std::shared_ptr<const BallCover> cover);
};

}  // namespace leeway::collision
