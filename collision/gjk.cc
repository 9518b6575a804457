#include "collision/gjk.h"

namespace leeway::collision {

// Rounding of the two ends, in units of u L with u = kUnitRoundoff and L = extent A + extent B +
// |t|, X_BA taken as exact.
//
// Lower end, n . w of the support point w = b - (R p + t):
//   R^T n errs by 3 sqrt(3) u, so that p may be beaten by 2 * 5.2 extent A; the choice of p errs by
//   6 extent A R p errs by 3 sqrt(3) extent A, adding t by one unit of each the choice of b errs by
//   6 extent B b - a' errs by 1 L, the dot product by 3 L, n's length by 3 L
// in sum 29 extent A + 13 extent B + 8 |t|: kSupportRounding = 32 units of L cover it.
//
// Upper end, |v| with v a mean of up to four such w: R p + t 6.2 extent A + |t|, b - a' 1 L,
// support points may stand out by 3 L, weights whose sum is 1 within 4 units 4 L, the sum 3 L, the
// norm 3 L: less than 21 L.

namespace {

template <bool kSwept>
GjkEnd run(Difference<kSwept>& difference, const Vector& first_direction, Progress& progress,
           Simplex& simplex) {
  const CoreQuery& query = progress.query();
  const int limit = query.request.iteration_limit;
  Vector n = first_direction;
  double along_nearest = std::numeric_limits<double>::infinity();  // n . nearest
  double norm = 0;
  // The simplex's witness is written down once, at the end: it only gets nearer.
  const auto leave = [&](GjkEnd end) {
    if constexpr (!kSwept) {
      if (simplex.count > 0) progress.offerWitness(norm, simplex.nearest, simplex.pointOfA());
    }
    return end;
  };
  bool ask = simplex.count == 0;  // false: a simplex was handed over and comes first
  for (;; ask = true) {
    if (ask) {
      if (progress.iterations >= limit) return leave(GjkEnd::kLimit);
      ++progress.iterations;
      SupportPoint& s = simplex.free();
      difference.support(n, s);
      const double value = n.dot(s.w);
      progress.offerLower(value, n);
      if (progress.enough()) return leave(GjkEnd::kEnough);
      // Nothing beyond the simplex along n, to within rounding: further steps would chase noise.
      if (along_nearest - value <= 2 * query.roundoff) return leave(GjkEnd::kStagnated);

      const Reduction reduction = addAndReduce(simplex);
      if (reduction == Reduction::kNoProgress) return leave(GjkEnd::kStagnated);
      if (reduction == Reduction::kHoldsOrigin) {
        leave(GjkEnd::kInside);
        ++simplex.count;
        return GjkEnd::kInside;
      }
    }
    norm = std::sqrt(simplex.norm_squared);
    if constexpr (!kSwept) {
      progress.offerUpper(norm);
    } else {
      // A point of the swept hull is a point of a placement only when all its parts are of one.
      bool one_placement = true;
      for (int i = 1; i < simplex.count; ++i) {
        one_placement &= simplex.point(i).placement == simplex.point(0).placement;
      }
      if (one_placement) progress.offerWitness(norm, simplex.nearest, simplex.pointOfA());
      progress.offerSweptWitness(norm);
      // Nearer than the threshold as a hull: its lower end cannot come above it any more.
      if (norm - query.lower_offset <= query.request.threshold) return GjkEnd::kLimit;
    }
    if (progress.enough()) return leave(GjkEnd::kEnough);
    if (norm <= 4 * query.roundoff) return leave(GjkEnd::kInside);
    if (!simplex.has_normal) {
      n = simplex.nearest / norm;
    } else {
      n = simplex.feature_normal / simplex.feature_normal.norm();
      if (n.dot(simplex.nearest) < 0) n = -n;
    }
    along_nearest = n.dot(simplex.nearest);
  }
}

}  // namespace

GjkEnd runGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex) {
  return run(difference, direction, progress, simplex);
}

GjkEnd runGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex) {
  return run(difference, direction, progress, simplex);
}

}  // namespace leeway::collision
