#pragma once

#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Raises the lower end of an overlap to -|t| of the shortest translation t of B that is found and
/// proven to separate, and makes its direction the normal. `result` is in W; its upper end says how
/// long a translation must be at least, its lower end and normal are one that is known to do (that
/// of the hulls), `tries` are directions worth a try, of any length. At most kSeparationQueries
/// queries.
void separateMeshes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    std::span<const Eigen::Vector3d> tries, const DistanceRequest& request,
                    Scratch& scratch, DistanceResult& result);

}  // namespace leeway::collision
