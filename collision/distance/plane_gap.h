#pragma once

// Private to planner/ and collision/: the gaps that planes leave between two bodies, at three
// placements of one of them.

#include <array>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Poses of body A in B's frame: three placements of one motion.
using ThreePoses = std::array<Pose, 3>;
/// Lower bounds on the signed separation at each placement [m].
using ThreeGaps = std::array<double, 3>;

/// The gaps between the convex hulls of A and B along the unit vector `direction_B`, from B to A,
/// minus the rounding of the sums. Each is the least over points of A of linear functions of their
/// positions. If B is a half-space, its own direction is used. -infinity if there are no such
/// hulls: deforming meshes, a half-space A. Poses are used as exact. O(vertices of both hulls) at
/// worst.
ThreeGaps planeGaps(const Shape& a, const ThreePoses& X_BA, const Shape& b,
                    const Eigen::Vector3d& direction_B);

/// The gaps of two bodies, one of which is a mesh that counts only as a surface: planes between
/// nodes of its hierarchy and the hull of the other body, where each node has its own direction,
/// descending as deep as `wanted` needs. If both are meshes, the hierarchy of the one farther from
/// convex is used. Returns the least gaps of all nodes. Where the surface meets the other body,
/// these bounds are not above 0. They bound the separation from a placement that is known not to be
/// inside, up to the first bound that is not above 0. Visits at most `nodes` nodes and sets it to
/// the number left.
ThreeGaps surfaceGaps(const Shape& a, const ThreePoses& X_BA, const Shape& b,
                      const ThreeGaps& wanted, int& nodes, Scratch& scratch);

}  // namespace leeway::collision
