#include "collision/mesh_distance.h"

#include <algorithm>
#include <limits>

#include "collision/containment.h"
#include "collision/mesh_descent.h"
#include "collision/mesh_pair.h"
#include "collision/vector.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

// The order is that of DistanceStatus's own documentation: what was asked most precisely comes
// first.
DistanceStatus statusOf(const Interval& distance, const DistanceRequest& request) {
  if (distance.width() <= request.tolerance) return DistanceStatus::kConverged;
  if (distance.lower > request.threshold) return DistanceStatus::kAboveThreshold;
  if (distance.upper <= request.threshold) return DistanceStatus::kNotAboveThreshold;
  if (!request.depth && distance.upper <= 0) return DistanceStatus::kOverlap;
  return DistanceStatus::kLimit;
}

namespace {

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

// Whether the spheres around both bodies already are farther apart than the threshold: most pairs
// of a scene end here.
bool spheresDecide(const Shape& a, const Shape& b, const RelativePose& relative, const Pose& X_WB,
                   const DistanceRequest& request, DistanceResult& result) {
  const Vector gap = b.boundingCenter() - placed(relative.X_BA, a.boundingCenter());
  const double norm = gap.norm(), radii = a.boundingRadius() + b.boundingRadius();
  const double rounding = (relative.slack + kRelativeRounding) * (a.extent() + b.extent() + norm);
  const double lower = norm - radii - rounding;
  // Written so that a NaN, of infinite sizes, too, decides nothing.
  if (!(lower > request.threshold && lower > 0)) return false;
  result.distance.lower = lower;
  result.normal = rotated(X_WB.rotation, gap / norm);
  result.status = DistanceStatus::kAboveThreshold;
  return true;
}

}  // namespace

// Lengths are multiplied by four from the least that can do, then halved back a few times.
void separate(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
              const Vector3d& direction, const DistanceRequest& request, Scratch& scratch,
              DistanceResult& result) {
  const double norm = direction.norm();
  if (!(norm > 0) || !(result.distance.width() > request.tolerance)) return;
  const Vector3d unit = direction / norm;
  const double rounding = 16 * kUnitRoundoff * (X_WB.translation.norm() + X_WA.translation.norm());
  DistanceRequest apart;
  apart.threshold = 0;
  apart.depth = false;
  apart.node_limit = std::min(request.node_limit, kSeparationNodes);
  const auto separates = [&](double length) {
    Pose moved = X_WB;
    moved.translation += length * unit;
    const DistanceResult r = distance(a, X_WA, b, moved, apart, scratch, nullptr);
    result.iterations += r.iterations;
    if (!(r.distance.lower > 0)) return false;
    // The length moved, with the rounding of the sum.
    const double lower = -(length * (1 + 8 * kUnitRoundoff) + rounding);
    if (lower > result.distance.lower) {
      result.distance.lower = lower;
      result.normal = unit;
    }
    return true;
  };
  const double least = std::max(-result.distance.upper, 0.0);
  double fails = least, length = least * (1 + 1e-6) + std::max(request.tolerance, rounding);
  for (int step = 0; step < kSeparationSteps && length < -result.distance.lower;
       ++step, length *= 4) {
    if (!separates(length)) {
      fails = length;
      continue;
    }
    for (int half = 0; half < kSeparationHalvings && length - fails > request.tolerance; ++half) {
      const double middle = 0.5 * (fails + length);
      (separates(middle) ? length : fails) = middle;
    }
    return;
  }
}

DistanceResult meshDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  const RelativePose relative = relativePose(X_WA, X_WB);
  if (!relative.valid) return {};
  DistanceResult at_once;
  if (spheresDecide(a, b, relative, X_WB, request, at_once)) return at_once;
  const DescentSide side_a = descentSide(a), side_b = descentSide(b);
  DescentPlacement placement;
  placement.X_BA0 = placement.X_BA1 = relative.X_BA;
  placement.slack = slackOf(relative, side_a, side_b);
  PairCache own;
  PairCache& warm = cache != nullptr ? *cache : own;
  DescentResult found;
  if (takesPair(side_a, side_b, placement)) {
    found = descendPair(side_a, side_b, placement, request, scratch, &warm);
    remember(found, warm);
    if (found.upper <= 0 && request.depth) {
      const double lower = found.lower;
      const int iterations = found.iterations;
      found = descend(side_a, side_b, placement, request, scratch, &warm);
      found.lower = std::max(found.lower, lower);
      found.iterations += iterations;
    }
  } else {
    found = descend(side_a, side_b, placement, request, scratch, &warm);
  }
  remember(found, warm);

  DistanceResult result = found.witness;
  result.iterations = found.iterations;
  result.distance = {std::max(found.lower, found.hull_lower), found.upper};
  result.point_a = X_WB * result.point_a;
  result.point_b = X_WB * result.point_b;
  result.normal = X_WB.rotation * result.normal;
  // Hulls that meet say nothing yet: the surfaces may be apart, with one body inside the other, or
  // overlap.
  if (!(found.hull_lower > 0)) {
    Containment containment = Containment::kUndecided;
    if (found.lower > 0) containment = containsAt(a, X_WA, b, X_WB, found.lower, scratch);
    if (containment != Containment::kNo) {
      // What is inside has to come through the surface, which is that far away.
      if (containment == Containment::kYes) result.distance.upper = -found.lower;
      result.distance.lower = found.hull_lower;
      if (request.depth && !(result.distance.upper <= request.threshold)) {
        const DistanceResult hulls = convexDistance(hullOf(side_a), relative.X_BA, hullOf(side_b),
                                                    request, scratch, nullptr, placement.slack);
        result.iterations += hulls.iterations;
        result.distance.lower = std::max(result.distance.lower, hulls.distance.lower);
        const Vector3d way_out = containment == Containment::kYes
                                     ? Vector3d(result.point_a - result.point_b)
                                     : result.normal;
        result.normal = X_WB.rotation * hulls.normal;
        separate(a, X_WA, b, X_WB, way_out, request, scratch, result);
      }
    }
  }
  result.status = statusOf(result.distance, request);
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
