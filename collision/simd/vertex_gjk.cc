#include "collision/simd/vertex_gjk.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/collision/tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/simd/vertex_gjk.cc"
#include "collision/simd/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/simd/four_lanes-inl.h"
#include "collision/simd/scan-inl.h"

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
// support values alone, as everywhere (gjk.cc says how they are rounded; that the direction is
// divided out of its support value, in place of being made a unit vector first, is one rounding
// less). What plain arithmetic cannot settle - flat simplices, the origin inside, ends that
// rounding keeps apart - is left to runGjk().

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

/// The lane of the point that is not on the triangle of lane k.
constexpr int kLeftOut[3] = {2, 0, 1};
alignas(32) constexpr double kLane[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

// Plain numbers: a Vector goes through memory, where reading two coordinates at once after they
// were written one by one costs more than a step's arithmetic.
struct Triple {
  double x, y, z;
};
// Of the two vertices that a point of the difference is made of.
struct VertexNames {
  int a, b;
};
HWY_INLINE double dot(const Triple& a, const Triple& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
HWY_INLINE Triple operator-(const Triple& a, const Triple& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HWY_INLINE Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
HWY_INLINE Triple tripleOf(const Vector& v) { return {v.x(), v.y(), v.z()}; }
HWY_INLINE Vector vectorOf(const Triple& v) { return {v.x, v.y, v.z}; }
HWY_INLINE FourPoints fourTimes(const Triple& p) {
  return {allLanes(p.x), allLanes(p.y), allLanes(p.z)};
}

// The vertex of a core with this name, which must be one.
HWY_INLINE Triple corner(const ConvexView& view, int name) {
  const double x = view.size.x(), y = view.size.y(), z = view.size.z();
  switch (view.core) {
    case Core::kBox:
      return {(name & 1) != 0 ? x : -x, (name & 2) != 0 ? y : -y, (name & 4) != 0 ? z : -z};
    case Core::kSegment:
      return {0, 0, name == 1 ? z : -z};
    case Core::kPoints:
      return tripleOf(view.points[name]);
    default:
      return {0, 0, 0};
  }
}

// The farthest vertex of a core along a direction of any length, and its name: as farthest().
HWY_INLINE Triple farthestCorner(const ConvexView& view, const Triple& d, int& name) {
  switch (view.core) {
    case Core::kBox: {
      name =
          (std::signbit(d.x) ? 0 : 1) | (std::signbit(d.y) ? 0 : 2) | (std::signbit(d.z) ? 0 : 4);
      return {std::copysign(view.size.x(), d.x), std::copysign(view.size.y(), d.y),
              std::copysign(view.size.z(), d.z)};
    }
    case Core::kSegment:
      name = d.z >= 0 ? 1 : 0;
      return {0, 0, d.z >= 0 ? view.size.z() : -view.size.z()};
    case Core::kPoints: {
      int found = -1;
      if (view.support != nullptr) found = scanSupport(*view.support, d.x, d.y, d.z, name);
      // Climbing asks for a unit vector: what it takes for equal depends on the length.
      name = found >= 0 ? found : farthestPoint(view, vectorOf(d) / std::sqrt(dot(d, d)), name);
      return tripleOf(view.points[name]);
    }
    default:
      name = 0;
      return {0, 0, 0};
  }
}

// The difference, with A's vertices brought to B's frame where they are few and will be asked
// often: no direction has to be turned back then, and no vertex forth.
class PlacedCores {
 public:
  HWY_INLINE PlacedCores(const Difference<false>& difference, bool place)
      : a_(difference.viewA()),
        b_(difference.viewB()),
        R_(difference.pose().rotation),
        t_(tripleOf(difference.pose().translation)) {
    const HullSupport* support = a_.core == Core::kPoints ? a_.support : nullptr;
    if (!place || support == nullptr || support->length() > kPlacedUpTo) return;
    length_ = support->length();
    const EightDoubles d;
    const auto t_x = hn::Set(d, t_.x), t_y = hn::Set(d, t_.y), t_z = hn::Set(d, t_.z);
    for (int i = 0; i < length_; i += static_cast<int>(hn::MaxLanes(d))) {
      const auto x = hn::Load(d, support->x() + i), y = hn::Load(d, support->y() + i),
                 z = hn::Load(d, support->z() + i);
      const auto row = [&](int r) {
        return hn::Add(hn::Add(hn::Mul(hn::Set(d, R_(r, 0)), x), hn::Mul(hn::Set(d, R_(r, 1)), y)),
                       hn::Mul(hn::Set(d, R_(r, 2)), z));
      };
      hn::Store(hn::Add(row(0), t_x), d, x_ + i);
      hn::Store(hn::Add(row(1), t_y), d, y_ + i);
      hn::Store(hn::Add(row(2), t_z), d, z_ + i);
    }
  }

  // The member with the smallest w . n, and A's point in it.
  HWY_INLINE Triple support(const Triple& n, VertexNames& names, Triple& a) const {
    const Triple b = farthestCorner(b_, -n, names.b);
    if (length_ > 0) {
      names.a = scanColumns(x_, y_, z_, length_, n.x, n.y, n.z);
      a = {x_[names.a], y_[names.a], z_[names.a]};
      return b - a;
    }
    const Triple back = {R_(0, 0) * n.x + R_(1, 0) * n.y + R_(2, 0) * n.z,
                         R_(0, 1) * n.x + R_(1, 1) * n.y + R_(2, 1) * n.z,
                         R_(0, 2) * n.x + R_(1, 2) * n.y + R_(2, 2) * n.z};
    a = placed(farthestCorner(a_, back, names.a));
    return b - a;
  }

  HWY_INLINE Triple member(const VertexNames& names, Triple& a) const {
    a = placed(corner(a_, names.a));
    return corner(b_, names.b) - a;
  }

 private:
  static constexpr int kPlacedUpTo = 32;

  HWY_INLINE Triple placed(const Triple& a) const {
    return {R_(0, 0) * a.x + R_(0, 1) * a.y + R_(0, 2) * a.z + t_.x,
            R_(1, 0) * a.x + R_(1, 1) * a.y + R_(1, 2) * a.z + t_.y,
            R_(2, 0) * a.x + R_(2, 1) * a.y + R_(2, 2) * a.z + t_.z};
  }

  const ConvexView &a_, &b_;
  const Eigen::Matrix3d& R_;
  const Triple t_;
  int length_ = 0;
  alignas(64) double x_[kPlacedUpTo], y_[kPlacedUpTo], z_[kPlacedUpTo];
};

// What a step found.
struct Nearest {
  Triple direction;                    ///< of the nearest point, any length
  double direction_squared;            ///< its length squared
  double norm_squared;                 ///< of the nearest point
  int lane = -1;                       ///< -1: nothing is known yet
  double weight_first, weight_second;  ///< of points `lane` and `lane` + 1; the rest is p's
};

// The lane with the least of the first three values, by which of them are greater than the next.
constexpr int kLeastLane[8] = {0, 1, 2, 2, 0, 1, 0, 0};

enum class Step { kNearer, kHoldsOrigin, kHoldsOriginWell };

// Takes the newest point in.
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

// The best supporting plane.
class BestPlane {
 public:
  HWY_INLINE void offer(double value, const Triple& direction) {
    if (!(value > value_)) return;
    value_ = value;
    direction_ = direction;
  }
  HWY_INLINE double value() const { return value_; }
  HWY_INLINE const Triple& direction() const { return direction_; }

 private:
  double value_ = -std::numeric_limits<double>::infinity();
  Triple direction_ = {1, 0, 0};
};

// A cold search asks along its first direction and three around it at once, in about the time of
// one: that saves about two steps out of six. What is added to the first direction (of length 1),
// by its largest coordinate: three vectors at right angles to that axis. The best of a few lengths
// on hulls.
constexpr double kTilt = 0.7, kHalf = -0.5 * kTilt, kRoot = 0.8660254037844386 * kTilt;
constexpr Triple kAround[3][3] = {{{0, kTilt, 0}, {0, kHalf, kRoot}, {0, kHalf, -kRoot}},
                                  {{0, 0, kTilt}, {kRoot, 0, kHalf}, {-kRoot, 0, kHalf}},
                                  {{kTilt, 0, 0}, {kHalf, kRoot, 0}, {kHalf, -kRoot, 0}}};

class Search {
 public:
  HWY_INLINE Search(Difference<false>& difference, const PairCache* carried, Progress& progress)
      : progress_(progress),
        cores_(difference, carried == nullptr),
        newest_names_{difference.hintA(), difference.hintB()} {}

  HWY_INLINE GjkEnd run(const Triple& first, const PairCache* carried);
  /// Writes down what was found; the simplex is empty when that is nothing.
  HWY_INLINE void leave(GjkEnd end, Simplex& simplex);
  const VertexNames& lastNames() const { return newest_names_; }

 private:
  HWY_INLINE Step begin(const Triple& first, const PairCache* carried);
  HWY_INLINE void keepNewest() {
    const int left_out = kLeftOut[nearest_.lane];
    old_ = choose(load(kLane[left_out]) > allLanes(0), fourTimes(newest_), old_);
    names_[left_out] = newest_names_;
    w_[left_out] = newest_;
    a_[left_out] = newest_a_;
  }
  HWY_INLINE void setOld() {
    old_ = choose(load(kLane[0]) > allLanes(0), fourTimes(w_[0]),
                  choose(load(kLane[1]) > allLanes(0), fourTimes(w_[1]), fourTimes(w_[2])));
  }

  Progress& progress_;
  const PlacedCores cores_;
  // The older points, as `old_` has them lane by lane, and the newest.
  VertexNames names_[3], newest_names_;
  Triple w_[3], newest_;
  Triple a_[3], newest_a_;
  FourPoints old_;
  Nearest nearest_;
  BestPlane best_;
};

HWY_INLINE Step Search::begin(const Triple& first, const PairCache* carried) {
  if (carried != nullptr) {
    // One of the points as the newest.
    for (int i = 0; i < 3; ++i) {
      const int k = i < carried->simplex_count ? i : 0;
      names_[i] = {carried->simplex_a[k], carried->simplex_b[k]};
      w_[i] = cores_.member(names_[i], a_[i]);
    }
    newest_ = w_[0];
    newest_a_ = a_[0];
    newest_names_ = names_[0];
    setOld();
    const Step found = step(newest_, old_, nearest_);
    if (found == Step::kNearer) keepNewest();
    return found;
  }
  ++progress_.iterations;
  const VertexNames hints = newest_names_;
  newest_ = cores_.support(first, newest_names_, newest_a_);
  best_.offer(dot(first, newest_), first);
  // A threshold is most often decided by the first direction alone.
  if (!std::isnan(progress_.query().request.threshold)) {
    const double squared = dot(newest_, newest_);
    nearest_ = {newest_, squared, squared, 0, 0, 0};
    for (int i = 0; i < 3; ++i) {
      names_[i] = newest_names_;
      w_[i] = newest_;
      a_[i] = newest_a_;
    }
    old_ = fourTimes(newest_);
    return Step::kNearer;
  }
  const double ax = std::abs(first.x), ay = std::abs(first.y), az = std::abs(first.z);
  int axis = static_cast<int>(ay > ax);
  axis += static_cast<int>(az > std::max(ax, ay)) * (2 - axis);
  for (int i = 0; i < 3; ++i) {
    const Triple& tilt = kAround[axis][i];
    names_[i] = hints;
    w_[i] =
        cores_.support({first.x + tilt.x, first.y + tilt.y, first.z + tilt.z}, names_[i], a_[i]);
  }
  setOld();
  const Step result = step(newest_, old_, nearest_);
  if (result == Step::kNearer) keepNewest();
  return result;
}

HWY_INLINE GjkEnd Search::run(const Triple& first, const PairCache* carried) {
  const CoreQuery& query = progress_.query();
  const DistanceRequest& request = query.request;
  const int limit = request.iteration_limit;
  Step last = begin(first, carried);
  while (last == Step::kNearer) {
    // As Progress::enough(), but with an upper end that is not yet made of points.
    const double upper = std::sqrt(nearest_.norm_squared) - query.upper_offset;
    double lower = best_.value() - query.lower_offset;
    if (lower > request.threshold || upper <= request.threshold || (!request.depth && upper <= 0) ||
        (upper - lower <= request.tolerance && (lower > 0 || upper <= 0))) {
      return GjkEnd::kStagnated;
    }
    if (progress_.iterations >= limit) return GjkEnd::kLimit;
    ++progress_.iterations;
    newest_ = cores_.support(nearest_.direction, newest_names_, newest_a_);
    best_.offer(dot(nearest_.direction, newest_) / std::sqrt(nearest_.direction_squared),
                nearest_.direction);
    lower = best_.value() - query.lower_offset;
    if (lower > request.threshold || (upper - lower <= request.tolerance && lower > 0)) {
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

HWY_INLINE void Search::leave(GjkEnd end, Simplex& simplex) {
  const Triple& plane = best_.direction();
  progress_.offerLower(best_.value(), vectorOf(plane) / std::sqrt(dot(plane, plane)));
  const bool inside = end == GjkEnd::kInside;
  const int k = nearest_.lane;
  if (!inside && k < 0) return;
  const int place[3] = {inside ? 0 : kLeftOut[k], inside ? 1 : k, inside ? 2 : (k + 1) % 3};
  const double weights[3] = {1 - nearest_.weight_first - nearest_.weight_second,
                             nearest_.weight_first, nearest_.weight_second};
  Triple w = {0, 0, 0}, a = {0, 0, 0};
  for (int i = 0; i < 4; ++i) {
    if (i == 3 && !inside) break;
    const double weight = inside ? 0.25 : weights[i];
    if (!(weight > 0)) continue;
    const Triple& here_w = i < 3 ? w_[place[i]] : newest_;
    const Triple& here_a = i < 3 ? a_[place[i]] : newest_a_;
    const VertexNames& names = i < 3 ? names_[place[i]] : newest_names_;
    SupportPoint& s = simplex.points[simplex.slot[simplex.count]];
    s.w = vectorOf(here_w);
    s.a = vectorOf(here_a);
    s.index_a = names.a;
    s.index_b = names.b;
    s.placement = 0;
    simplex.lambda[simplex.count++] = weight;
    w = {w.x + weight * here_w.x, w.y + weight * here_w.y, w.z + weight * here_w.z};
    a = {a.x + weight * here_a.x, a.y + weight * here_a.y, a.z + weight * here_a.z};
  }
  if (inside) {  // (No other point is known to be near; a polytope will find a better end.)
    const SupportPoint& s = simplex.points[simplex.slot[0]];
    progress_.offerWitness(s.w.norm(), s.w, s.a);
  }
  if (inside || simplex.count == 0) return;
  simplex.nearest = vectorOf(w);
  simplex.norm_squared = dot(w, w);
  progress_.offerWitness(std::sqrt(simplex.norm_squared), simplex.nearest, vectorOf(a));
}

}  // namespace

GjkEnd vertexSteps(Difference<false>& difference, const Vector& direction, Progress& progress,
                   const PairCache* carried, Simplex& simplex) {
  Search search(difference, carried, progress);
  const GjkEnd end = search.run(tripleOf(direction), carried);
  difference.setHints(search.lastNames().a, search.lastNames().b);
  search.leave(end, simplex);
  if (end == GjkEnd::kInside) return end;
  return simplex.count > 0 && progress.enough() ? GjkEnd::kEnough : end;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(vertexSteps);

bool fits(const Difference<false>& difference, const PairCache& cache) {
  const int count = cache.simplex_count;
  if (count < 1 || count > 3) return false;
  const int count_a = vertexCount(difference.viewA()), count_b = vertexCount(difference.viewB());
  bool all = true;
  for (int i = 0; i < count; ++i) {
    const int a = cache.simplex_a[i], b = cache.simplex_b[i];
    all &= a >= 0 && a < count_a && b >= 0 && b < count_b;
  }
  return all;
}

GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction,
                    const PairCache* carried, Progress& progress, Simplex& simplex) {
  if (progress.iterations >= progress.query().request.iteration_limit) return GjkEnd::kLimit;
  const GjkEnd end =
      HWY_DYNAMIC_DISPATCH(vertexSteps)(difference, direction, progress, carried, simplex);
  if (end == GjkEnd::kStagnated && simplex.count > 0) reduceAll(simplex, simplex.count);
  return end;
}

}  // namespace leeway::collision
#endif
