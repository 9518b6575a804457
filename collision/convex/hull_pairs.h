#pragma once

#include "collision/convex/gjk/gjk.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The end of a search that another one continues: vertices of A and B, pairwise. With kInside,
/// four of them hold the origin of the difference.
struct VertexStart {
  GjkEnd end = GjkEnd::kStagnated;
  int iterations = 0;
  int count = 0;  ///< 0: no vertices are known
  int vertex_a[4], vertex_b[4];
};

/// The signed separation of two hulls (kConvexHull) that are apart, by GJK on their vertices from
/// the world poses, in the world's axes. It makes no view, relative pose or simplex, and places
/// small hulls once, in vector lanes. Cost as for distance().
///
/// Returns false, with `result` unchanged, if that does not suffice: hulls in contact, large hulls
/// without a threshold or cache (which are faster in B's frame), invalid poses, sizes out of range,
/// tolerances below rounding, an iteration limit. `start` then holds the end of the search.
bool answerHullPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceRequest& request, PairCache* cache, DistanceResult& result,
                    VertexStart& start);

}  // namespace leeway::collision
