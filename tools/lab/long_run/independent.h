#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::accuracy {

/// Extended precision (64-bit significand where available): a second opinion that shares no code
/// with the engine. If long double equals double, its rounding uses up the tolerances.
using Real = long double;

/// Support value: max n . (x - origin) over a placed convex shape other than a half-space; n of any
/// length. A matrix that is not quite a rotation deforms the shape but not its radius, as in the
/// engine. O(vertices).
Real farthestAlong(const collision::Shape& shape, const collision::Pose& X_WS,
                   const Eigen::Vector3d& n, const Eigen::Vector3d& origin);

/// Upper bound, up to a factor, of p's distance outside a placed convex shape; <= 0 if p is inside,
/// and for hulls without facets. O(facets).
Real outsideBy(const collision::Shape& shape, const collision::Pose& X_WS,
               const Eigen::Vector3d& p_W);

}  // namespace leeway::accuracy
