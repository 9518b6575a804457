#include "collision/mesh_distance.h"

#include <algorithm>
#include <limits>

#include "collision/containment.h"
#include "collision/mesh_descent.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The order is that of DistanceStatus's own documentation: what was asked most precisely comes
// first.
DistanceStatus statusOf(const Interval& distance, const DistanceRequest& request) {
  if (distance.width() <= request.tolerance) return DistanceStatus::kConverged;
  if (distance.lower > request.threshold) return DistanceStatus::kAboveThreshold;
  if (distance.upper <= request.threshold) return DistanceStatus::kNotAboveThreshold;
  if (!request.depth && distance.upper <= 0) return DistanceStatus::kOverlap;
  return DistanceStatus::kLimit;
}

ConvexView hullOf(const DescentSide& side) {
  return side.tree != nullptr ? side.tree->hullView() : side.view;
}

double slackOf(const RelativePose& relative, const DescentSide& a, const DescentSide& b) {
  const double extent_a = a.extent < kInfinity ? a.extent : 0,
               extent_b = b.extent < kInfinity ? b.extent : 0;
  return relative.slack * (extent_a + extent_b + relative.X_BA.translation.norm());
}

void remember(const DescentResult& found, PairCache& cache) {
  if (found.witness.triangle_a >= 0 || found.witness.triangle_b >= 0) {
    cache.triangle_a = found.witness.triangle_a;
    cache.triangle_b = found.witness.triangle_b;
  }
}

}  // namespace

DistanceResult meshDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  const RelativePose relative = relativePose(X_WA, X_WB);
  if (!relative.valid) return {};
  const DescentSide side_a = descentSide(a), side_b = descentSide(b);
  DescentPlacement placement;
  placement.X_BA0 = placement.X_BA1 = relative.X_BA;
  placement.slack = slackOf(relative, side_a, side_b);
  PairCache own;
  PairCache& warm = cache != nullptr ? *cache : own;
  const DescentResult found = descend(side_a, side_b, placement, request, scratch, &warm);
  remember(found, warm);

  DistanceResult result = found.witness;
  result.iterations = found.iterations;
  result.distance = {std::max(found.lower, found.hull_lower), found.upper};
  if (!(found.hull_lower > 0)) {
    // Hulls that meet say nothing yet: the surfaces may be apart, with one body inside the other,
    // or overlap, and then only a translation that separates the hulls is known to separate the
    // bodies.
    bool separate = false;
    if (found.lower > 0) {
      const Containment containment = containsAt(a, X_WA, b, X_WB, found.lower, scratch);
      separate = containment == Containment::kNo;
      // What is inside has to come through the surface, which is that far away.
      if (containment == Containment::kYes) result.distance.upper = -found.lower;
    }
    if (!separate) {
      result.distance.lower = found.hull_lower;
      if (request.depth && !(result.distance.upper <= request.threshold)) {
        DistanceRequest depth = request;
        const DistanceResult hulls = convexDistance(hullOf(side_a), relative.X_BA, hullOf(side_b),
                                                    depth, scratch, nullptr, placement.slack);
        result.iterations += hulls.iterations;
        result.distance.lower = std::max(result.distance.lower, hulls.distance.lower);
        result.normal = hulls.normal;
        if (found.lower > 0 && result.distance.upper <= 0) {
          result.point_a = hulls.point_a;
          result.point_b = hulls.point_b;
          result.triangle_a = result.triangle_b = -1;
        }
      }
    }
  }
  result.status = statusOf(result.distance, request);
  result.point_a = X_WB * result.point_a;
  result.point_b = X_WB * result.point_b;
  result.normal = X_WB.rotation * result.normal;
  return result;
}

DistanceResult meshSweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1,
                                 double growth, const Shape& b, const DistanceRequest& request,
                                 Scratch& scratch, PairCache* cache) {
  const RelativePose begin = relativePose(X_BA0, Pose{}), end = relativePose(X_BA1, Pose{});
  if (!begin.valid || !end.valid || !(growth >= 0)) return {};  // written so that a NaN fails
  const DescentSide side_a = descentSide(a), side_b = descentSide(b);
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
  // Below zero the pieces say nothing about the whole; its hull may.
  result.distance.lower =
      found.lower > 0 ? std::max(found.lower, found.hull_lower) : found.hull_lower;
  result.distance.upper = found.upper;
  result.status = statusOf(result.distance, request);
  return result;
}

}  // namespace leeway::collision
