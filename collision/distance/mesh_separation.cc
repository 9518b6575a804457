#include "collision/distance/mesh_separation.h"

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/distance/leaning.h"
#include "leeway/collision/distance.h"

namespace leeway::collision {
namespace {

class Search {
 public:
  Search(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
         const DistanceRequest& request, Scratch& scratch, DistanceResult& result)
      : a_(a),
        b_(b),
        X_WA_(X_WA),
        X_WB_(X_WB),
        tolerance_(request.tolerance),
        scratch_(scratch),
        result_(result) {
    // Finer than what is asked for is of no use; bodies may be smaller than a nanometre.
    apart_.tolerance = std::min(kDefaultTolerance, request.tolerance);
    apart_.threshold = 0;
    apart_.depth = false;
    apart_.node_limit = std::min(request.node_limit, kSeparationNodes);
    rounding_ = 16 * kUnitRoundoff * (X_WB.translation.norm() + X_WA.translation.norm());
    least_ = std::max(-result.distance.upper, 0.0);
  }

  void run(std::span<const Vector> tries) {
    // The hulls' way out is known to do; along it as along the others, shorter ones may.
    for (const Vector& direction : tries) {
      if (direction.norm() > 0) outwards(direction / direction.norm());
    }
    outwards(Vector(result_.normal));  // a copy: what is found takes its place
    for (double angle = kSeparationFirstTurn; angle > kSeparationLastTurn && !good();
         angle *= 0.5) {
      while (!good() && turned(angle)) {
      }
    }
  }

 private:
  double length() const { return -result_.distance.lower; }
  bool good() const { return !(length() - least_ > tolerance_) || queries_ >= kSeparationQueries; }

  bool separates(double length, const Vector& unit) {
    if (queries_ >= kSeparationQueries) return false;
    ++queries_;
    Pose moved = X_WB_;
    moved.translation += length * unit;
    const DistanceResult r = distance(a_, X_WA_, b_, moved, apart_, scratch_, &cache_);
    result_.iterations += r.iterations;
    if (!(r.distance.lower > 0)) return false;
    // The length moved, with the rounding of the sum.
    const double lower = -(length * (1 + 8 * kUnitRoundoff) + rounding_);
    if (lower > result_.distance.lower) {
      result_.distance.lower = lower;
      result_.normal = unit;
    }
    return true;
  }

  // Lengths are multiplied from the least that can do, then halved back.
  void outwards(const Vector& unit) {
    double fails = least_, next = least_ * (1 + 1e-6) + std::max(tolerance_, rounding_);
    // In short steps at first: what is needed at least often is nearly enough.
    double factor = 1.1;
    for (int step = 0; step < kSeparationSteps && next < length() && !good();
         ++step, next *= factor) {
      factor = std::min(1.3 * factor, 4.0);
      if (separates(next, unit)) {
        halve(fails, next, unit);
        return;
      }
      fails = next;
    }
    if (unit == result_.normal) halve(fails, length(), unit);
  }

  void halve(double fails, double does, const Vector& unit) {
    for (int half = 0; half < kSeparationHalvings && does - fails > tolerance_ && !good(); ++half) {
      const double middle = 0.5 * (fails + does);
      (separates(middle, unit) ? does : fails) = middle;
    }
  }

  // Whether a direction at this angle does with less.
  bool turned(double angle) {
    const Vector d = result_.normal;
    const double trial = std::max(length() * (1 - kSeparationGain * angle), least_);
    for (int k = 0; k < 6 && !good(); ++k) {
      const Vector other = leaning(d, angle, k, 6);
      if (!separates(trial, other)) continue;
      double fails = least_, does = trial;
      for (int half = 0; half < 3 && !good(); ++half) {
        const double middle = 0.5 * (fails + does);
        (separates(middle, other) ? does : fails) = middle;
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
  Search(a, X_WA, b, X_WB, request, scratch, result).run(tries);
}

}  // namespace leeway::collision
