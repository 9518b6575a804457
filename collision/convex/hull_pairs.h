#pragma once

#include "collision/convex/gjk/gjk.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Where a search ended that another takes over: vertices of A and B, pairwise. With kInside four
/// of them hold the origin of the difference.
struct VertexStart {
  GjkEnd end = GjkEnd::kStagnated;
  int iterations = 0;
  int count = 0;  ///< 0: nothing is known
  int vertex_a[4], vertex_b[4];
};

/// The signed separation of two hulls (kConvexHull) that are apart, by GJK on their vertices from
/// the world poses, in the world's axes: no view, relative pose or simplex is made, and small hulls
/// are placed once, in vector lanes. Cost as distance().
///
/// False, with nothing written to `result`, where that does not suffice: hulls in contact, large
/// ones without a threshold or cache (which are faster in B's frame), invalid poses, sizes out of
/// range, tolerances below rounding, an iteration limit. `start` then holds where the search ended.
bool answerHullPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceRequest& request, PairCache* cache, DistanceResult& result,
                    VertexStart& start);

}  // namespace leeway::collision
