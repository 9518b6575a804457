#pragma once

// Private to the library: meshes as bytes, with all that was made of them, so that a program that
// starts again need not make it again. Where the bytes are kept is up to others
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

/// The mesh as TriangleMesh::make() makes it, with its cover (coverOf()) made, too. Throws
/// InvalidShape, and what `checkpoint` throws, which is called between stages in any thread. O(n
/// log n); about 250 bytes a triangle.
MeshAndBytes makeMeshAndBytes(std::span<const Eigen::Vector3d> vertices,
                              std::span<const TriangleMesh::Triangle> triangles,
                              const MeshOptions& options = {},
                              const std::function<void()>& checkpoint = {});

/// The same mesh: every query has the same answer, byte for byte. Null where the bytes are none
/// that makeMeshAndBytes() of this build made, as far as that can be seen in O(n): no bytes
/// whatever lead a query out of its arrays or into a loop without end. (What a checksum is for,
/// bits that fell over in a coordinate, is not seen.)
std::shared_ptr<const TriangleMesh> meshFromBytes(std::span<const std::byte> bytes);

}  // namespace leeway::collision
