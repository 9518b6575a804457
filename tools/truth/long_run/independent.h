#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::accuracy {

/// Extended precision (64 bits of mantissa where the machine has them): a second opinion that
/// shares no code with the engine. Where it has no more bits than double, judgements are only as
/// sharp as their tolerances.
using Real = long double;

/// The largest n . (x - origin) over all points x of a placed convex shape but a half-space; n of
/// any length. A radius is not deformed by a rotation that is not quite one, all else is, as
/// the engine has it. O(vertices).
Real farthestAlong(const collision::Shape& shape, const collision::Pose& X_WS,
                   const Eigen::Vector3d& n, const Eigen::Vector3d& origin);

/// At most how far p is outside a placed convex shape, up to a factor; <= 0 inside, and for hulls
/// without facets. O(facets).
Real outsideBy(const collision::Shape& shape, const collision::Pose& X_WS,
               const Eigen::Vector3d& p_W);

}  // namespace leeway::accuracy
