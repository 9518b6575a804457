#include "collision/mesh_distance.h"

#include <algorithm>

#include "collision/containment.h"
#include "collision/descent_answer.h"
#include "collision/mesh_descent.h"
#include "collision/mesh_pair.h"
#include "collision/mesh_separation.h"
#include "collision/solid_depth.h"
#include "collision/vector.h"
#include "leeway/collision/tolerances.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

using Eigen::Vector3d;

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

// Lowers the upper end of an overlap by points that lie in both solids: near the deepest pair of
// triangles, in the middle of the hulls' overlap and in the middle of either body. Returns a way
// out.
Vector deepen(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
              const DistanceResult& hulls, Scratch& scratch, DistanceResult& result) {
  const auto isSolid = [](const Shape& s) {
    return s.isConvex() || s.mesh()->closedComponentCount() > 0;
  };
  if (!isSolid(a) || !isSolid(b)) return Vector::Zero();
  const Vector starts[] = {placed(X_WB, 0.5 * (hulls.point_a + hulls.point_b)),
                           0.5 * (result.point_a + result.point_b),
                           placed(X_WA, a.boundingCenter()), placed(X_WB, b.boundingCenter())};
  const SolidDepth found = solidDepth(a, X_WA, b, X_WB, starts, 4, scratch);
  if (found.depth > 0) result.distance.upper = std::min(result.distance.upper, -found.depth);
  return found.way_out;
}

}  // namespace

void separate(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
              const Vector& direction, const DistanceRequest& request, Scratch& scratch,
              DistanceResult& result) {
  separateMeshes(a, X_WA, b, X_WB, {&direction, 1}, request, scratch, result);
}

DistanceResult meshDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  const RelativePose relative = relativePose(X_WA, X_WB);
  if (!relative.valid) return {};
  DistanceResult at_once;
  if (spheresDecide(a, b, relative, X_WB, request, at_once)) return at_once;
  const DescentSide side_a = descentSide(a), side_b = descentSide(b);
  const DescentPlacement placement = placementOf(relative, side_a, side_b);
  PairCache own;
  PairCache& warm = cache != nullptr ? *cache : own;
  DescentResult found;
  if (takesPair(side_a, side_b, placement)) {
    found = descendPair(side_a, side_b, placement, request, scratch, &warm);
    remember(found, warm);
    if (found.upper <= 0 && request.depth && !deepensPair(side_a, side_b)) {
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

  DistanceResult result = surfaceDistance(found, X_WB);
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
        const Vector deepest = deepen(a, X_WA, b, X_WB, hulls, scratch, result);
        const Vector tries[] = {way_out, deepest};
        separateMeshes(a, X_WA, b, X_WB, tries, request, scratch, result);
      }
    }
  }
  result.status = statusOf(result.distance, request);
  return result;
}

DistanceResult meshSweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1,
                                 double growth, const Shape& b, const DistanceRequest& request,
                                 Scratch& scratch, PairCache* cache) {
  return sweptByDescent(a, X_BA0, X_BA1, growth, b, request, scratch, cache, descentSide, descend);
}

}  // namespace leeway::collision
