#pragma once

// Private to collision/: turns a request into a descent, and its result into an answer, for rigid
// and deforming meshes. A side is a DescentSide or a DeformSide.

#include <algorithm>
#include <cmath>

#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// The magnitude that rounding is relative to: the sum of the bodies' extents and the distance of
/// their frames [m]. The infinite extent of a half-space is omitted.
template <class Side>
double scaleOf(const Pose& X_BA, const Side& a, const Side& b) {
  const auto finite = [](double extent) { return std::isfinite(extent) ? extent : 0; };
  return finite(a.extent) + finite(b.extent) + X_BA.translation.norm();
}

/// Upper bound on how far rounding of the poses moves points of the bodies relative to each other
/// [m].
template <class Side>
double slackOf(const RelativePose& relative, const Side& a, const Side& b) {
  return relative.slack * (scaleOf(relative.X_BA, a, b) + kLeastSum);
}

/// The placement of A for a query at rest.
template <class Side>
DescentPlacement placementOf(const RelativePose& relative, const Side& a, const Side& b) {
  DescentPlacement placement;
  placement.X_BA0 = placement.X_BA1 = relative.X_BA;
  placement.slack = slackOf(relative, a, b);
  return placement;
}

/// The distance within which points of two bodies count as touching [m]: a few times the rounding
/// of their distance.
template <class Side>
double touchingWithin(const DescentPlacement& placement, const Side& a, const Side& b) {
  return 4 * (kSupportRounding * kUnitRoundoff * scaleOf(placement.X_BA0, a, b) + placement.slack);
}

/// Stores the nearest triangles for the next query.
inline void remember(const DescentResult& found, PairCache& cache) {
  if (found.witness.triangle_a >= 0 || found.witness.triangle_b >= 0) {
    cache.triangle_a = found.witness.triangle_a;
    cache.triangle_b = found.witness.triangle_b;
  }
}

/// The distance of the surfaces, with points and normal in W, without a status.
inline DistanceResult surfaceDistance(const DescentResult& found, const Pose& X_WB) {
  DistanceResult result = found.witness;
  result.iterations = found.iterations;
  result.distance = {std::max(found.lower, found.hull_lower), found.upper};
  result.point_a = X_WB * result.point_a;
  result.point_b = X_WB * result.point_b;
  result.normal = X_WB.rotation * result.normal;
  return result;
}

/// sweptDistance() by `descend`, which has the arguments of descend().
template <class SideOf, class Descend>
DistanceResult sweptByDescent(const Shape& a, const Pose& X_BA0, const Pose& X_BA1, double growth,
                              const Shape& b, const DistanceRequest& request, Scratch& scratch,
                              PairCache* cache, const SideOf& sideOf, const Descend& descend) {
  const RelativePose begin = relativePose(X_BA0, Pose{}), end = relativePose(X_BA1, Pose{});
  if (!begin.valid || !end.valid || !(growth >= 0)) return {};  // NaN, too
  const auto side_a = sideOf(a), side_b = sideOf(b);
  DescentPlacement placement;
  placement.X_BA0 = X_BA0;
  placement.X_BA1 = X_BA1;
  placement.swept = true;
  placement.growth = growth;
  placement.slack = std::max(slackOf(begin, side_a, side_b), slackOf(end, side_a, side_b));
  PairCache own;
  PairCache& warm = cache != nullptr ? *cache : own;
  const DescentResult found = descend(side_a, side_b, placement, request, scratch, &warm);
  remember(found, warm);

  DistanceResult result = found.witness;
  result.iterations = found.iterations;
  // Below 0, pieces bound only themselves; the bound on hulls or boxes still holds.
  result.distance.lower =
      found.lower > 0 ? std::max(found.lower, found.hull_lower) : found.hull_lower;
  result.distance.upper = found.upper;
  result.status = statusOf(result.distance, request);
  return result;
}

}  // namespace leeway::collision
