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

#include "collision/base/lanes-inl.h"
#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "collision/base/triple.h"
#include "collision/convex/gjk/gjk.h"
#include "collision/shapes/hull_scan-inl.h"

// A step takes a new point p of the difference and three older ones (the same one several times at
// first). In exact arithmetic the nearest point of their hull is on a triangle that p has with two
// of the others. So lane k looks at one: p, point k and point k + 1 (modulo three), or, where the
// origin is not above its inside, at its edge from p to point k. The older point that the best lane
// does without makes room for p; one without weight may stay, which does no harm.
//
// Nothing here calls code of another target: code without AVX that runs while registers' upper
// halves are in use costs hundreds of cycles, and compilers forget to clear them.
//
// Sizes are below kLargestForLanes. Whatever rounding does here costs steps only: both ends that
// are offered rest on points and support values alone, as everywhere (gjk.cc says how they are
// rounded; a direction's length is divided out of its support value, which errs by no more than a
// unit vector made of it would). What plain arithmetic cannot settle - flat simplices, the origin
// inside, ends that rounding keeps apart - is left to runGjk().

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

/// Of the two vertices that a point of the difference is made of.
struct VertexNames {
  std::int32_t a, b;
};
/// In a lane, which is only ever copied. (Put together in a register: two halves that were written
/// to memory one by one are not read back in one without a stall.)
HWY_INLINE double inLane(const VertexNames& names) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::uint32_t>(names.b))
                                   << 32U |
                               static_cast<std::uint32_t>(names.a));
}
HWY_INLINE VertexNames namesIn(double lane) {
  const std::uint64_t both = std::bit_cast<std::uint64_t>(lane);
  return {static_cast<std::int32_t>(static_cast<std::uint32_t>(both)),
          static_cast<std::int32_t>(both >> 32U)};
}
HWY_INLINE Lanes<4> allLanes(const VertexNames& names) { return allLanes<4>(inLane(names)); }

/// The lane of the point that is not on the triangle of lane k.
constexpr int kLeftOut[3] = {2, 0, 1};

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
/// The cell that is to be looked at for that; null where there is none.
HWY_INLINE const HullCell* cellFor(const HullSupport& support, const Triple& d) {
  return support.length() == 0 ? cellOf(support, d.x, d.y, d.z) : nullptr;
}
/// The same with that cell known.
HWY_INLINE int scannedSupport(const HullSupport& support, const HullCell* cell, const Triple& d,
                              std::int32_t& hint) {
  return support.length() == 0 ? scanCell(support, cell, d.x, d.y, d.z, hint)
                               : calledColumns(support, d.x, d.y, d.z);
}

/// What is nearest to the origin on the triangles that a point p has with two neighbours of a ring,
/// lane by lane.
template <int n>
struct Triangles {
  Points<n> e, f;               ///< from point k to p, and from the next one
  Points<n> normal;             ///< e x f
  Lanes<n> height;              ///< p . normal
  Points<n> direction;          ///< of the nearest point, any length
  Lanes<n> direction_squared;   ///< its length squared
  Lanes<n> norm_squared, part;  ///< of the nearest point, times `part`, which is above 0
  Lanes<n> first, second, all;  ///< weights of points k, k + 1 (parts of `all`)
  Mask<n> on_edge;              ///< it is on the edge from p to point k, at neither end
};

// Nothing waits for a division.
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
  // Weights of the lane's points, times nn.
  const Lanes<n> area_e = ff * pe - ef * pf, area_f = ee * pf - ef * pe;
  const Mask<n> inside = (area_e > zero) & (area_f > zero) & (nn - area_e > area_f);
  // The edge's nearest point is along / whole of the way from p to the lane's.
  const Mask<n> leaves = pe > zero, between = leaves & (ee > pe);
  const Lanes<n> whole = choose(between, ee, one),
                 along = choose(between, pe, choose(leaves, one, zero));
  const Points<n> on_edge = whole * p - along * t.e;
  const Lanes<n> edge_squared = dot(on_edge, on_edge);
  // A triangle's normal points away from the origin or towards it.
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

/// What a step found. Points and directions are told as the cores take them: single, or in all
/// lanes.
template <class Point>
struct Nearest {
  Point direction;               ///< of the nearest point, any length
  double direction_squared = 0;  ///< its length squared
  double norm_squared = 0;       ///< of the nearest point
  int lane = -1;                 ///< -1: nothing is known yet
  Lanes<4> first, second, all;   ///< as Triangles has them, of that lane
};

/// What a lane of the triangles of p, the newest point, says of the nearest one.
template <int n, class Point>
HWY_INLINE void take(const Triangles<n>& t, const Pick<n>& best, const Point& newest,
                     Nearest<Point>& nearest) {
  pick(t.direction, best, nearest.direction);
  nearest.direction_squared = best(t.direction_squared);
  nearest.norm_squared = best(t.norm_squared) / best(t.part);
  nearest.lane = best.lane();
  // Near contact what is left of the edge's point after cancellation is not at a right angle to
  // the edge any more: once more. (Not at an edge's end. All in one branch: most pairs that are so
  // near have their nearest points elsewhere.)
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

/// Where the origin is to the tetrahedron of p and three older points; kNearer when outside.
HWY_INLINE Step heldBy(const Triangles<4>& t) {
  const Lanes<4> volume = dot(t.normal, nextInRing(t.f)), zero = allLanes<4>(0.0);
  // The origin's weight of the point that lane k leaves out is height / volume.
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

/// Takes the newest point in.
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

/// The best supporting plane, without a branch: which it will be nobody can foretell.
class BestPlane {
 public:
  HWY_INLINE BestPlane()
      : value_(-std::numeric_limits<double>::infinity()),
        per_(allLanes<4>(1.0)),
        direction_(allLanes<4>(1.0)) {}
  template <class Point>
  /// A supporting value, of a direction with the reciprocal `per` of its length.
  HWY_INLINE void offer(double value, double per, const Point& direction) {
    const double offered = per * value;
    const Mask<4> better = allLanes<4>(offered) > allLanes<4>(value_);
    direction_ = choose(
        better,
        sideBySide(allLanes<4>(direction.x), allLanes<4>(direction.y), allLanes<4>(direction.z)),
        direction_);
    per_ = choose(better, allLanes<4>(per), per_);
    // (Of two single numbers compilers take the larger one by a branch here.)
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

/// A cold search asks along its first direction and others around it at once, which make a fan of
/// triangles: the nearest point of seven saves two steps or three out of six; three do where each
/// answer is dear and the first direction good. What is added to the two coordinates of the first
/// direction that follow its largest one, times that and a tilt. The last lane is the first
/// direction itself.
constexpr int kFan = 8;
alignas(64) constexpr double kFanRing[2][kFan] = {
    {1, 0.62348980185873353, -0.2225209339563144, -0.90096886790241913, -0.90096886790241913,
     -0.2225209339563144, 0.62348980185873353, 0},
    {0, 0.78183148246802981, 0.97492791218182361, 0.43388373911755812, -0.43388373911755812,
     -0.97492791218182361, -0.78183148246802981, 0}};
alignas(32) constexpr double kFewRing[2][4] = {{1, -0.5, -0.5, 0},
                                               {0, 0.8660254037844386, -0.8660254037844386, 0}};

/// Directions around a first one.
template <int n>
struct Ring {
  Triple first;
  int axis;       ///< its largest coordinate's
  Lanes<n> u, v;  ///< what is added to the next coordinate and to the one after that, in a circle
};

template <int n>
HWY_INLINE Ring<n> ringAround(const Triple& first, const double* ring_u, const double* ring_v,
                              double tilt, double most) {
  const double x = std::abs(first.x), y = std::abs(first.y), z = std::abs(first.z);
  const int y_most = static_cast<int>(y > x);
  const double xy_most = std::max(x, y);
  const int axis = z > xy_most ? 2 : y_most;
  // (The largest coordinate is known before the length is.)
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

/// The points that carry what a search found, with their weights; some may have none. Of the four
/// around the origin no weight is known.
struct Carriers {
  int count = 0;
  VertexNames names[4];
  Triple w[4];
  double weight[4];

  HWY_INLINE void dropWeightless() {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      names[kept] = names[i];
      w[kept] = w[i];
      weight[kept] = weight[i];
      kept += static_cast<int>(weight[i] > 0);
    }
    count = kept;
  }
};

/// `Cores` has
///   Point, the kind of point that is quicker: Triple or SamePoint;
///   Point support(const Point& n, VertexNames& names) const: the member of the difference with the
///     smallest w . n, for a direction of any length; names come in as hints;
///   Points<n> fan(const Ring<n>& ring, const VertexNames& hints, Lanes<n>& names) const: the same
///     for all lanes of a ring, kFan or four of them;
///   double kTilt, of a fan's ring; 0 where there is no fan to begin with;
///   double kTiltOfFew, of a ring of three; 0 where there never is one;
///   double reach, what a ring's radius is at most before it is tilted: bodies that are far from
///     each other for their size are met near the first direction;
///   bool areDear() const, where there may be: three are enough, since each answer is dear and the
///     first direction good;
///   Points<4> members(const VertexNames (&names)[3]) const: three members side by side.
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

  /// First along `first`, of any length; or, where `carried` is not null, from its points, which
  /// are vertices of the pair. Ends with kLimit, kInside or, where the request is met or robust
  /// steps must go on, with kStagnated.
  HWY_INLINE GjkEnd run(const Triple& first, const PairCache* carried, const VertexNames& hints);

  HWY_INLINE const BestPlane& best() const { return best_; }
  HWY_INLINE int iterations() const { return iterations_; }
  HWY_INLINE const VertexNames& lastNames() const { return newest_names_; }
  /// What the end rests on; none where no step was made.
  HWY_INLINE void carriers(GjkEnd end, Carriers& found) const;

 private:
  HWY_INLINE Step beginCarried(const PairCache& carried);
  HWY_INLINE void beginAlong(const Triple& first);
  HWY_INLINE void beginFan(const Triple& first);
  HWY_INLINE Step beginFew(const Triple& first);
  HWY_INLINE Step beginAround(const Triple& first);
  HWY_INLINE void keepNewest() {
    alignas(32) static constexpr double kPlace[3][4] = {{0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}};
    const Mask<4> place = load<4>(kPlace[nearest_.lane]) > allLanes<4>(0.0);
    old_ = choose(place, allLanes<4>(newest_), old_);
    old_names_ = choose(place, allLanes(newest_names_), old_names_);
  }

  const Cores& cores_;
  const DistanceRequest& request_;
  const double lower_offset_, upper_offset_;
  int iterations_;
  Points<4> old_;
  Lanes<4> old_names_;
  Point newest_;
  VertexNames newest_names_;
  Nearest<Point> nearest_;
  BestPlane best_;
};

template <class Cores>
HWY_INLINE Step Search<Cores>::beginCarried(const PairCache& carried) {
  VertexNames names[3];
  HWY_UNROLL(3)
  for (int i = 0; i < 3; ++i) {
    const int k = i < carried.simplex_count ? i : 0;
    names[i] = {carried.simplex_a[k], carried.simplex_b[k]};
  }
  old_ = cores_.members(names);
  old_names_ = sideBySide(allLanes(names[0]), allLanes(names[1]), allLanes(names[2]));
  // One of the points as the newest.
  pick(old_, Pick<4>(0), newest_);
  newest_names_ = names[0];
  const Step found = step(newest_, old_, nearest_);
  if (found == Step::kNearer) keepNewest();
  return found;
}

template <class Cores>
HWY_INLINE void Search<Cores>::beginAlong(const Triple& first) {
  ++iterations_;
  set(nearest_.direction, first);
  newest_ = cores_.support(nearest_.direction, newest_names_);
  const Triple p = tripleOf(newest_);
  best_.offer(dot(first, p), 1 / std::sqrt(squared(first)), first);
  const double length_squared = squared(p);
  nearest_ = {newest_,          length_squared,   length_squared,  0,
              allLanes<4>(0.0), allLanes<4>(0.0), allLanes<4>(1.0)};
  old_ = allLanes<4>(newest_);
  old_names_ = allLanes(newest_names_);
}

template <class Cores>
HWY_INLINE Step Search<Cores>::beginFew(const Triple& first) {
  ++iterations_;
  old_ = cores_.fan(ringAround<4>(first, kFewRing[0], kFewRing[1], Cores::kTiltOfFew, cores_.reach),
                    newest_names_, old_names_);
  const Pick<4> middle(3);
  pick(old_, middle, newest_);
  newest_names_ = namesIn(middle(old_names_));
  best_.offer(dot(first, tripleOf(newest_)), 1 / std::sqrt(squared(first)), first);
  const Step found = step(newest_, old_, nearest_);
  if (found == Step::kNearer) keepNewest();
  return found;
}

template <class Cores>
HWY_INLINE void Search<Cores>::beginFan(const Triple& first) {
  ++iterations_;
  Lanes<kFan> names;
  const Points<kFan> ring =
      cores_.fan(ringAround<kFan>(first, kFanRing[0], kFanRing[1], Cores::kTilt, cores_.reach),
                 newest_names_, names);
  const Pick<kFan> middle(kFan - 1);
  pick(ring, middle, newest_);
  newest_names_ = namesIn(middle(names));
  best_.offer(dot(first, tripleOf(newest_)), 1 / std::sqrt(squared(first)), first);

  const Triangles<kFan> t = trianglesOf(allLanes<kFan>(newest_), ring);
  const Pick<kFan> best = leastLaneOf(t.norm_squared / t.part);
  take(t, best, newest_, nearest_);
  // Points k, k + 1 and the middle are what the next step has.
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
  old_names_ = fourOf(names, places);
}

template <class Cores>
HWY_INLINE Step Search<Cores>::beginAround(const Triple& first) {
  if constexpr (Cores::kTiltOfFew > 0) {
    if (cores_.areDear()) return beginFew(first);
  }
  beginFan(first);
  return Step::kNearer;
}

template <class Cores>
HWY_INLINE GjkEnd Search<Cores>::run(const Triple& first, const PairCache* carried,
                                     const VertexNames& hints) {
  newest_names_ = hints;
  Step last = Step::kNearer;
  if (carried != nullptr) {
    last = beginCarried(*carried);
  } else if constexpr (Cores::kTilt > 0) {
    if (!std::isnan(request_.threshold)) {
      beginAlong(first);  // (A threshold is most often decided by the first direction alone.)
    } else {
      last = beginAround(first);
    }
  } else {
    beginAlong(first);
  }
  while (last == Step::kNearer) {
    // As Progress::enough(), but with an upper end that is not yet made of points (and may go on
    // where that is the threshold itself).
    const double upper = std::sqrt(nearest_.norm_squared) - upper_offset_;
    double lower = best_.value() - lower_offset_;
    if (eitherIsGreater(BodyLanes{lower, -upper},
                        BodyLanes{request_.threshold, -request_.threshold}) ||
        (!request_.depth && upper <= 0) ||
        (upper - lower <= request_.tolerance && (lower > 0 || upper <= 0))) {
      return GjkEnd::kStagnated;
    }
    if (iterations_ >= request_.iteration_limit) return GjkEnd::kLimit;
    // (Of features that are all but none the square has lost its digits.)
    if (HWY_UNLIKELY(!(nearest_.direction_squared > kLeastSquare))) return GjkEnd::kStagnated;
    ++iterations_;
    const double per = 1 / std::sqrt(nearest_.direction_squared);
    newest_ = cores_.support(nearest_.direction, newest_names_);
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
  alignas(32) double x[4], y[4], z[4], names[4], first[4], second[4], all[4];
  store(old_.x, x);
  store(old_.y, y);
  store(old_.z, z);
  store(old_names_, names);
  const auto keep = [&](int place, double weight) HWY_ATTR {
    found.names[found.count] = namesIn(names[place]);
    found.w[found.count] = {x[place], y[place], z[place]};
    found.weight[found.count++] = std::max(weight, 0.0);
  };
  if (inside) {
    for (int i = 0; i < 3; ++i) keep(i, 0.25);
    found.names[3] = newest_names_;
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

/// Tells of a search that has ended its steps and its best plane; `found` is what it ended on.
template <class Cores>
HWY_INLINE void tell(const Search<Cores>& search, GjkEnd end, Progress& progress, Carriers& found) {
  progress.iterations = search.iterations();
  const Triple n = search.best().normal();
  progress.offerLower(search.best().value(), {n.x, n.y, n.z});
  search.carriers(end, found);
  found.dropWeightless();
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
