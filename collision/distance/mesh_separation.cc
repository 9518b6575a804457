#include "collision/distance/mesh_separation.h"

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/convex_distance.h"
#include "collision/distance/cone_direction.h"
#include "collision/solids/common_point.h"
#include "collision/solids/contains_at.h"
#include "collision/solids/solid_depth.h"
#include "leeway/collision/distance.h"

namespace leeway::collision {
namespace {

class TranslationSearch {
 public:
  TranslationSearch(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceRequest& request, Scratch& scratch, DistanceResult& result)
      : a_(a),
        b_(b),
        X_WA_(X_WA),
        X_WB_(X_WB),
        tolerance_(request.tolerance),
        scratch_(scratch),
        result_(result) {
    // The bodies may be smaller than the default tolerance.
    apart_.tolerance = std::min(kDefaultTolerance, request.tolerance);
    apart_.threshold = 0;
    apart_.depth = false;
    apart_.node_limit = std::min(request.node_limit, kSeparationNodes);
    rounding_ = 16 * kUnitRoundoff * (X_WB.translation.norm() + X_WA.translation.norm());
    least_ = std::max(-result.distance.upper, 0.0);
  }

  void run(std::span<const Vector> tries) {
    for (const Vector& direction : tries) {
      if (direction.norm() > 0) searchAlong(direction / direction.norm());
    }
    // A shorter translation along the hulls' separating direction may separate the meshes. A copy,
    // because a better result replaces the normal.
    searchAlong(Vector(result_.normal));
    for (double angle = kSeparationFirstTurn; angle > kSeparationLastTurn && !isDone();
         angle *= 0.5) {
      while (!isDone() && turn(angle)) {
      }
    }
  }

 private:
  double length() const { return -result_.distance.lower; }
  bool isDone() const {
    return !(length() - least_ > tolerance_) || queries_ >= kSeparationQueries;
  }

  bool separates(double length, const Vector& unit) {
    if (queries_ >= kSeparationQueries) return false;
    ++queries_;
    Pose moved = X_WB_;
    moved.translation += length * unit;
    const DistanceResult r = distance(a_, X_WA_, b_, moved, apart_, scratch_, &cache_);
    result_.iterations += r.iterations;
    if (!(r.distance.lower > 0)) return false;
    // The length rounded up, plus the rounding of the moved translation.
    const double lower = -(length * (1 + 8 * kUnitRoundoff) + rounding_);
    if (lower > result_.distance.lower) {
      result_.distance.lower = lower;
      result_.normal = unit;
    }
    return true;
  }

  // Lengths increase from the least that can separate; then bisection.
  void searchAlong(const Vector& unit) {
    double too_short = least_, next = least_ * (1 + 1e-6) + std::max(tolerance_, rounding_);
    // Short steps first, because the proven least length is often nearly enough.
    double factor = 1.1;
    for (int step = 0; step < kSeparationSteps && next < length() && !isDone();
         ++step, next *= factor) {
      factor = std::min(1.3 * factor, 4.0);
      if (separates(next, unit)) {
        bisect(too_short, next, unit);
        return;
      }
      too_short = next;
    }
    if (unit == result_.normal) bisect(too_short, length(), unit);
  }

  void bisect(double too_short, double enough, const Vector& unit) {
    for (int i = 0; i < kSeparationHalvings && enough - too_short > tolerance_ && !isDone(); ++i) {
      const double middle = 0.5 * (too_short + enough);
      (separates(middle, unit) ? enough : too_short) = middle;
    }
  }

  // Whether a shorter translation at this angle separates.
  bool turn(double angle) {
    const Vector axis = result_.normal;
    const double trial = std::max(length() * (1 - kSeparationGain * angle), least_);
    for (int k = 0; k < 6 && !isDone(); ++k) {
      const Vector other = coneDirection(axis, angle, k, 6);
      if (!separates(trial, other)) continue;
      double too_short = least_, enough = trial;
      for (int i = 0; i < 3 && !isDone(); ++i) {
        const double middle = 0.5 * (too_short + enough);
        (separates(middle, other) ? enough : too_short) = middle;
      }
      return true;
    }
    return false;
  }

  const Shape& a_;
  const Shape& b_;
  const Pose& X_WA_;
  const Pose& X_WB_;
  double tolerance_;
  Scratch& scratch_;
  DistanceResult& result_;
  DistanceRequest apart_;
  PairCache cache_;
  double rounding_ = 0, least_ = 0;  // [m]
  int queries_ = 0;
};

}  // namespace

void separateMeshes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    std::span<const Vector> tries, const DistanceRequest& request, Scratch& scratch,
                    DistanceResult& result) {
  if (!(result.distance.width() > request.tolerance)) return;
  TranslationSearch(a, X_WA, b, X_WB, request, scratch, result).run(tries);
}

void decideOverlap(const MeetingBodies& bodies, double surface_lower, double hull_lower,
                   const DistanceRequest& request, Scratch& scratch, DistanceResult& result) {
  const auto& [a, X_WA, b, X_WB, relative, outer_a, outer_b, slack] = bodies;
  Containment containment = Containment::kUndecided;
  if (surface_lower > 0) containment = containsAt(a, X_WA, b, X_WB, surface_lower, scratch);
  if (containment == Containment::kNo) return;
  // A body inside must come out through the surface, so its depth is at least the distance to the
  // surface.
  if (containment == Containment::kYes) result.distance.upper = -surface_lower;
  if (containment == Containment::kUndecided)
    offerCommonPoint(a, b, relative, X_WB, request, scratch, result);
  result.distance.lower = hull_lower;
  if (!request.depth || result.distance.upper <= request.threshold) return;
  const Vector way_out = containment == Containment::kYes ? Vector(result.point_a - result.point_b)
                                                          : Vector(result.normal);
  // A translation that separates the convex bodies around both also separates both. (Convex meshes
  // are as deep as their hulls.)
  const DistanceResult outer =
      convexDistance(outer_a, relative.X_BA, outer_b, request, scratch, nullptr, slack);
  result.iterations += outer.iterations;
  result.distance.lower = std::max(result.distance.lower, outer.distance.lower);
  result.normal = X_WB.rotation * outer.normal;
  if (!(result.distance.width() > request.tolerance)) return;
  const Vector middle = placed(X_WB, 0.5 * (outer.point_a + outer.point_b));
  const Vector deepest = deepen(a, X_WA, b, X_WB, middle, request, scratch, result);
  const Vector tries[] = {way_out, deepest};
  separateMeshes(a, X_WA, b, X_WB, tries, request, scratch, result);
}

}  // namespace leeway::collision
