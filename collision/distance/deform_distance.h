#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// distance() for pairs with at least one deforming mesh; request.tolerance must not be NaN.
/// Swapping a and b swaps the answer. O(nodes visited), bounded by request.node_limit.
DistanceResult deformDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                              const DistanceRequest& request, Scratch& scratch, PairCache* cache);

/// sweptDistance() for pairs with at least one deforming mesh.
DistanceResult deformSweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const Shape& b, const DistanceRequest& request,
                                   Scratch& scratch, PairCache* cache);

}  // namespace leeway::collision
