#pragma once

#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Searches the shortest translation t of B that is proven to separate two overlapping meshes;
/// raises the lower end of `result` to -|t| and makes its direction the normal. `result` is in W:
/// its upper end is a lower bound on the length, and its lower end and normal are a translation
/// that is known to separate (that of the hulls). `tries`: additional directions, of any length. At
/// most kSeparationQueries queries.
void separateMeshes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    std::span<const Eigen::Vector3d> tries, const DistanceRequest& request,
                    Scratch& scratch, DistanceResult& result);

}  // namespace leeway::collision
