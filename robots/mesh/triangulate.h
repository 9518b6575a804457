#pragma once

// Private to robots/.

#include <array>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "robots/mesh/file_mesh.h"

namespace leeway::robots {

/// Faces of which something must be told.
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

/// How a polygon that is not planar is read: it means any surface between its corners.
enum class Bent {
  kCut,     ///< the triangles that it is cut into
  kCovered  ///< these, and a closed body that holds all such surfaces: of four corners those of all
            ///< triangles, of more all within its departure from a plane
};

/// Cuts all polygons of `mesh` (cutPolygon()), in their order; bodies that cover polygons add
/// vertices. A polygon that crosses itself is covered with all that it winds about, and perhaps
/// more. Counted as bent or crossing is what exceeds kPlanarShare.
CutMesh triangulate(FileMesh& mesh, Bent bent);

}  // namespace leeway::robots
