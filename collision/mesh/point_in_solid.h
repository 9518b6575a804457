#pragma once

#include "collision/mesh/winding.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

/// The side of one closed component of a mesh on which a point lies: inside if the component's
/// winding number around it is not 0. Exact for the given double coordinates. kUnknown only for a
/// point on the surface, for one with a non-zero coordinate below kSmallestExact, or if every
/// segment that is tried meets an edge or vertex. O(log n) to O(n).
Side sideOf(const TriangleMesh& mesh, int component, const Eigen::Vector3d& point);

}  // namespace leeway::collision
