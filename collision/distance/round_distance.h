#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// distance() of a sphere or a capsule A from a deforming mesh B. The code is small, because other
/// work between queries evicts instructions. False if the question stays open, as in contact:
/// `cache` then has the nearest triangle, and `visited` is the number of nodes visited. With
/// `swapped`, the bodies are in the other order in the cache and in the result.
bool roundDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                   const DistanceRequest& request, Scratch& scratch, PairCache& cache, bool swapped,
                   DistanceResult& result, int& visited);

}  // namespace leeway::collision
