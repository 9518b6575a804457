#pragma once

// Private to planner/ and collision/: what planes leave between two bodies at three places of one
// of them.

#include <array>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Where body A is, seen from B: three placements of one motion.
using ThreePoses = std::array<Pose, 3>;
/// Lower bounds on the signed separation at each of them [m].
using ThreeGaps = std::array<double, 3>;

/// The gaps that the convex hulls of A and B leave along the unit vector `direction_B`, from B to
/// A, less rounding of the sums. Each is the least over points of A of linear functions of their
/// places. Of a half-space B the direction is its own. -infinity where there are no such hulls:
/// deforming meshes, a half-space A. Poses hold as they are. O(vertices of both hulls) at worst.
ThreeGaps planeGaps(const Shape& a, const ThreePoses& X_BA, const Shape& b,
                    const Eigen::Vector3d& direction_B);

/// The same of two bodies of which one is a mesh, whose surface alone counts: planes between nodes
/// of its hierarchy and the hull of the other, each node with a direction of its own, as deep as
/// `wanted` needs. Of two meshes the one that is farther from convex. The least of all. Where the
/// surface meets the other body these bounds are not above 0; so they bound the separation from
/// where that is known not to be inside on, until then. Looks at no more than `nodes` nodes, which
/// becomes how many are left.
ThreeGaps surfaceGaps(const Shape& a, const ThreePoses& X_BA, const Shape& b,
                      const ThreeGaps& wanted, int& nodes, Scratch& scratch);

}  // namespace leeway::collision
