#pragma once

// Private to the library: meshes as bytes, with all data computed from them, so that a program need
// not compute the data again when it restarts. Others decide where the bytes are stored
// (robots/cache/disk_cache.h).

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

struct MeshAndBytes {
  std::shared_ptr<const TriangleMesh> mesh;
  std::vector<std::byte> bytes;
};

/// Makes the mesh as TriangleMesh::make() does, including its cover (coverOf()). Throws
/// InvalidShape, and what `checkpoint` throws, which is called between stages in any thread. O(n
/// log n); about 250 bytes for each triangle.
MeshAndBytes makeMeshAndBytes(std::span<const Eigen::Vector3d> vertices,
                              std::span<const TriangleMesh::Triangle> triangles,
                              const MeshOptions& options = {},
                              const std::function<void()>& checkpoint = {});

/// Restores the same mesh: every query has the same answer, byte for byte. Returns null if
/// makeMeshAndBytes() of this build did not make the bytes, as far as O(n) checks can detect. No
/// bytes at all can lead a query out of its arrays or into an endless loop. (Flipped bits in a
/// coordinate are not detected; use a checksum for these.)
std::shared_ptr<const TriangleMesh> meshFromBytes(std::span<const std::byte> bytes);

}  // namespace leeway::collision
