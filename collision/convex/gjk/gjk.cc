#include "collision/convex/gjk/gjk.h"

#include <algorithm>
#include <limits>
#include <utility>

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

// For round cores: Newton's step in the place of GJK's. The lower end phi(n) = min over the
// difference of n . w is concave, and near its maximum over unit vectors it falls like 1/2 d . (K +
// phi) d for a turn d, with K the curvature of the cores at their support points; each point of the
// simplex adds a plane above phi. GJK's next direction is the maximum of these planes less 1/2 phi
// |d|^2: with K left out, it overshoots, and creeps where phi is small beside the radii. With T^T T
// = phi (K + phi)^-1 across n and 1 along it, the nearest point of T (simplex) gives the maximum
// with K counted in.
template <bool kSwept>
bool newtonScaling(const Difference<kSwept>& difference, const Vector& n, double phi,
                   Vector rows[3]) {
  if (!(phi > 0)) return false;
  Curvature a, b;
  difference.curvatures(n, a, b);
  const Vector helper = std::abs(n.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
  Vector u = cross(n, helper);
  u /= u.norm();
  const Vector v = cross(n, u);
  double uu = phi, uv = 0, vv = phi;
  for (const Curvature* k : {&a, &b}) {
    for (int i = 0; i < 2; ++i) {
      const double along_u = k->axis[i].dot(u), along_v = k->axis[i].dot(v);
      uu += k->strength[i] * along_u * along_u;
      uv += k->strength[i] * along_u * along_v;
      vv += k->strength[i] * along_v * along_v;
    }
  }
  // K + phi = L L^T; T = sqrt(phi) L^-1.
  const double l00 = std::sqrt(uu), l10 = uv / l00, rest = vv - l10 * l10;
  if (!(rest > 0)) return false;
  const double l11 = std::sqrt(rest), root = std::sqrt(phi);
  rows[0] = (root / l00) * u;
  rows[1] = (root / l11) * (v - (l10 / l00) * u);
  rows[2] = n;
  return true;
}

// Brings the planes of a Newton step up to date: each point of the simplex moves to where its
// pieces of the two surfaces are farthest along n. One that then is the newest point is dropped.
void followPieces(const Difference<false>& difference, const Vector& n, Simplex& simplex) {
  const int newest = simplex.slot[simplex.count];
  int kept = 0;
  for (int i = 0; i < simplex.count; ++i) {
    SupportPoint& s = simplex.points[simplex.slot[i]];
    const bool moved = difference.follow(n, s);
    const SupportPoint& last = simplex.points[newest];
    if (moved && s.index_a == last.index_a && s.index_b == last.index_b) continue;
    std::swap(simplex.slot[i], simplex.slot[kept]);
    ++kept;
  }
  for (int i = kept; i < 4; ++i) {
    if (simplex.slot[i] == newest) std::swap(simplex.slot[i], simplex.slot[kept]);
  }
  simplex.count = kept;
}

template <bool kSwept>
GjkEnd run(Difference<kSwept>& difference, const Vector& first_direction, Progress& progress,
           Simplex& simplex) {
  const CoreQuery& query = progress.query();
  const int limit = query.request.iteration_limit;
  Vector n = first_direction;
  double along_nearest = std::numeric_limits<double>::infinity();  // n . nearest
  double norm = 0;
  // (Sweeps mostly ask for a threshold, which the first few steps decide.)
  const bool round = !kSwept && difference.isRound();
  bool newton = false;
  // The simplex's witness is written down once, at the end, while it only gets nearer; Newton's
  // steps write down each.
  const auto leave = [&](GjkEnd end) {
    if constexpr (!kSwept) {
      if (!newton && simplex.count > 0) {
        progress.offerWitness(norm, simplex.nearest, simplex.pointOfA());
      }
    }
    return end;
  };
  // Newton's steps are for the end game: relative width from which they are tried, less after each
  // failure.
  double gate = kNewtonFrom;
  int failures = 0;
  int idle = 0;  // Newton steps that did not narrow the interval by much
  double width = std::numeric_limits<double>::infinity();
  // Back to plain steps, which cannot go wrong; what is known of the simplex is found anew in true
  // coordinates.
  const auto stopNewton = [&] {
    newton = false;
    idle = 0;
    gate = ++failures < kNewtonFailures ? kNewtonAgain * (progress.upper() - progress.lower()) /
                                              std::max(norm, query.roundoff)
                                        : 0;
    reduceAll(simplex, simplex.count);
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
      if (along_nearest - value <= 2 * query.roundoff) {
        if (!newton) return leave(GjkEnd::kStagnated);
        stopNewton();
        along_nearest = std::numeric_limits<double>::infinity();
        ask = false;
      }
    }
    if (ask) {
      Vector rows[3];
      const double value = n.dot(simplex.free().w);
      if (round && !newton && simplex.count > 0 && norm - value < gate * norm) {
        leave(GjkEnd::kLimit);
        newton = true;
      }
      const bool scaled = newton && simplex.count > 0 &&
                          newtonScaling(difference, n, std::max(value, 0.1 * norm), rows);
      if (newton && !scaled && simplex.count > 0) {
        // The new point waits in the first free slot, which the others may leave.
        const int before = simplex.count;
        stopNewton();
        std::swap(simplex.slot[simplex.count], simplex.slot[before]);
      }
      if constexpr (!kSwept) {
        if (scaled) followPieces(difference, n, simplex);
      }
      const Reduction reduction =
          scaled ? addAndReduceScaled(simplex, rows) : addAndReduce(simplex);
      if (reduction == Reduction::kNoProgress) return leave(GjkEnd::kStagnated);
      if (reduction == Reduction::kHoldsOrigin) {
        leave(GjkEnd::kInside);
        ++simplex.count;
        return GjkEnd::kInside;
      }
    }
    norm = std::sqrt(simplex.norm_squared);
    if constexpr (!kSwept) {
      if (!newton) {
        progress.offerUpper(norm);
      } else if (norm - query.upper_offset < progress.upper()) {
        progress.offerWitness(norm, simplex.nearest, simplex.pointOfA());
      }
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
    if (newton) {
      const double now = progress.upper() - progress.lower();
      idle = now < 0.5 * width ? 0 : idle + 1;
      width = std::min(width, now);
      if (idle > kIdleNewtonSteps) {
        stopNewton();
        norm = std::sqrt(simplex.norm_squared);
        if constexpr (!kSwept) progress.offerUpper(norm);
      }
    }
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
