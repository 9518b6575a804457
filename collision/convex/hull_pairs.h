#pragma once

#include "collision/convex/gjk/gjk.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Where a search stands that others must go on with: vertices of A and B, pairwise. With kInside
/// four of them are around the origin of the difference.
struct VertexStart {
  GjkEnd end = GjkEnd::kStagnated;
  int iterations = 0;
  int count = 0;  ///< 0: nothing is known
  int vertex_a[4], vertex_b[4];
};

/// The signed separation of two hulls that are apart, by GJK on their vertices straight from the
/// world poses, along the world's axes: no view, relative pose or simplex is made, and small hulls
/// are brought there once, in vector lanes. False, with nothing written to `result`, where that is
/// not enough: hulls in contact, large ones without a threshold or cache (for which B's frame is
/// quicker), sizes beyond the scale, tolerances below rounding, an iteration limit; `start` then
/// tells where the search ended. Both shapes are kConvexHull. Poses that are none give false. Cost
/// as distance().
bool answerHullPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceRequest& request, PairCache* cache, DistanceResult& result,
                    VertexStart& start);

}  // namespace leeway::collision
