#pragma once

// Private to robots/.

#include <array>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "robots/mesh/file_mesh.h"

namespace leeway::robots {

/// Faces that need a message.
struct FaceCount {
  std::int64_t count = 0;
  FilePlace first;
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();  ///< departure, as a displacement
};

/// The triangles of a file's polygons.
struct CutMesh {
  using Triangle = std::array<std::int32_t, 3>;
  std::pmr::vector<Triangle> triangles{collision::largeArrays()};
  FaceCount bent;      ///< not planar
  FaceCount crossing;  ///< crossing themselves
};

/// How a polygon that is not planar is interpreted, because it may mean any surface between its
/// corners.
enum class Bent {
  kCut,     ///< the triangles of its triangulation
  kCovered  ///< these, and a closed body that contains all such surfaces: for four corners, the
            ///< surfaces of all triangles; for more, all surfaces within its departure from a plane
};

/// Triangulates all polygons of `mesh` (cutPolygon()), in their order; bodies that cover polygons
/// add vertices. A polygon that crosses itself is covered with everything that it winds around, and
/// perhaps more. Polygons count as bent or crossing if they exceed kPlanarShare.
CutMesh triangulate(FileMesh& mesh, Bent bent);

}  // namespace leeway::robots
