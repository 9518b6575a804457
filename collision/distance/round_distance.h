#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// distance() of a sphere or a capsule A from a deforming mesh B, with little code: it is far when
/// much else has been done since the last query. False where the question is still open, as in
/// contact; `cache` has the triangle that is nearest then, and `visited` says how many nodes have
/// been looked at. With `turned`, the bodies come the other way round in the cache and in the
/// result.
bool roundDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                   const DistanceRequest& request, Scratch& scratch, PairCache& cache, bool turned,
                   DistanceResult& result, int& visited);

}  // namespace leeway::collision
