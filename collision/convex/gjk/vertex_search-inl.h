// GJK on the vertices of a difference, in vector lanes, for any two cores that index their
// vertices. Included once for each target (see Highway's foreach_target.h).

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

#include "collision/base/lanes-inl.h"
#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "collision/base/triple.h"
#include "collision/convex/gjk/gjk.h"
#include "collision/shapes/hull_scan-inl.h"

// A step has a new point p of the difference and three older ones (at first, copies of one). In
// exact arithmetic the nearest point of their hull lies on a triangle of p and two of the others.
// Lane k computes one of these: p, point k and point k + 1 (modulo three) or, if the origin does
// not project into it, its edge from p to point k. p replaces the older point that the best lane
// omits. A point without weight may stay, because it has no effect.
//
// This file calls no code of another target. Code without AVX that runs while the upper halves of
// registers are in use costs hundreds of cycles, and compilers forget to clear them.
//
// Rounding only costs steps: both ends are computed from points and support values, whose rounding
// gjk.cc derives. (The support value is divided by the direction's length and errs by no more than
// the value along a unit vector.) Cases that plain arithmetic cannot settle - flat simplices, the
// origin inside, ends that rounding keeps apart - are left to runGjk().

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

/// The indices of the two vertices that form a point of the difference.
struct VertexIndices {
  std::int32_t a, b;
};
/// Both in one lane, which is only ever copied. (They are joined in a register, because reading two
/// separately written halves from memory at once stalls.)
HWY_INLINE double inLane(const VertexIndices& indices) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::uint32_t>(indices.b))
                                   << 32U |
                               static_cast<std::uint32_t>(indices.a));
}
HWY_INLINE VertexIndices indicesIn(double lane) {
  const std::uint64_t both = std::bit_cast<std::uint64_t>(lane);
  return {static_cast<std::int32_t>(static_cast<std::uint32_t>(both)),
          static_cast<std::int32_t>(both >> 32U)};
}
HWY_INLINE Lanes<4> allLanes(const VertexIndices& indices) { return allLanes<4>(inLane(indices)); }

/// The point that the triangle of lane k omits.
constexpr int kLeftOut[3] = {2, 0, 1};

/// scanColumns(), not inlined: its many cases would enlarge every call site, and a call is cheap in
/// comparison.
inline HWY_NOINLINE int calledColumns(const HullSupport& support, double dx, double dy, double dz) {
  return scanColumns<kScanUpTo>(support.x(), support.y(), support.z(), support.length(), dx, dy,
                                dz);
}
/// scanSupport() in this target.
HWY_INLINE int scannedSupport(const HullSupport& support, const Triple& d, std::int32_t& hint) {
  return support.length() == 0 ? scanTable(support, d.x, d.y, d.z, hint)
                               : calledColumns(support, d.x, d.y, d.z);
}
/// The cell that it scans; null if there is none.
HWY_INLINE const HullCell* cellFor(const HullSupport& support, const Triple& d) {
  return support.length() == 0 ? cellOf(support, d.x, d.y, d.z) : nullptr;
}
/// scannedSupport() with a known cell.
HWY_INLINE int scannedSupport(const HullSupport& support, const HullCell* cell, const Triple& d,
                              std::int32_t& hint) {
  return support.length() == 0 ? scanCell(support, cell, d.x, d.y, d.z, hint)
                               : calledColumns(support, d.x, d.y, d.z);
}

/// The points nearest to the origin on the triangles of a point p and two neighbours on a ring, one
/// lane each.
template <int n>
struct Triangles {
  Points<n> e, f;               ///< from point k to p, and from point k + 1 to p
  Points<n> normal;             ///< e x f
  Lanes<n> height;              ///< p . normal
  Points<n> direction;          ///< of the nearest point, any length
  Lanes<n> direction_squared;   ///< its length squared
  Lanes<n> norm_squared, part;  ///< of the nearest point, times `part`, which is above 0
  Lanes<n> first, second, all;  ///< weights of points k, k + 1 (parts of `all`)
  Mask<n> on_edge;              ///< the point is inside the edge from p to point k
};

// Computed without divisions, so that latencies overlap.
template <int n>
HWY_INLINE Triangles<n> trianglesOf(const Points<n>& p, const Points<n>& ring) {
  const Lanes<n> zero = allLanes<n>(0.0), one = allLanes<n>(1.0);
  Triangles<n> t;
  t.e = p - ring;
  t.f = nextInRing(t.e);
  const Lanes<n> ee = dot(t.e, t.e), ef = dot(t.e, t.f), ff = nextInRing(ee);
  const Lanes<n> pe = dot(p, t.e), pf = nextInRing(pe);
  t.normal = cross(t.e, t.f);
  t.height = dot(p, t.normal);
  const Lanes<n> nn = dot(t.normal, t.normal);
  // Barycentric weights of points k and k + 1, times nn.
  const Lanes<n> area_e = ff * pe - ef * pf, area_f = ee * pf - ef * pe;
  const Mask<n> inside = (area_e > zero) & (area_f > zero) & (nn - area_e > area_f);
  // The edge's nearest point is at the share along / whole from p to point k.
  const Mask<n> leaves = pe > zero, between = leaves & (ee > pe);
  const Lanes<n> whole = choose(between, ee, one),
                 along = choose(between, pe, choose(leaves, one, zero));
  const Points<n> on_edge = whole * p - along * t.e;
  const Lanes<n> edge_squared = dot(on_edge, on_edge);
  // (A triangle's normal may point to either side of the origin.)
  t.direction = choose(inside, withSignOf(t.normal, t.height), on_edge);
  t.direction_squared = choose(inside, nn, edge_squared);
  t.norm_squared = choose(inside, t.height * t.height, edge_squared);
  t.part = choose(inside, nn, whole * whole);
  t.first = choose(inside, area_e, along);
  t.second = choose(inside, area_f, zero);
  t.all = choose(inside, nn, whole);
  t.on_edge = andNot(inside, between);
  return t;
}

/// The result of a step. Points and directions are in the cores' own form: single, or in all lanes.
template <class Point>
struct Nearest {
  Point direction;               ///< of the nearest point, any length
  double direction_squared = 0;  ///< its length squared
  double norm_squared = 0;       ///< of the nearest point
  int lane = -1;                 ///< of Triangles; -1: none so far
  Lanes<4> first, second, all;   ///< as Triangles has them, of that lane
};

/// Reads the nearest point from the best lane of the newest point's triangles.
template <int n, class Point>
HWY_INLINE void take(const Triangles<n>& t, const Pick<n>& best, const Point& newest,
                     Nearest<Point>& nearest) {
  pick(t.direction, best, nearest.direction);
  nearest.direction_squared = best(t.direction_squared);
  nearest.norm_squared = best(t.norm_squared) / best(t.part);
  nearest.lane = best.lane();
  // Near contact, cancellation leaves an edge's point with a part along the edge, which is
  // projected out, but not at an edge's end. (One branch for all lanes, because most pairs at this
  // distance have their nearest points elsewhere.)
  const Lanes<n> least = allLanes<n>(kCancelled * squared(tripleOf(newest)));
  const Mask<n> cancelled = (least * t.part > t.norm_squared) & t.on_edge;
  if (HWY_UNLIKELY((bitsOf(cancelled) >> static_cast<unsigned>(nearest.lane) & 1U) != 0)) {
    Triple edge;
    pick(t.e, best, edge);
    const Triple way = tripleOf(nearest.direction);
    const Triple straight = way - (dot(way, edge) / dot(edge, edge)) * edge;
    set(nearest.direction, straight);
    nearest.direction_squared = squared(straight);
  }
}

enum class Step : unsigned char { kNearer, kHoldsOrigin, kHoldsOriginWell };

/// Whether the tetrahedron of p and three older points holds the origin; kNearer if it does not.
HWY_INLINE Step heldBy(const Triangles<4>& t) {
  const Lanes<4> volume = dot(t.normal, nextInRing(t.f)), zero = allLanes<4>(0.0);
  // The barycentric weight of the point that lane k omits is height / volume.
  const Lanes<4> weight = withSignOf(t.height, volume);
  if (HWY_LIKELY((bitsOf(weight > zero) & 7U) != 7U)) return Step::kNearer;
  alignas(32) double weights[4], volumes[4], squares[4];
  store(weight, weights);
  store(volume, volumes);
  const double size = std::abs(volumes[0]);
  const double least =
      std::min(std::min(weights[0], weights[1]),
               std::min(weights[2], size - (weights[0] + weights[1] + weights[2])));
  if (!(least > 0)) return Step::kNearer;
  store(dot(t.e, t.e), squares);
  const double longest_squared = std::max(squares[0], std::max(squares[1], squares[2]));
  const bool well =
      least > kHeldWell * size && size > kHeldWell * longest_squared * std::sqrt(longest_squared);
  return well ? Step::kHoldsOriginWell : Step::kHoldsOrigin;
}

/// Adds the newest point.
template <class Point>
HWY_INLINE Step step(const Point& newest, const Points<4>& old, Nearest<Point>& nearest) {
  const Triangles<4> t = trianglesOf(allLanes<4>(newest), old);
  const Step found = heldBy(t);
  if (HWY_UNLIKELY(found != Step::kNearer)) return found;
  take(t, leastOfThree(t.norm_squared, t.part), newest, nearest);
  nearest.first = t.first;
  nearest.second = t.second;
  nearest.all = t.all;
  return Step::kNearer;
}

/// The best supporting plane. Branch-free: outcomes are unpredictable.
class BestPlane {
 public:
  HWY_INLINE BestPlane()
      : value_(-std::numeric_limits<double>::infinity()),
        per_(allLanes<4>(1.0)),
        direction_(allLanes<4>(1.0)) {}
  /// Offers the support value of a direction; `per` is the reciprocal of the direction's length.
  template <class Point>
  HWY_INLINE void offer(double value, double per, const Point& direction) {
    const double offered = per * value;
    const Mask<4> better = allLanes<4>(offered) > allLanes<4>(value_);
    direction_ = choose(
        better,
        sideBySide(allLanes<4>(direction.x), allLanes<4>(direction.y), allLanes<4>(direction.z)),
        direction_);
    per_ = choose(better, allLanes<4>(per), per_);
    // (Compilers turn a scalar maximum into a branch here.)
    const hn::CappedTag<double, 1> one;
    value_ = hn::GetLane(hn::Max(hn::Set(one, offered), hn::Set(one, value_)));
  }
  HWY_INLINE double value() const { return value_; }
  HWY_INLINE Triple normal() const {
    alignas(32) double coordinates[4];
    store(per_ * direction_, coordinates);
    return {coordinates[0], coordinates[1], coordinates[2]};
  }

 private:
  double value_;
  Lanes<4> per_;  // in each of them
  Lanes<4> direction_;
};

/// A search without a start from a cache evaluates its first direction and others around it at
/// once. Their points form a fan of triangles, whose nearest point saves two or three steps of six.
/// The fan has seven directions, or three if a support is expensive and the first direction is
/// good. These numbers, multiplied by the largest coordinate and a tilt, are added to the two
/// coordinates that follow the largest one. The last lane is the first direction itself.
constexpr int kFan = 8;
alignas(64) constexpr double kFanRing[2][kFan] = {
    {1, 0.62348980185873353, -0.2225209339563144, -0.90096886790241913, -0.90096886790241913,
     -0.2225209339563144, 0.62348980185873353, 0},
    {0, 0.78183148246802981, 0.97492791218182361, 0.43388373911755812, -0.43388373911755812,
     -0.97492791218182361, -0.78183148246802981, 0}};
alignas(32) constexpr double kSmallRing[2][4] = {{1, -0.5, -0.5, 0},
                                                 {0, 0.8660254037844386, -0.8660254037844386, 0}};

/// Directions around a first one.
template <int n>
struct Ring {
  Triple first;
  int axis;       ///< of its largest coordinate
  Lanes<n> u, v;  ///< added to the next coordinate and to the one after that, cyclically
};

template <int n>
HWY_INLINE Ring<n> ringAround(const Triple& first, const double* ring_u, const double* ring_v,
                              double tilt, double most) {
  const double x = std::abs(first.x), y = std::abs(first.y), z = std::abs(first.z);
  const int y_most = static_cast<int>(y > x);
  const double xy_most = std::max(x, y);
  const int axis = z > xy_most ? 2 : y_most;
  // (The largest coordinate is available before the length.)
  const Lanes<n> size = allLanes<n>(tilt * std::min(std::max(xy_most, z), most));
  return {first, axis, size * load<n>(ring_u), size * load<n>(ring_v)};
}

template <int n>
HWY_INLINE Points<n> directionsOf(const Ring<n>& ring) {
  const Lanes<n> zero = allLanes<n>(0.0);
  const Lanes<n> across[3] = {zero, ring.u, ring.v};
  return allLanes<n>(ring.first) +
         Points<n>{across[(3 - ring.axis) % 3], across[(4 - ring.axis) % 3], across[2 - ring.axis]};
}

/// The points that carry a search's nearest point, with their weights, some of which may be 0. For
/// four points around the origin the weights are placeholders.
struct Carriers {
  int count = 0;
  VertexIndices indices[4];
  Triple w[4];
  double weight[4];

  HWY_INLINE void dropWeightless() {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      indices[kept] = indices[i];
      w[kept] = w[i];
      weight[kept] = weight[i];
      kept += static_cast<int>(weight[i] > 0);
    }
    count = kept;
  }
};

/// A search on a difference of two cores. `Cores` has
///   Point: the faster kind of point, Triple or SamePoint;
///   Point support(const Point& n, VertexIndices& indices) const: the member with the
///     smallest w . n, for a direction of any length; `indices` are hints on input;
///   Points<n> fan(const Ring<n>& ring, const VertexIndices& hints, Lanes<n>& indices) const: the
///     members for all lanes of a ring, of kFan or of four;
///   double kTilt: of a fan's ring; 0: searches begin without a fan;
///   double kSmallTilt: of a ring of three; 0: never used;
///   double reach: the largest radius of a ring before its tilt (of bodies that are far from each
///     other for their size, the nearest points lie near the first direction);
///   bool supportIsExpensive() const, with a ring of three only: use that;
///   Points<4> members(const VertexIndices (&indices)[3]) const: three members side by side.
template <class Cores>
class Search {
 public:
  using Point = typename Cores::Point;
  /// A plane at value v proves v - lower_offset, a point at distance d proves d - upper_offset.
  HWY_INLINE Search(const Cores& cores, const DistanceRequest& request, double lower_offset,
                    double upper_offset, int iterations)
      : cores_(cores),
        request_(request),
        lower_offset_(lower_offset),
        upper_offset_(upper_offset),
        iterations_(iterations) {}

  /// Starts along `first`, of any length, or from the points of `carried` if that is not null;
  /// those are vertices of the pair. Ends with kLimit, kInside or kStagnated. kStagnated means that
  /// the request is met or that robust steps must take over.
  HWY_INLINE GjkEnd run(const Triple& first, const PairCache* carried, const VertexIndices& hints);

  HWY_INLINE const BestPlane& best() const { return best_; }
  HWY_INLINE int iterations() const { return iterations_; }
  HWY_INLINE const VertexIndices& lastIndices() const { return newest_indices_; }
  /// The points that the end is computed from; none before the first step.
  HWY_INLINE void carriers(GjkEnd end, Carriers& found) const;

 private:
  HWY_INLINE Step beginCarried(const PairCache& carried);
  HWY_INLINE void beginAlong(const Triple& first);
  HWY_INLINE void beginFan(const Triple& first);
  HWY_INLINE Step beginSmallFan(const Triple& first);
  HWY_INLINE Step beginAround(const Triple& first);
  HWY_INLINE void keepNewest() {
    alignas(32) static constexpr double kPlace[3][4] = {{0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}};
    const Mask<4> place = load<4>(kPlace[nearest_.lane]) > allLanes<4>(0.0);
    old_ = choose(place, allLanes<4>(newest_), old_);
    old_indices_ = choose(place, allLanes(newest_indices_), old_indices_);
  }

  const Cores& cores_;
  const DistanceRequest& request_;
  const double lower_offset_, upper_offset_;
  int iterations_;
  Points<4> old_;
  Lanes<4> old_indices_;
  Point newest_;
  VertexIndices newest_indices_;
  Nearest<Point> nearest_;
  BestPlane best_;
};

template <class Cores>
HWY_INLINE Step Search<Cores>::beginCarried(const PairCache& carried) {
  VertexIndices indices[3];
  HWY_UNROLL(3)
  for (int i = 0; i < 3; ++i) {
    const int k = i < carried.simplex_count ? i : 0;
    indices[i] = {carried.simplex_a[k], carried.simplex_b[k]};
  }
  old_ = cores_.members(indices);
  old_indices_ = sideBySide(allLanes(indices[0]), allLanes(indices[1]), allLanes(indices[2]));
  // One of them becomes the newest.
  pick(old_, Pick<4>(0), newest_);
  newest_indices_ = indices[0];
  const Step found = step(newest_, old_, nearest_);
  if (found == Step::kNearer) keepNewest();
  return found;
}

template <class Cores>
HWY_INLINE void Search<Cores>::beginAlong(const Triple& first) {
  ++iterations_;
  set(nearest_.direction, first);
  newest_ = cores_.support(nearest_.direction, newest_indices_);
  const Triple p = tripleOf(newest_);
  best_.offer(dot(first, p), 1 / std::sqrt(squared(first)), first);
  const double length_squared = squared(p);
  nearest_ = {newest_,          length_squared,   length_squared,  0,
              allLanes<4>(0.0), allLanes<4>(0.0), allLanes<4>(1.0)};
  old_ = allLanes<4>(newest_);
  old_indices_ = allLanes(newest_indices_);
}

template <class Cores>
HWY_INLINE Step Search<Cores>::beginSmallFan(const Triple& first) {
  ++iterations_;
  old_ = cores_.fan(
      ringAround<4>(first, kSmallRing[0], kSmallRing[1], Cores::kSmallTilt, cores_.reach),
      newest_indices_, old_indices_);
  const Pick<4> middle(3);
  pick(old_, middle, newest_);
  newest_indices_ = indicesIn(middle(old_indices_));
  best_.offer(dot(first, tripleOf(newest_)), 1 / std::sqrt(squared(first)), first);
  const Step found = step(newest_, old_, nearest_);
  if (found == Step::kNearer) keepNewest();
  return found;
}

template <class Cores>
HWY_INLINE void Search<Cores>::beginFan(const Triple& first) {
  ++iterations_;
  Lanes<kFan> indices;
  const Points<kFan> ring =
      cores_.fan(ringAround<kFan>(first, kFanRing[0], kFanRing[1], Cores::kTilt, cores_.reach),
                 newest_indices_, indices);
  const Pick<kFan> middle(kFan - 1);
  pick(ring, middle, newest_);
  newest_indices_ = indicesIn(middle(indices));
  best_.offer(dot(first, tripleOf(newest_)), 1 / std::sqrt(squared(first)), first);

  const Triangles<kFan> t = trianglesOf(allLanes<kFan>(newest_), ring);
  const Pick<kFan> best = leastLaneOf(t.norm_squared / t.part);
  take(t, best, newest_, nearest_);
  // The next step has points k, k + 1 and the middle.
  const int k = nearest_.lane;
  nearest_.lane = 0;
  nearest_.first = allLanes<4>(best.same(t.first));
  nearest_.second = allLanes<4>(best.same(t.second));
  nearest_.all = allLanes<4>(best.same(t.all));
  alignas(64) static constexpr std::int64_t kTriangle[kFan][kFan] = {
      {0, 1, 7, 7, 7, 7, 7, 7}, {1, 2, 7, 7, 7, 7, 7, 7}, {2, 3, 7, 7, 7, 7, 7, 7},
      {3, 4, 7, 7, 7, 7, 7, 7}, {4, 5, 7, 7, 7, 7, 7, 7}, {5, 6, 7, 7, 7, 7, 7, 7},
      {6, 0, 7, 7, 7, 7, 7, 7}, {7, 7, 7, 7, 7, 7, 7, 7}};
  const std::int64_t(&places)[kFan] = kTriangle[k];
  old_ = {fourOf(ring.x, places), fourOf(ring.y, places), fourOf(ring.z, places)};
  old_indices_ = fourOf(indices, places);
}

template <class Cores>
HWY_INLINE Step Search<Cores>::beginAround(const Triple& first) {
  if constexpr (Cores::kSmallTilt > 0) {
    if (cores_.supportIsExpensive()) return beginSmallFan(first);
  }
  beginFan(first);
  return Step::kNearer;
}

template <class Cores>
HWY_INLINE GjkEnd Search<Cores>::run(const Triple& first, const PairCache* carried,
                                     const VertexIndices& hints) {
  newest_indices_ = hints;
  Step last = Step::kNearer;
  if (carried != nullptr) {
    last = beginCarried(*carried);
  } else if constexpr (Cores::kTilt > 0) {
    if (!std::isnan(request_.threshold)) {
      beginAlong(first);  // (The first direction alone decides most thresholds.)
    } else {
      last = beginAround(first);
    }
  } else {
    beginAlong(first);
  }
  while (last == Step::kNearer) {
    // Same as Progress::enough(), for an upper end without its points. (Continues if that equals
    // the threshold.)
    const double upper = std::sqrt(nearest_.norm_squared) - upper_offset_;
    double lower = best_.value() - lower_offset_;
    if (eitherIsGreater(BodyLanes{lower, -upper},
                        BodyLanes{request_.threshold, -request_.threshold}) ||
        (!request_.depth && upper <= 0) ||
        (upper - lower <= request_.tolerance && (lower > 0 || upper <= 0))) {
      return GjkEnd::kStagnated;
    }
    if (iterations_ >= request_.iteration_limit) return GjkEnd::kLimit;
    // (The square of a tiny feature has lost its digits.)
    if (HWY_UNLIKELY(!(nearest_.direction_squared > kLeastSquare))) return GjkEnd::kStagnated;
    ++iterations_;
    const double per = 1 / std::sqrt(nearest_.direction_squared);
    newest_ = cores_.support(nearest_.direction, newest_indices_);
    const Triple direction = tripleOf(nearest_.direction);
    best_.offer(dot(direction, tripleOf(newest_)), per, nearest_.direction);
    lower = best_.value() - lower_offset_;
    if (lower > request_.threshold || (upper - lower <= request_.tolerance && lower > 0)) {
      return GjkEnd::kStagnated;
    }
    Nearest<Point> next;
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
  alignas(32) double x[4], y[4], z[4], indices[4], first[4], second[4], all[4];
  store(old_.x, x);
  store(old_.y, y);
  store(old_.z, z);
  store(old_indices_, indices);
  const auto keep = [&](int place, double weight) HWY_ATTR {
    found.indices[found.count] = indicesIn(indices[place]);
    found.w[found.count] = {x[place], y[place], z[place]};
    found.weight[found.count++] = std::max(weight, 0.0);
  };
  if (inside) {
    for (int i = 0; i < 3; ++i) keep(i, 0.25);
    found.indices[3] = newest_indices_;
    found.w[3] = tripleOf(newest_);
    found.weight[3] = 0.25;
    found.count = 4;
    return;
  }
  store(nearest_.first, first);
  store(nearest_.second, second);
  store(nearest_.all, all);
  const double weight_first = first[k] / all[k], weight_second = second[k] / all[k];
  keep(kLeftOut[k], 1 - weight_first - weight_second);
  keep(k, weight_first);
  keep((k + 1) % 3, weight_second);
}

/// Offers the best plane of a finished search, and its iterations; `found` carries its end.
template <class Cores>
HWY_INLINE void offerPlane(const Search<Cores>& search, GjkEnd end, Progress& progress,
                           Carriers& found) {
  progress.iterations = search.iterations();
  const Triple n = search.best().normal();
  progress.offerLower(search.best().value(), {n.x, n.y, n.z});
  search.carriers(end, found);
  found.dropWeightless();
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
