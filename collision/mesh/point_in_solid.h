#pragma once

#include "collision/mesh/winding.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

/// On which side of one closed component of a mesh a point is: inside when the component's winding
/// number about it is not 0. Exact for the given double coordinates. kUnknown only for a point on
/// the surface, for one with a non-zero coordinate below kSmallestExact, or when every segment
/// tried meets an edge or vertex. O(log n) to O(n).
Side sideOf(const TriangleMesh& mesh, int component, const Eigen::Vector3d& point);

}  // namespace leeway::collision
