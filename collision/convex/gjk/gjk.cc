#include "collision/convex/gjk/gjk.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "collision/convex/gjk/newton_step.h"

namespace leeway::collision {

// clang-format off
// Rounding of the two ends, in units of u L with u = kUnitRoundoff and L = extent A + extent B + |t|.
// X_BA is taken as exact.
//
// Lower end, n . w of the support point w = b - (R p + t):
//   R^T n errs by 3 sqrt(3) u: another point may beat p by              2 * 5.2 extent A
//   the choice of p                                                     6 extent A
//   R p                                                                 3 sqrt(3) extent A
//   adding t                                                            1 extent A + 1 |t|
//   the choice of b                                                     6 extent B
//   b - a'                                                              1 L
//   the dot product                                                     3 L
//   the length of n                                                     3 L
// In sum 29 extent A + 13 extent B + 8 |t|: kSupportRounding = 32 units of L cover it.
//
// Upper end, |v| with v a mean of up to four such w:
//   R p + t                                                             6.2 extent A + |t|
//   b - a'                                                              1 L
//   support points protrude from their cores                            3 L
//   weights, whose sum is 1 within 4 units                              4 L
//   the sum                                                             3 L
//   the norm                                                            3 L
// In sum less than 21 L.
// clang-format on

namespace {

template <bool kSwept>
class Gjk {
 public:
  Gjk(Difference<kSwept>& difference, Progress& progress, Simplex& simplex)
      : difference_(difference),
        progress_(progress),
        query_(progress.query()),
        simplex_(simplex),
        round_(difference.isRound()) {}

  GjkEnd run(const Vector& first_direction);

 private:
  GjkEnd leave(GjkEnd end);
  double askPlane();
  Reduction takePoint(double value);
  bool scale(double value, Vector rows[3]);
  void offerNearest();
  bool offerSweptNearest();
  void stopNewton();
  void stopIdleNewton();
  void chooseDirection();

  Difference<kSwept>& difference_;
  Progress& progress_;
  const CoreQuery& query_;
  Simplex& simplex_;
  const bool round_;
  Vector n_;
  double along_nearest_ = std::numeric_limits<double>::infinity();  // n . nearest
  double norm_ = 0;                                                 // of nearest
  // Newton steps are for the last digits. gate_ is the relative width below which they are tried;
  // it shrinks after each failure. Sweeps do not use them, because the first few steps decide their
  // threshold.
  bool newton_ = false;
  double gate_ = kNewtonFrom;
  int failures_ = 0;
  int idle_ = 0;  // Newton steps that hardly narrowed the interval
  double width_ = std::numeric_limits<double>::infinity();
};

// GJK's steps only come closer, so their witness is written once, at the end. Newton steps write
// each of theirs.
template <bool kSwept>
GjkEnd Gjk<kSwept>::leave(GjkEnd end) {
  if constexpr (!kSwept) {
    if (!newton_ && simplex_.count > 0) {
      progress_.offerWitness(norm_, simplex_.nearest, simplex_.pointOfA());
    }
  }
  return end;
}

// Finds the support point along n, in the simplex's free slot; returns n . w.
template <bool kSwept>
double Gjk<kSwept>::askPlane() {
  ++progress_.iterations;
  SupportPoint& s = simplex_.free();
  difference_.support(n_, s);
  const double value = n_.dot(s.w);
  progress_.offerLower(value, n_);
  return value;
}

// Returns to GJK's steps, which always converge: the simplex is reduced again in true coordinates.
template <bool kSwept>
void Gjk<kSwept>::stopNewton() {
  newton_ = false;
  idle_ = 0;
  gate_ = ++failures_ < kNewtonFailures ? kNewtonAgain * (progress_.upper() - progress_.lower()) /
                                              std::max(norm_, query_.roundoff)
                                        : 0;
  reduceAll(simplex_, simplex_.count);
}

template <bool kSwept>
void Gjk<kSwept>::stopIdleNewton() {
  const double now = progress_.upper() - progress_.lower();
  idle_ = now < 0.5 * width_ ? 0 : idle_ + 1;
  width_ = std::min(width_, now);
  if (idle_ <= kIdleNewtonSteps) return;
  stopNewton();
  norm_ = std::sqrt(simplex_.norm_squared);
  progress_.offerUpper(norm_);
}

// Starts, continues or stops Newton steps; true if the next reduction is to be scaled.
template <bool kSwept>
bool Gjk<kSwept>::scale(double value, Vector rows[3]) {
  if constexpr (!kSwept) {
    if (round_ && !newton_ && simplex_.count > 0 && norm_ - value < gate_ * norm_) {
      leave(GjkEnd::kLimit);
      newton_ = true;
    }
    if (!newton_ || simplex_.count == 0) return false;
    if (newtonScaling(difference_, n_, std::max(value, 0.1 * norm_), rows)) {
      followPieces(difference_, n_, simplex_);
      return true;
    }
    // The new point is in the first free slot, which the reduction may move.
    const int before = simplex_.count;
    stopNewton();
    std::swap(simplex_.slot[simplex_.count], simplex_.slot[before]);
  }
  return false;
}

template <bool kSwept>
Reduction Gjk<kSwept>::takePoint(double value) {
  Vector rows[3];
  return scale(value, rows) ? addAndReduceScaled(simplex_, rows) : addAndReduce(simplex_);
}

template <bool kSwept>
void Gjk<kSwept>::offerNearest() {
  if (!newton_) {
    progress_.offerUpper(norm_);
  } else if (norm_ - query_.upper_offset < progress_.upper()) {
    progress_.offerWitness(norm_, simplex_.nearest, simplex_.pointOfA());
  }
}

// A point of the swept hull belongs to a placement only if all its parts do. False if the hull is
// not above the threshold, because its lower end can no longer rise above that.
template <bool kSwept>
bool Gjk<kSwept>::offerSweptNearest() {
  bool one_placement = true;
  for (int i = 1; i < simplex_.count; ++i) {
    one_placement &= simplex_.point(i).placement == simplex_.point(0).placement;
  }
  if (one_placement) progress_.offerWitness(norm_, simplex_.nearest, simplex_.pointOfA());
  progress_.offerSweptWitness(norm_);
  return !(norm_ - query_.lower_offset <= query_.request.threshold);
}

template <bool kSwept>
void Gjk<kSwept>::chooseDirection() {
  if (!simplex_.has_normal) {
    n_ = simplex_.nearest / norm_;
  } else {
    n_ = simplex_.feature_normal / simplex_.feature_normal.norm();
    if (n_.dot(simplex_.nearest) < 0) n_ = -n_;
  }
  along_nearest_ = n_.dot(simplex_.nearest);
}

template <bool kSwept>
GjkEnd Gjk<kSwept>::run(const Vector& first_direction) {
  n_ = first_direction;
  // A simplex that was passed in is used before the first plane.
  for (bool ask = simplex_.count == 0;; ask = true) {
    if (ask) {
      if (progress_.iterations >= query_.request.iteration_limit) return leave(GjkEnd::kLimit);
      const double value = askPlane();
      if (progress_.enough()) return leave(GjkEnd::kEnough);
      if (along_nearest_ - value <= 2 * query_.roundoff) {
        // There is no point beyond the simplex along n, up to rounding: more steps would only
        // follow rounding errors.
        if (!newton_) return leave(GjkEnd::kStagnated);
        stopNewton();
        along_nearest_ = std::numeric_limits<double>::infinity();
      } else {
        const Reduction reduction = takePoint(value);
        if (reduction == Reduction::kNoProgress) return leave(GjkEnd::kStagnated);
        if (reduction == Reduction::kHoldsOrigin) {
          leave(GjkEnd::kInside);
          ++simplex_.count;
          return GjkEnd::kInside;
        }
      }
    }
    norm_ = std::sqrt(simplex_.norm_squared);
    if constexpr (kSwept) {
      if (!offerSweptNearest()) return GjkEnd::kLimit;
    } else {
      offerNearest();
    }
    if (progress_.enough()) return leave(GjkEnd::kEnough);
    if (newton_) stopIdleNewton();
    if (norm_ <= 4 * query_.roundoff) return leave(GjkEnd::kInside);
    chooseDirection();
  }
}

}  // namespace

GjkEnd runGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex) {
  return Gjk(difference, progress, simplex).run(direction);
}

GjkEnd runGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex) {
  return Gjk(difference, progress, simplex).run(direction);
}

}  // namespace leeway::collision
