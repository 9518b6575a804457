#pragma once

// Private to collision/: distance() and sweptDistance() where a deforming mesh is one of the
// bodies.

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

DistanceResult deformDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                              const DistanceRequest& request, Scratch& scratch, PairCache* cache);

DistanceResult deformSweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const Shape& b, const DistanceRequest& request,
                                   Scratch& scratch, PairCache* cache);

}  // namespace leeway::collision
