#pragma once

#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

enum class Side : unsigned char { kOutside, kInside, kUnknown };

/// Where a point stands to one closed component of a mesh: inside when the component's winding
/// number about it is not 0. Signs are exact, so that the answer is, for the double coordinates
/// given; kUnknown only for a point on the surface or when every segment tried meets an edge or
/// vertex. O(log n) to O(n).
Side sideOf(const TriangleMesh& mesh, int component, const Eigen::Vector3d& point);

}  // namespace leeway::collision
