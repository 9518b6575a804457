#include <algorithm>
#include <cmath>

#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/convex_distance.h"
#include "collision/convex/hull_pairs.h"
#include "collision/convex/pairs/simple_answer.h"
#include "collision/distance/deform_distance.h"
#include "collision/distance/mesh_distance.h"
#include "collision/shapes/default_tolerance.h"
#include "leeway/collision/distance.h"

namespace leeway::collision {

namespace {

double finiteExtent(const ConvexView& view) {
  return view.core == Core::kHalfSpace ? 0 : view.extent;
}

// Replaces an ellipsoid whose semi-axes differ by a small part of the tolerance by a ball with a
// small excess. If such an ellipsoid is concentric with the other body, all directions are nearly
// equally deep and the search for the least depth does not converge. Thresholds are still compared
// with the ellipsoid itself. The extent stays that of the ellipsoid, because it bounds the effect
// of a pose whose rotation departs from orthogonality.
ConvexView ballOr(ConvexView view, const DistanceRequest& request) {
  if (view.core != Core::kEllipsoid) return view;
  const double least = view.size.minCoeff(), beyond = view.size.maxCoeff() - least;
  const bool nearly = std::isnan(request.threshold) && beyond <= kBallShare * request.tolerance &&
                      beyond <= kNearlyBall * least;
  if (!(beyond == 0 || nearly)) return view;
  view.core = Core::kPoint;
  view.size.setZero();
  view.radius = least;
  view.excess = beyond * kOutwards;
  return view;
}

// Spheres and capsules. Each pair has its own function, because a merged function would save
// registers that only the other pairs use, and answers would go through memory.
template <bool kSegmentA, bool kSegmentB>
__attribute__((noinline)) DistanceResult distanceOfSegments(const Shape& a, const Pose& X_WA,
                                                            const Shape& b, const Pose& X_WB,
                                                            const DistanceRequest& request,
                                                            Scratch& scratch, PairCache* cache) {
  const auto resultOf = [](const PairAnswer& found) __attribute__((always_inline)) {
    DistanceResult result;
    found.writeTo(result);
    return result;
  };
  PairAnswer found;
  if (answerSegments<kSegmentA, kSegmentB>(a, X_WA, b, X_WB, request, cache, found)) {
    return resultOf(found);
  }
  return generalDistance(a, X_WA, b, X_WB, request, scratch, cache);
}

// All other pairs.
__attribute__((noinline)) DistanceResult distanceOfOthers(const Shape& a, const Pose& X_WA,
                                                          const Shape& b, const Pose& X_WB,
                                                          const DistanceRequest& request,
                                                          Scratch& scratch, PairCache* cache) {
  // One named result, which is constructed in place in the caller.
  DistanceResult result;
  if (a.type() == ShapeType::kConvexHull && b.type() == ShapeType::kConvexHull) {
    VertexStart start;
    if (!answerHullPair(a, X_WA, b, X_WB, request, cache, result, start)) {
      result = generalDistance(a, X_WA, b, X_WB, request, scratch, cache, &start);
    }
  } else if (!answerBoxPair(a, X_WA, b, X_WB, request, cache, result)) {
    result = generalDistance(a, X_WA, b, X_WB, request, scratch, cache);
  }
  return result;
}

// Branches directly to one function for each pair, because every cache line of code in between is a
// miss if the caller has evicted it since the last query.
DistanceResult distanceOf(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                          const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  using enum ShapeType;
  static_assert(kSphere < kCapsule && kCapsule < kBox);
  if (std::max(a.type(), b.type()) <= kCapsule) {
    const bool segment_a = a.type() == kCapsule, segment_b = b.type() == kCapsule;
    if (segment_a && segment_b) {
      return distanceOfSegments<true, true>(a, X_WA, b, X_WB, request, scratch, cache);
    }
    if (segment_a) {
      return distanceOfSegments<true, false>(a, X_WA, b, X_WB, request, scratch, cache);
    }
    if (segment_b) {
      return distanceOfSegments<false, true>(a, X_WA, b, X_WB, request, scratch, cache);
    }
    return distanceOfSegments<false, false>(a, X_WA, b, X_WB, request, scratch, cache);
  }
  if (a.type() == kDeformable || b.type() == kDeformable)
    return deformDistance(a, X_WA, b, X_WB, request, scratch, cache);
  return distanceOfOthers(a, X_WA, b, X_WB, request, scratch, cache);
}

/// defaultTolerance() of two shapes whose frames are `offset` apart [m].
double toleranceOf(const Shape& a, const Shape& b, const Eigen::Vector3d& offset) {
  const double least = (kDefaultLeastShare * offset).lpNorm<1>() + kLeastSum,
               tolerance = std::max(std::max(a.defaultTolerance(), b.defaultTolerance()), least);
  // 0 for NaN and infinity, because any interval would meet an infinite tolerance.
  return least < std::numeric_limits<double>::infinity() ? tolerance : 0;
}

}  // namespace

double defaultTolerance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return toleranceOf(a, b, X_WB.translation - X_WA.translation);
}

DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  if (!std::isnan(request.tolerance)) {
    return distanceOf(a, X_WA, b, X_WB, request, scratch, cache);
  }
  const Eigen::Vector3d offset = X_WB.translation - X_WA.translation;
  return distanceOf(a, X_WA, b, X_WB, withTolerance(request, toleranceOf(a, b, offset)), scratch,
                    cache);
}

DistanceResult generalDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                               const DistanceRequest& request, Scratch& scratch, PairCache* cache,
                               const VertexStart* start) {
  if (a.type() == ShapeType::kDeformable || b.type() == ShapeType::kDeformable) {
    return deformDistance(a, X_WA, b, X_WB, request, scratch, cache);
  }
  if (!a.isConvex() || !b.isConvex()) {
    return meshDistance(a, X_WA, b, X_WB, request, scratch, cache);
  }
  const RelativePose relative = relativePose(X_WA, X_WB);
  if (!relative.valid) return {};
  const ConvexView view_a = ballOr(viewOf(a), request), view_b = ballOr(viewOf(b), request);
  const double slack = relative.slack * (finiteExtent(view_a) + finiteExtent(view_b) +
                                         relative.X_BA.translation.norm());
  DistanceResult result =
      convexDistance(view_a, relative.X_BA, view_b, request, scratch, cache, slack, start);
  result.point_a = placed(X_WB, result.point_a);
  result.point_b = placed(X_WB, result.point_b);
  result.normal = rotated(X_WB.rotation, result.normal);
  return result;
}

DistanceResult sweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1, double growth,
                             const Shape& b, const DistanceRequest& request, Scratch& scratch,
                             PairCache* cache) {
  if (std::isnan(request.tolerance)) {
    return sweptDistance(a, X_BA0, X_BA1, growth, b,
                         withTolerance(request, toleranceOf(a, b, X_BA0.translation)), scratch,
                         cache);
  }
  if (a.type() == ShapeType::kDeformable || b.type() == ShapeType::kDeformable) {
    return deformSweptDistance(a, X_BA0, X_BA1, growth, b, request, scratch, cache);
  }
  if (!a.isConvex() || !b.isConvex()) {
    return meshSweptDistance(a, X_BA0, X_BA1, growth, b, request, scratch, cache);
  }
  const RelativePose pose0 = relativePose(X_BA0, {}), pose1 = relativePose(X_BA1, {});
  // A NaN fails this comparison.
  if (!pose0.valid || !pose1.valid || !(growth >= 0)) return {};
  const ConvexView view_a = viewOf(a), view_b = viewOf(b);
  const double slack = std::max(pose0.slack, pose1.slack) * finiteExtent(view_a);
  return convexSweptDistance(view_a, X_BA0, X_BA1, growth, view_b, request, scratch, cache, slack);
}

DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request) {
  Scratch scratch;
  return distance(a, X_WA, b, X_WB, request, scratch);
}

}  // namespace leeway::collision
