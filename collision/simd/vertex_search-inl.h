// GJK's steps on the vertices of a difference, in vector lanes, for any two cores that name the
// farthest of their vertices. Included once a target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_VERTEX_SEARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_VERTEX_SEARCH_INL_H
#undef LEEWAY_COLLISION_VERTEX_SEARCH_INL_H
#else
#define LEEWAY_COLLISION_VERTEX_SEARCH_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "collision/gjk.h"
#include "collision/simd/four_lanes-inl.h"
#include "collision/simd/scan-inl.h"
#include "collision/triple.h"
#include "leeway/collision/tolerances.h"

// A step takes a new point p of the difference and three older ones (the same one several times at
// first). In exact arithmetic the nearest point of their hull is on a triangle that p has with two
// of the others. So lane k looks at one: p, point k and point k + 1 (modulo three), or, where the
// origin is not above its inside, at its edge from p to point k. The older point that the best lane
// does without makes room for p; one without weight may stay, which does no harm.
//
// Nothing here calls code of another target: code without AVX that runs while registers' upper
// halves are in use costs hundreds of cycles, and compilers forget to clear them.
//
// Whatever rounding does here costs steps only: both ends that are offered rest on points and
// support values alone, as everywhere (gjk.cc says how they are rounded; a direction's length is
// divided out of its support value, which errs by no more than a unit vector made of it would).
// What plain arithmetic cannot settle - flat simplices, the origin inside, ends that rounding keeps
// apart - is left to runGjk().

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

/// Of the two vertices that a point of the difference is made of.
struct VertexNames {
  std::int32_t a, b;
};
HWY_INLINE FourPoints fourTimes(const Triple& p) {
  return {allLanes(p.x), allLanes(p.y), allLanes(p.z)};
}
/// In a lane, which is only ever copied.
HWY_INLINE Lanes allLanes(const VertexNames& names) {
  return allLanes(std::bit_cast<double>(names));
}

/// The lane of the point that is not on the triangle of lane k.
constexpr int kLeftOut[3] = {2, 0, 1};
alignas(32) constexpr double kLane[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
HWY_INLINE Mask onlyLane(int k) { return load(kLane[k]) > allLanes(0); }

/// scanColumns(), not inlined: a call is little beside it, and all of its cases in every place
/// would be much code.
inline HWY_NOINLINE int calledColumns(const HullSupport& support, double dx, double dy, double dz) {
  return scanColumns<kScanUpTo>(support.x(), support.y(), support.z(), support.length(), dx, dy,
                                dz);
}
/// As scanSupport().
HWY_INLINE int scannedSupport(const HullSupport& support, const Triple& d, std::int32_t& hint) {
  return support.length() == 0 ? scanTable(support, d.x, d.y, d.z, hint)
                               : calledColumns(support, d.x, d.y, d.z);
}

/// The vertices of a small hull at a pose, brought there once: no direction has to be turned back
/// for them, and no vertex forth.
class PlacedVertices {
 public:
  static HWY_INLINE bool takes(const HullSupport& support) {
    return support.length() > 0 && support.length() <= kPlacedUpTo;
  }
  /// Nothing is placed where there are too many.
  HWY_INLINE void place(const HullSupport& support, const Eigen::Matrix3d& R, const Triple& t) {
    if (!takes(support)) return;
    length_ = support.length();
    const EightDoubles d;
    for (int i = 0; i < length_; i += static_cast<int>(hn::MaxLanes(d))) {
      const auto x = hn::Load(d, support.x() + i), y = hn::Load(d, support.y() + i),
                 z = hn::Load(d, support.z() + i);
      const auto row = [&](int r, double shift) HWY_ATTR {
        return hn::Add(
            hn::Add(hn::Add(hn::Mul(hn::Set(d, R(r, 0)), x), hn::Mul(hn::Set(d, R(r, 1)), y)),
                    hn::Mul(hn::Set(d, R(r, 2)), z)),
            hn::Set(d, shift));
      };
      hn::Store(row(0, t.x), d, x_ + i);
      hn::Store(row(1, t.y), d, y_ + i);
      hn::Store(row(2, t.z), d, z_ + i);
    }
  }
  HWY_INLINE bool empty() const { return length_ == 0; }
  HWY_INLINE Triple vertex(int name) const { return {x_[name], y_[name], z_[name]}; }
  HWY_INLINE Triple farthest(const Triple& n, std::int32_t& name) const {
    name = scanColumns<kPlacedUpTo>(x_, y_, z_, length_, n.x, n.y, n.z);
    return vertex(name);
  }

 private:
  static constexpr int kPlacedUpTo = 32;
  int length_ = 0;
  alignas(64) double x_[kPlacedUpTo], y_[kPlacedUpTo], z_[kPlacedUpTo];
};

/// What a step found.
struct Nearest {
  Triple direction = {0, 0, 0};                ///< of the nearest point, any length
  double direction_squared = 0;                ///< its length squared
  double norm_squared = 0;                     ///< of the nearest point
  int lane = -1;                               ///< -1: nothing is known yet
  double weight_first = 0, weight_second = 0;  ///< of points `lane` and `lane` + 1; the rest is p's
};

/// The lane with the least of the first three values, by which of them are greater than the next.
constexpr int kLeastLane[8] = {0, 1, 2, 2, 0, 1, 0, 0};

enum class Step : unsigned char { kNearer, kHoldsOrigin, kHoldsOriginWell };

/// Takes the newest point in.
HWY_INLINE Step step(const Triple& newest, const FourPoints& old, Nearest& nearest) {
  const Lanes zero = allLanes(0), one = allLanes(1);
  const FourPoints p = fourTimes(newest);
  const FourPoints e = old - p, f = nextOfThree(e);
  const Lanes ee = dot(e, e), ef = dot(e, f), ff = nextOfThree(ee);
  const Lanes pe = zero - dot(p, e), pf = nextOfThree(pe);
  const FourPoints n = cross(e, f);
  const Lanes nn = dot(n, n), pn = dot(p, n), inverse = one / nn;
  // Weights of the lane's points, times nn.
  const Lanes area_e = ff * pe - ef * pf, area_f = ee * pf - ef * pe;
  const Mask inside = (area_e > zero) & (area_f > zero) & (nn - area_e > area_f);
  const Lanes along = choose(pe > zero, choose(ee > pe, pe / ee, one), zero);
  const FourPoints on_edge = {p.x + along * e.x, p.y + along * e.y, p.z + along * e.z};
  const Lanes edge_squared = dot(on_edge, on_edge);
  const Lanes norm_squared = choose(inside, pn * (pn * inverse), edge_squared);
  // (Of the fourth lane nothing is known.)
  const int k = kLeastLane[bitsOf(norm_squared > nextOfThree(norm_squared)) & 7U];

  // A triangle's normal points away from the origin or towards it.
  const FourPoints direction = choose(inside, withSignOf(n, pn), on_edge);
  alignas(32) double squared[4], height[4], volume_of[4], x[4], y[4], z[4], length_squared[4],
      first[4], second[4];
  store(direction.x, x);
  store(direction.y, y);
  store(direction.z, z);
  store(norm_squared, squared);
  store(pn, height);
  store(dot(n, nextOfThree(f)), volume_of);
  store(choose(inside, nn, edge_squared), length_squared);
  store(choose(inside, area_e * inverse, along), first);
  store(choose(inside, area_f * inverse, zero), second);

  // The origin's weight of the point that lane k leaves out is -height[k] / volume.
  const double volume = volume_of[0];
  const double sign = std::copysign(1.0, -volume), size = std::abs(volume);
  const double h0 = sign * height[0], h1 = sign * height[1], h2 = sign * height[2];
  const double least = std::min(std::min(h0, h1), std::min(h2, size - (h0 + h1 + h2)));
  if (HWY_UNLIKELY(least > 0)) {
    alignas(32) double edge_squared_of[4];
    store(ee, edge_squared_of);
    const double longest_squared =
        std::max(edge_squared_of[0], std::max(edge_squared_of[1], edge_squared_of[2]));
    const bool well =
        least > kHeldWell * size && size > kHeldWell * longest_squared * std::sqrt(longest_squared);
    return well ? Step::kHoldsOriginWell : Step::kHoldsOrigin;
  }

  nearest.direction = {x[k], y[k], z[k]};
  nearest.direction_squared = length_squared[k];
  nearest.norm_squared = squared[k];
  nearest.lane = k;
  nearest.weight_first = first[k];
  nearest.weight_second = second[k];
  // Near contact what is left of the edge's point after cancellation is not at a right angle to
  // the edge any more: once more.
  if (HWY_UNLIKELY(squared[k] < kCancelled * dot(newest, newest)) && first[k] > 0 &&
      second[k] == 0) {
    store(e.x, x);
    store(e.y, y);
    store(e.z, z);
    const Triple edge = {x[k], y[k], z[k]};
    const double excess = dot(nearest.direction, edge) / dot(edge, edge);
    nearest.direction = {nearest.direction.x - excess * edge.x,
                         nearest.direction.y - excess * edge.y,
                         nearest.direction.z - excess * edge.z};
    nearest.direction_squared = dot(nearest.direction, nearest.direction);
  }
  return Step::kNearer;
}

/// The best supporting plane: a new one is written beside it and taken by its place, because which
/// it will be nobody can foretell.
class BestPlane {
 public:
  HWY_INLINE void offer(double value, const Triple& direction) {
    direction_[1 - best_] = direction;
    best_ = value > value_ ? 1 - best_ : best_;
    value_ = std::max(value_, value);
  }
  HWY_INLINE double value() const { return value_; }
  HWY_INLINE const Triple& direction() const { return direction_[best_]; }

 private:
  double value_ = -std::numeric_limits<double>::infinity();
  int best_ = 0;
  Triple direction_[2] = {{1, 0, 0}, {1, 0, 0}};
};

/// A cold search asks along its first direction and three around it at once, in about the time of
/// one: that saves about two steps out of six. What is added to the first direction (of length 1),
/// by its largest coordinate: three vectors at right angles to that axis, and nothing for the first
/// direction itself. The best of a few lengths on hulls.
constexpr double kTilt = 0.7, kHalf = -0.5 * kTilt, kRoot = 0.8660254037844386 * kTilt;
constexpr Triple kAround[3][4] = {
    {{0, kTilt, 0}, {0, kHalf, kRoot}, {0, kHalf, -kRoot}, {0, 0, 0}},
    {{0, 0, kTilt}, {kRoot, 0, kHalf}, {-kRoot, 0, kHalf}, {0, 0, 0}},
    {{kTilt, 0, 0}, {kHalf, kRoot, 0}, {kHalf, -kRoot, 0}, {0, 0, 0}}};

/// The points that carry what a search found, with their weights; of the four around the origin no
/// weight is known.
struct Carriers {
  int count = 0;
  VertexNames names[4];
  Triple w[4];
  double weight[4];
};

/// `Cores` has
///   Triple support(const Triple& n, VertexNames& names) const: the member of the difference with
///     the smallest w . n, for a direction of any length; names come in as hints;
///   Triple member(const VertexNames& names) const.
template <class Cores>
class Search {
 public:
  /// A plane at value v proves v - lower_offset, a point at distance d proves d - upper_offset.
  HWY_INLINE Search(const Cores& cores, const DistanceRequest& request, double lower_offset,
                    double upper_offset, int iterations)
      : cores_(cores),
        request_(request),
        lower_offset_(lower_offset),
        upper_offset_(upper_offset),
        iterations_(iterations) {}

  /// First along `first`, of length 1; or, where `carried` is not null, from its points, which are
  /// vertices of the pair. Ends with kLimit, kInside or, where the request is met or robust steps
  /// must go on, with kStagnated.
  HWY_INLINE GjkEnd run(const Triple& first, const PairCache* carried, const VertexNames& hints);

  HWY_INLINE const BestPlane& best() const { return best_; }
  HWY_INLINE int iterations() const { return iterations_; }
  HWY_INLINE const VertexNames& lastNames() const { return newest_names_; }
  /// What the end rests on; none where no step was made.
  HWY_INLINE void carriers(GjkEnd end, Carriers& found) const;

 private:
  HWY_INLINE Step begin(const Triple& first, const PairCache* carried, const VertexNames& hints);
  HWY_INLINE void keepNewest() {
    const Mask place = onlyLane(kLeftOut[nearest_.lane]);
    old_ = choose(place, fourTimes(newest_), old_);
    old_names_ = choose(place, allLanes(newest_names_), old_names_);
  }
  HWY_INLINE void setOld(const Triple w[3], const VertexNames names[3]) {
    const Mask first = onlyLane(0), second = onlyLane(1);
    old_ = choose(first, fourTimes(w[0]), choose(second, fourTimes(w[1]), fourTimes(w[2])));
    old_names_ =
        choose(first, allLanes(names[0]), choose(second, allLanes(names[1]), allLanes(names[2])));
  }

  const Cores& cores_;
  const DistanceRequest& request_;
  const double lower_offset_, upper_offset_;
  int iterations_;
  FourPoints old_;
  Lanes old_names_;
  Triple newest_;
  VertexNames newest_names_;
  Nearest nearest_;
  BestPlane best_;
};

template <class Cores>
HWY_INLINE Step Search<Cores>::begin(const Triple& first, const PairCache* carried,
                                     const VertexNames& hints) {
  Triple w[4];
  VertexNames names[4];
  if (carried != nullptr) {
    for (int i = 0; i < 3; ++i) {
      const int k = i < carried->simplex_count ? i : 0;
      names[i] = {carried->simplex_a[k], carried->simplex_b[k]};
      w[i] = cores_.member(names[i]);
    }
    // One of the points as the newest.
    newest_ = w[0];
    newest_names_ = names[0];
    setOld(w, names);
  } else {
    ++iterations_;
    // A threshold is most often decided by the first direction alone.
    const bool alone = !std::isnan(request_.threshold);
    const double ax = std::abs(first.x), ay = std::abs(first.y), az = std::abs(first.z);
    int axis = static_cast<int>(ay > ax);
    axis += static_cast<int>(az > std::max(ax, ay)) * (2 - axis);
    for (int i = alone ? 3 : 0; i < 4; ++i) {
      const Triple& tilt = kAround[axis][i];
      names[i] = hints;
      w[i] = cores_.support({first.x + tilt.x, first.y + tilt.y, first.z + tilt.z}, names[i]);
    }
    newest_ = w[3];
    newest_names_ = names[3];
    best_.offer(dot(first, newest_), first);
    if (alone) {
      const double length_squared = squared(newest_);
      nearest_ = {newest_, length_squared, length_squared, 0, 0, 0};
      old_ = fourTimes(newest_);
      old_names_ = allLanes(newest_names_);
      return Step::kNearer;
    }
    setOld(w, names);
  }
  const Step found = step(newest_, old_, nearest_);
  if (found == Step::kNearer) keepNewest();
  return found;
}

template <class Cores>
HWY_INLINE GjkEnd Search<Cores>::run(const Triple& first, const PairCache* carried,
                                     const VertexNames& hints) {
  Step last = begin(first, carried, hints);
  while (last == Step::kNearer) {
    // As Progress::enough(), but with an upper end that is not yet made of points.
    const double upper = std::sqrt(nearest_.norm_squared) - upper_offset_;
    double lower = best_.value() - lower_offset_;
    if (lower > request_.threshold || upper <= request_.threshold ||
        (!request_.depth && upper <= 0) ||
        (upper - lower <= request_.tolerance && (lower > 0 || upper <= 0))) {
      return GjkEnd::kStagnated;
    }
    if (iterations_ >= request_.iteration_limit) return GjkEnd::kLimit;
    ++iterations_;
    const double per = 1 / std::sqrt(nearest_.direction_squared);
    newest_ = cores_.support(nearest_.direction, newest_names_);
    best_.offer(dot(nearest_.direction, newest_) * per, nearest_.direction);
    lower = best_.value() - lower_offset_;
    if (lower > request_.threshold || (upper - lower <= request_.tolerance && lower > 0)) {
      return GjkEnd::kStagnated;
    }
    Nearest next;
    last = step(newest_, old_, next);
    if (last != Step::kNearer) break;
    // (NaN fails.)
    if (!(next.norm_squared < nearest_.norm_squared)) return GjkEnd::kStagnated;
    nearest_ = next;
    keepNewest();
  }
  return last == Step::kHoldsOriginWell ? GjkEnd::kInside : GjkEnd::kStagnated;
}

template <class Cores>
HWY_INLINE void Search<Cores>::carriers(GjkEnd end, Carriers& found) const {
  const bool inside = end == GjkEnd::kInside;
  const int k = nearest_.lane;
  found.count = 0;
  if (!inside && k < 0) return;
  alignas(32) double x[4], y[4], z[4], names[4];
  store(old_.x, x);
  store(old_.y, y);
  store(old_.z, z);
  store(old_names_, names);
  const int place[3] = {inside ? 0 : kLeftOut[k], inside ? 1 : k, inside ? 2 : (k + 1) % 3};
  const double weights[3] = {1 - nearest_.weight_first - nearest_.weight_second,
                             nearest_.weight_first, nearest_.weight_second};
  for (int i = 0; i < 3; ++i) {
    const double weight = inside ? 0.25 : weights[i];
    if (!(weight > 0)) continue;
    const int p = place[i];
    found.names[found.count] = std::bit_cast<VertexNames>(names[p]);
    found.w[found.count] = {x[p], y[p], z[p]};
    found.weight[found.count++] = weight;
  }
  if (!inside) return;
  found.names[found.count] = newest_names_;
  found.w[found.count] = newest_;
  found.weight[found.count++] = 0.25;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
