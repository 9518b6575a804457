#include <algorithm>
#include <cmath>

#include "collision/convex/hull_pairs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/convex/hull_pairs_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/base/dispatch.h"
#include "collision/base/pose_check.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/convex/gjk/support.h"
#include "collision/convex/gjk/vertex_gjk.h"
#include "collision/convex/gjk/vertex_search-inl.h"
#include "collision/convex/pairs/closed_form.h"

// clang-format off
// Rounding of the two ends (see gjk.cc), in units of u L with u = kUnitRoundoff and L = extent A + extent B + |t|,
// in the world's axes with the origin at B's:
//   the translation                                      1 |t|
//   a vertex                                             3 sqrt(3) of its extent; of A 1 extent and 1 |t| more
//   the choice among placed vertices                     6 of extents and |t|
//     or among others, the direction turned back         2 * 5.2 of the extent more, and without |t|
//   b - a                                                1 L
//   the dot product                                      3 L
//   the direction's length                               3 L
// In sum 30 of an extent and 15 |t|. A rotation's departure errs by 9 more, and the caller may have meant a rotation
// that is off by half of it: less than kSupportRounding + kPoseRounding = 56.
// Indices within values add to that (see PlacedVertices).
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

// A hull at its pose: R v + t.
class WorldHull {
 public:
  HWY_INLINE WorldHull(const Shape& shape, const Eigen::Matrix3d& R, const Triple& t)
      : hull_(*shape.hull()), support_(hull_.support()), R_(R), t_(t), extent_(shape.extent()) {}

  HWY_INLINE Triple turnedBack(const Triple& n) const { return rotatedBack(R_, n); }
  HWY_INLINE const HullCell* cellOf(const Triple& d) const { return cellFor(support_, d); }
  // The vertex farthest along d (in the hull's frame), for the cell of d.
  HWY_INLINE Triple farthest(const Triple& d, const HullCell* cell, std::int32_t& index) const {
    const int found = scannedSupport(support_, cell, d, index);
    index = HWY_LIKELY(found >= 0) ? found : climbed(d, index);
    return vertex(index);
  }
  HWY_INLINE Triple vertex(int index) const { return placed(support_.corners()[index]); }
  // Three vertices side by side.
  HWY_INLINE Points<4> vertices(int i, int j, int k) const {
    const HullCorner* v = support_.corners();
    return rotated(R_, sideBySide(tripleOf(v[i]), tripleOf(v[j]), tripleOf(v[k]))) +
           allLanes<4>(t_);
  }

 private:
  HWY_INLINE Triple placed(const HullCorner& v) const { return rotated(R_, tripleOf(v)) + t_; }
  // The hull climb of farthestPoint().
  HWY_NOINLINE std::int32_t climbed(const Triple& d, std::int32_t hint) const {
    const double length = std::sqrt(squared(d));
    return climbFarthest(hull_, support_.points(), static_cast<int>(hull_.vertices().size()),
                         Vector(d.x / length, d.y / length, d.z / length), hint,
                         8 * kUnitRoundoff * extent_);
  }

  const ConvexHull& hull_;
  const HullSupport& support_;
  const Eigen::Matrix3d& R_;
  const Triple t_;
  const double extent_;
};

struct WorldCores {
  using Point = Triple;
  static constexpr double kTilt = 0;  // (used with a threshold or a cache)
  WorldHull a, b;
  HWY_INLINE Triple support(const Triple& n, VertexIndices& indices) const {
    // Looks up both cells first, because reads of a hull's vertices wait for its cell and fill the
    // reorder buffer.
    const Triple d_a = a.turnedBack(n), d_b = b.turnedBack(-n);
    const HullCell *cell_a = a.cellOf(d_a), *cell_b = b.cellOf(d_b);
    return b.farthest(d_b, cell_b, indices.b) - a.farthest(d_a, cell_a, indices.a);
  }
  HWY_INLINE Points<4> members(const VertexIndices (&indices)[3]) const {
    return b.vertices(indices[0].b, indices[1].b, indices[2].b) -
           a.vertices(indices[0].a, indices[1].a, indices[2].a);
  }
  HWY_INLINE Triple pointOfA(const VertexIndices& indices) const { return a.vertex(indices.a); }
  HWY_INLINE VertexIndices verticesOf(const VertexIndices& indices) const { return indices; }
};

// Up to 8 kEights vertices of a hull, or of its mirror image, placed at a pose once in vector
// lanes, so that neither directions nor vertices are rotated for each support.
//
// The least value along a direction carries the index of its vertex in its last bits. If two values
// differ in these bits only, the wrong one may win: an error below 8 kEights units in the last
// place.
template <int kEights>
class PlacedVertices {
 public:
  static constexpr int kMost = 8 * kEights;
  // In units of u times the size of a value's terms.
  static constexpr double kIndexRounding = 2 * kMost;

  static HWY_INLINE bool takes(const HullSupport& support) {
    return support.length() > 0 && support.length() <= kMost;
  }
  HWY_INLINE PlacedVertices(const ConvexHull& hull, const Eigen::Matrix3d& R, const Triple& t,
                            double sign)
      : count_(static_cast<int>(hull.vertices().size())) {
    const HullSupport& support = hull.support();
    // A shorter hull is padded with copies of its first eight.
    const int length = support.length();
    HWY_UNROLL(4)
    for (int i = 0; i < kMost; i += kStep) {
      const int from = kEights == 1 || i < length ? i : i % 8;
      placeColumns(support, from, R, t, sign, at_[0] + i, at_[1] + i, at_[2] + i);
    }
  }

  HWY_INLINE Triple vertex(int index) const {
    return {at_[0][index], at_[1][index], at_[2][index]};
  }
  // The vertex with the least v . n.
  HWY_INLINE SamePoint farthest(const SamePoint& n, std::int32_t& index) const {
    const Widest d;
    const Same least =
        leastLane(leastOf<0, static_cast<std::size_t>(kMost / kStep)>([&](std::size_t i) HWY_ATTR {
          const std::size_t at = i * hn::MaxLanes(d);
          return tagged(along(n, at), hn::Load(hn::RebindToSigned<Widest>(), kPlaces + at));
        }));
    const auto place = placeOf(least);
    index = static_cast<std::int32_t>(hn::GetLane(place));
#if HWY_CAP_GE512
    if constexpr (kEights <= 2) {
      return {inRegisters(at_[0], place), inRegisters(at_[1], place), inRegisters(at_[2], place)};
    }
#endif
    SamePoint found;
    set(found, vertex(index));
    return found;
  }
  using Place = hn::Vec<hn::RebindToSigned<Widest>>;
  // The vertices with the least v . n for each direction of a ring, and their indices in `places`.
  // Each value is the one along the first direction plus what two coordinates add.
  HWY_INLINE Points<kFan> farthest(const Ring<kFan>& ring, Place* places) const {
    const Widest d;
    const hn::RebindToSigned<Widest> di;
    alignas(64) double first[std::size_t{kMost}];
    SamePoint n;
    set(n, ring.first);
    HWY_UNROLL(4)
    for (std::size_t i = 0; i < std::size_t{kMost}; i += hn::MaxLanes(d))
      hn::Store(along(n, i), d, first + i);
    const double *const u = at_[0] + std::ptrdiff_t{kMost} * (ring.axis == 2 ? 0 : ring.axis + 1),
                        *const v =
                            at_[0] + std::ptrdiff_t{kMost} * (ring.axis == 0 ? 2 : ring.axis - 1);
    Lanes<kFan> least = allLanes<kFan>(std::numeric_limits<double>::infinity());
    // (Each number is broadcast from memory: from a register it would take a shuffle.)
    const int count = kEights == 1 ? kMost : count_;  // (Few of eight are padding.)
    HWY_UNROLL(1)
    for (int i = 0; i < count; ++i) {
      const Lanes<kFan> value =
          allLanes<kFan>(u[i]) * ring.u + allLanes<kFan>(first[i]) + allLanes<kFan>(v[i]) * ring.v;
      least = eachLane<kFan>(
          [&](int k) HWY_ATTR { return hn::Min(least.v[k], tagged(value.v[k], hn::Set(di, i))); });
    }
    Points<kFan> found;
    for (int i = 0; i < kRegisters<kFan>; ++i) {
      const Place place = placeOf(least.v[i]);
      places[i] = place;
#if HWY_CAP_GE512
      if constexpr (kEights <= 2) {
        found.x.v[i] = inRegisters(at_[0], place);
        found.y.v[i] = inRegisters(at_[1], place);
        found.z.v[i] = inRegisters(at_[2], place);
        continue;
      }
#endif
      found.x.v[i] = gathered(at_[0], place);
      found.y.v[i] = gathered(at_[1], place);
      found.z.v[i] = gathered(at_[2], place);
    }
    return found;
  }

 private:
  static constexpr int kStep = static_cast<int>(hn::MaxLanes(Widest()));
  alignas(64) static constexpr std::int64_t kPlaces[32] = {
      0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
      16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};

  // The values along n of the vertices from `at` on.
  HWY_INLINE Same along(const SamePoint& n, std::size_t at) const {
    const Widest d;
    return hn::Add(
        hn::Add(hn::Mul(hn::Load(d, at_[0] + at), n.x), hn::Mul(hn::Load(d, at_[1] + at), n.y)),
        hn::Mul(hn::Load(d, at_[2] + at), n.z));
  }
  // Replaces the last bits of a value by an index, and reads it back.
  static HWY_INLINE Same tagged(Same value, Place place) {
    const hn::RebindToSigned<Widest> di;
    return hn::BitCast(Widest(), hn::OrAnd(place, hn::BitCast(di, value), hn::Set(di, -kMost)));
  }
  static HWY_INLINE Place placeOf(Same tagged) {
    const hn::RebindToSigned<Widest> di;
    return hn::And(hn::BitCast(di, tagged), hn::Set(di, kMost - 1));
  }
#if HWY_CAP_GE512
  // A lookup lane by lane, in registers.
  static HWY_INLINE Same inRegisters(const double* coordinates, Place place) {
    const Widest d;
    const hn::RebindToSigned<Widest> di;
    const auto lane = hn::IndicesFromVec(d, hn::And(place, hn::Set(di, 7)));
    const Same first = hn::TableLookupLanes(hn::Load(d, coordinates), lane);
    if constexpr (kEights == 1) return first;
    const Same second = hn::TableLookupLanes(hn::Load(d, coordinates + kMost - 8), lane);
    return hn::IfThenElse(hn::RebindMask(d, hn::Gt(place, hn::Set(di, 7))), second, first);
  }
#endif
  template <std::size_t kBegin, std::size_t kEnd, class Value>
  static HWY_INLINE Same leastOf(const Value& value) {
    if constexpr (kEnd - kBegin == 1) {
      return value(kBegin);
    } else {
      constexpr std::size_t kMiddle = (kBegin + kEnd) / 2;
      return hn::Min(leastOf<kBegin, kMiddle>(value), leastOf<kMiddle, kEnd>(value));
    }
  }

  const int count_;
  alignas(64) double at_[3][std::size_t{kMost}];  // coordinates
};

// A is mirrored, so that the difference is a sum.
template <int kEights>
struct PlacedCores {
  using Point = SamePoint;
  static constexpr double kTilt = kEights <= 2 ? 1.1 : 0.72;  // both the best of a few
  static constexpr double kReach = 0.6;
  static constexpr double kSmallTilt = 0;
  const ConvexHull &hull_a, &hull_b;
  PlacedVertices<kEights> minus_a, b;
  const double reach;
  HWY_INLINE SamePoint support(const SamePoint& n, VertexIndices& indices) const {
    const SamePoint p = minus_a.farthest(n, indices.a), q = b.farthest(n, indices.b);
    return {hn::Add(p.x, q.x), hn::Add(p.y, q.y), hn::Add(p.z, q.z)};
  }
  HWY_INLINE Points<kFan> fan(const Ring<kFan>& ring, const VertexIndices& /*hints*/,
                              Lanes<kFan>& indices) const {
    typename PlacedVertices<kEights>::Place places_a[kRegisters<kFan>], places_b[kRegisters<kFan>];
    const Points<kFan> all = minus_a.farthest(ring, places_a) + b.farthest(ring, places_b);
    indices = eachLane<kFan>([&](int i) HWY_ATTR {
      return hn::BitCast(Widest(), hn::Or(places_a[i], hn::ShiftLeft<32>(places_b[i])));
    });
    return all;
  }
  HWY_INLINE Points<4> members(const VertexIndices (&indices)[3]) const {
    const auto member = [&](int i) HWY_ATTR {
      return minus_a.vertex(indices[i].a) + b.vertex(indices[i].b);
    };
    return sideBySide(member(0), member(1), member(2));
  }
  HWY_INLINE Triple pointOfA(const VertexIndices& indices) const {
    return -minus_a.vertex(indices.a);
  }
  HWY_INLINE VertexIndices verticesOf(const VertexIndices& indices) const {
    return {vertexOf(hull_a, indices.a), vertexOf(hull_b, indices.b)};
  }

 private:
  // Columns are padded with copies of the first vertex, placed columns with copies of the first
  // eight.
  static HWY_INLINE std::int32_t vertexOf(const ConvexHull& hull, std::int32_t index) {
    const std::int32_t place = index < hull.support().length() ? index : index % 8;
    return place < static_cast<std::int32_t>(hull.vertices().size()) ? place : 0;
  }
};

// The input of a search.
struct Pair {
  const Shape &a, &b;
  const Pose &X_WA, &X_WB;
  const DistanceRequest& request;
  PairCache* cache;
  Triple t;  // of A, from B's origin
  double size, rounding;
  VertexIndices hints;
  bool needles;  // at least one of them is a needle
};

HWY_INLINE Triple betweenMiddles(const Pair& pair) {
  const HullSupport &a = pair.a.hull()->support(), &b = pair.b.hull()->support();
  return rotated(pair.X_WB.rotation, tripleOf(b.middle())) -
         (rotated(pair.X_WA.rotation, tripleOf(a.middle())) + pair.t);
}

// The vector from one axis to the other where they are nearest, because a needle's nearest point
// may be far from its middle. For a hull that is not a needle, its middle is used.
HWY_INLINE Triple betweenAxes(const Pair& pair) {
  const HullSupport &a = pair.a.hull()->support(), &b = pair.b.hull()->support();
  const Triple axis_a = rotated(pair.X_WA.rotation, tripleOf(a.axis())),
               axis_b = rotated(pair.X_WB.rotation, tripleOf(b.axis()));
  const Triple middle = betweenMiddles(pair);
  double s_a = 0, s_b = 0;
  nearestOnAxes(dot(axis_a, axis_b), -dot(axis_a, middle), -dot(axis_b, middle), a.halfLength(),
                b.halfLength(), s_a, s_b);
  const Triple way = middle + (s_b * axis_b - s_a * axis_a);
  return squared(way) > kLeastSum * kLeastSum ? way : Triple{1, 0, 0};
}

// The cached direction if it is valid, otherwise from A's middle to B's. Its length is the distance
// of the middles, which is compared with a fan's reach.
HWY_INLINE Triple firstDirection(const Pair& pair) {
  if (pair.cache != nullptr) {
    const Triple n = tripleOf(pair.cache->direction_B);
    const double length_squared = squared(n);
    if (length_squared > 0.25 && length_squared < 4) {  // NaN fails
      const double apart = std::sqrt(squared(betweenMiddles(pair)));
      return std::max(apart, kLeastSum) * rotated(pair.X_WB.rotation, n);
    }
  }
  if (pair.needles) return betweenAxes(pair);
  const Triple middle = betweenMiddles(pair);
  return squared(middle) > kLeastSum * kLeastSum ? middle : Triple{1, 0, 0};
}

// Writes the result; false if the request is not met.
template <class Cores>
HWY_INLINE bool answered(const Pair& pair, const Cores& cores, const Search<Cores>& search,
                         const Carriers& found, double lower_offset, double upper_offset,
                         DistanceResult& result) {
  const DistanceRequest& request = pair.request;
  PairCache* const cache = pair.cache;
  if (HWY_UNLIKELY(found.count != 3)) return false;
  // Branch-free: which weights are 0 is unpredictable.
  const Triple w =
      found.weight[0] * found.w[0] + found.weight[1] * found.w[1] + found.weight[2] * found.w[2];
  const Triple p = found.weight[0] * cores.pointOfA(found.indices[0]) +
                   found.weight[1] * cores.pointOfA(found.indices[1]) +
                   found.weight[2] * cores.pointOfA(found.indices[2]);
  // As in Progress.
  const Interval separation = {search.best().value() - lower_offset,
                               std::sqrt(squared(w)) - upper_offset};
  const bool enough = (separation.width() <= request.tolerance && isSignKnown(separation)) ||
                      isDecided(separation, request);
  const Triple point_a = tripleOf(pair.X_WB.translation) + p, point_b = point_a + w;
  const Triple n = search.best().normal();
  if (HWY_UNLIKELY(!enough)) return false;
  result.distance = separation;
  result.status = statusOf(separation, request);
  result.iterations = search.iterations();
  write(point_a, result.point_a);
  write(point_b, result.point_b);
  write(n, result.normal);
  if (cache != nullptr) {
    write(rotatedBack(pair.X_WB.rotation, n), cache->direction_B);
    const VertexIndices last = cores.verticesOf(search.lastIndices());
    cache->vertex_a = last.a;
    cache->vertex_b = last.b;
    int kept = 0;
    const auto keep = [&](int i) HWY_ATTR {
      const VertexIndices vertices = cores.verticesOf(found.indices[i]);
      cache->simplex_a[kept] = vertices.a;
      cache->simplex_b[kept] = vertices.b;
      kept += static_cast<int>(found.weight[i] > 0);
    };
    keep(0);
    keep(1);
    keep(2);
    cache->simplex_count = kept;
  }
  return true;
}

// Searches; false if the request is not met.
template <class Cores>
HWY_INLINE bool answer(const Pair& pair, const Cores& cores, double more_rounding,
                       const PairCache* carried, DistanceResult& result, VertexStart& start) {
  const double upper_offset = -pair.rounding;
  const double lower_offset = pair.rounding + more_rounding;
  Search<Cores> search(cores, pair.request, lower_offset, upper_offset, 0);
  const Triple first = carried != nullptr ? Triple{1, 0, 0} : firstDirection(pair);
  const GjkEnd end = search.run(first, carried, pair.hints);
  Carriers found;
  search.carriers(end, found);
  if (HWY_LIKELY(answered(pair, cores, search, found, lower_offset, upper_offset, result))) {
    return true;
  }
  found.dropWeightless();
  start.count = end == GjkEnd::kLimit ? 0 : found.count;
  for (int i = 0; i < start.count; ++i) {
    const VertexIndices vertices = cores.verticesOf(found.indices[i]);
    start.vertex_a[i] = vertices.a;
    start.vertex_b[i] = vertices.b;
  }
  start.end = end;
  start.iterations = search.iterations();
  return false;
}

// This function and those below are not merged, because merged they spill registers.
HWY_NOINLINE bool answerInWorld(const Pair& pair, const PairCache* carried, DistanceResult& result,
                                VertexStart& start) {
  const WorldCores cores = {{pair.a, pair.X_WA.rotation, pair.t},
                            {pair.b, pair.X_WB.rotation, {0, 0, 0}}};
  return answer(pair, cores, 0, carried, result, start);
}
template <int kEights>
HWY_NOINLINE bool answerPlaced(const Pair& pair, DistanceResult& result, VertexStart& start) {
  const PlacedCores<kEights> cores = {
      *pair.a.hull(),
      *pair.b.hull(),
      {*pair.a.hull(), pair.X_WA.rotation, pair.t, -1},
      {*pair.b.hull(), pair.X_WB.rotation, {0, 0, 0}, 1},
      PlacedCores<kEights>::kReach * (pair.a.boundingRadius() + pair.b.boundingRadius())};
  return answer(pair, cores, PlacedVertices<kEights>::kIndexRounding * kUnitRoundoff * pair.size,
                nullptr, result, start);
}

// True for hulls with a table or columns: other supports take general code.
HWY_INLINE bool isQuick(const HullSupport& support) {
  return support.length() > 0 || support.sides() > 0;
}

}  // namespace

bool hullSteps(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
               const DistanceRequest& request, PairCache* cache, DistanceResult& result,
               VertexStart& start) {
  const HullSupport &support_a = a.hull()->support(), &support_b = b.hull()->support();
  if (!(isQuick(support_a) && isQuick(support_b))) return false;
  bool carried = false;
  VertexIndices hints = {0, 0};
  if (cache != nullptr) {
    const int count_a = static_cast<int>(a.hull()->vertices().size());
    const int count_b = static_cast<int>(b.hull()->vertices().size());
    carried = std::isnan(request.threshold) && fits(*cache, count_a, count_b);
    if (cache->vertex_a > 0 && cache->vertex_a < count_a) hints.a = cache->vertex_a;
    if (cache->vertex_b > 0 && cache->vertex_b < count_b) hints.b = cache->vertex_b;
  }
  const bool place = !carried && std::isnan(request.threshold);
  if (place && !(PlacedVertices<4>::takes(support_a) && PlacedVertices<4>::takes(support_b)))
    return false;
  const PoseCheck check = checkRotations(X_WA.rotation, X_WB.rotation);
  const Triple t = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  const double size = a.extent() + b.extent() + std::sqrt(squared(t)) + kLeastSum;
  // A NaN fails this comparison.
  if (!(check.rotations && size <= kFarthest) || request.iteration_limit <= 0) return false;
  const double rounding =
      (kSupportRounding + kPoseRounding) * kUnitRoundoff * size + check.departure * size;
  const Pair pair = {a,
                     b,
                     X_WA,
                     X_WB,
                     request,
                     cache,
                     t,
                     size,
                     rounding,
                     hints,
                     support_a.halfLength() + support_b.halfLength() > 0};
  if (!place) return answerInWorld(pair, carried ? cache : nullptr, result, start);
  switch ((std::max(support_a.length(), support_b.length()) + 7) / 8) {
    case 1:
      return answerPlaced<1>(pair, result, start);
    case 2:
      return answerPlaced<2>(pair, result, start);
    default:
      return answerPlaced<4>(pair, result, start);
  }
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(hullSteps);

bool answerHullPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceRequest& request, PairCache* cache, DistanceResult& result,
                    VertexStart& start) {
  return LEEWAY_DISPATCH(hullSteps)(a, X_WA, b, X_WB, request, cache, result, start);
}

}  // namespace leeway::collision
#endif
