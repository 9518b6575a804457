#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>

#include "collision/base/prefetch.h"
#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/query/nearest_triangle.h"
#include "collision/mesh/descent/branch_and_bound.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform/query/nearest_triangle_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "collision/deform/query/nearest_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
// Number of nodes that are opened together, so that their cache misses overlap.
constexpr std::size_t kTogether = 8;

// The search, from a segment or a point.
template <bool kSegment>
class NearestDescent {
 public:
  NearestDescent(const NearestSearch& search, const DeformableSnapshotImpl& snapshot,
                 const BoxSource& source)
      : search_(search),
        tree_(*snapshot.tree),
        vertices_(snapshot.vertices.data()),
        source_(source) {
    for (int k = 0; k < 3; ++k) {
      p_[k] = search.middle[k];
      h_[k] = kSegment ? search.half[k] : 0;
      low_[k] = roundedDown(p_[k] - std::abs(h_[k]));
      high_[k] = roundedUpToFloat(p_[k] + std::abs(h_[k]));
    }
    half_squared_ = search.half.squaredNorm();
    rounding_ = search.slack + kRelativeRounding * search.size;
    setBar(search.reach);
  }

  NearestFound run() {
    if (search_.first >= 0) trianglesFor(*this, search_.first, search_.first + 1);
    open_.push({0, 0});
    std::array<Open, kTogether> room;
    for (std::span<const Open> taken; open_.next(*this, room, taken);) {
      if (!taken.front().isLeaf()) {
        nodes(taken);
        continue;
      }
      // Most leaves here share the nearest vertex or edge. The plane perpendicular to the shortest
      // displacement so far would close them and save 3 to 8 % of the time. But then the reported
      // triangle and the last digits would depend on earlier queries of this thread.
      const DeformTree::Leaf& l = tree_.leaf(DeformTree::leafOf(taken.front().ref));
      trianglesFor(*this, l.slot_begin, l.slot_end);
    }
    // Nodes that the limit left open.
    open_.settleRest(*this);
    found_.lower = over_ ? 0 : std::min(settled_, distanceOf(closed_));
    return found_;
  }

  struct Open {
    float lower;       // for everything below, squared
    std::int32_t ref;  // as in DeformTree::Node

    bool isLeaf() const { return DeformTree::isLeaf(ref); }
  };

  // As BranchAndBound requires.
  bool isPruned(const Open& open) const { return open.lower > bar_squared_; }
  void settle(const Open& open) { closed_ = std::min(closed_, open.lower); }
  bool isDone() const { return over_; }
  bool isSpent() const { return found_.visited >= search_.limit; }
  void visit() { ++found_.visited; }
  bool hasUpper() const { return found_.slot >= 0; }

  // Compares the triangles in these slots, at most eight. A separate function, so that
  // fetchFinder() can prefetch it.
  HWY_NOINLINE static void trianglesFor(NearestDescent& descent, std::int32_t begin,
                                        std::int32_t end) {
    descent.triangles(begin, end);
  }

 private:
  // Sets the bar: bounds above it need no further comparison.
  void setBar(double bar) {
    bar_ = bar;
    // Rounded up, and kept within the range in which squares keep their digits.
    const float up =
        roundedUpToFloat((std::max(bar, 0.0) + search_.slack) * (1 + kNearestBoxRounding));
    bar_squared_ = std::clamp(up * up * static_cast<float>(1 + kNearestBoxRounding),
                              kLeastWaySquared, 0.5F * kLargest);
  }
  // A lower bound; squares near the subnormal numbers have lost their digits.
  double distanceOf(float squared) const {
    if (!(squared >= kLeastWaySquared)) return -search_.slack;
    return std::sqrt(static_cast<double>(squared)) * (1 - kNearestBoxRounding) - search_.slack;
  }
  void settle(double lower) { settled_ = std::min(settled_, lower); }

  // Opens several nodes: pushes the children that need a closer look onto the stack, those of the
  // first node last, and for each node the nearest last.
  void nodes(std::span<const Open> taken) {
    std::array<WideBox, kTogether> room;
    std::array<const WideBox*, kTogether> boxes;
    HWY_ALIGN float squared[kTogether][kWidth];
    std::array<unsigned, kTogether> left;
    const std::size_t count = taken.size();
    for (std::size_t i = 0; i < count; ++i) boxes[i] = &source_.boxes(taken[i].ref, room[i]);
    for (std::size_t i = 0; i < count; ++i) left[i] = squares(*boxes[i], squared[i]);
    for (std::size_t i = 0; i < count; ++i) close(taken[i].ref, *boxes[i], squared[i], left[i]);
    for (std::size_t i = count; i-- > 0;) push(taken[i].ref, squared[i], left[i]);
  }

  // Squared distances of the core and the boxes. Sets a bit for each column that is not above the
  // bar.
  HWY_INLINE unsigned squares(const WideBox& box, float* squared) {
    const Floats zero = hn::Zero(kLanes), most = hn::Set(kLanes, kLargest),
                 bar = hn::Set(kLanes, bar_squared_);
    Floats closed = hn::Set(kLanes, closed_);
    unsigned left = 0;
    for (std::size_t i = 0; i < kWidth; i += kStep) {
      Floats sum = zero;
      for (int k = 0; k < 3; ++k) {
        const Floats below = hn::Sub(hn::Load(kLanes, box.low[k] + i), hn::Set(kLanes, high_[k])),
                     above = hn::Sub(hn::Set(kLanes, low_[k]), hn::Load(kLanes, box.high[k] + i));
        const Floats gap = hn::Max(hn::Max(below, above), zero);
        sum = hn::Add(sum, hn::Mul(gap, gap));
      }
      if constexpr (kSegment) sum = hn::Max(sum, acrossWay(box, i));
      // Empty columns are infinitely far; an overflow is at least the largest float.
      sum = hn::Min(sum, most);
      hn::Store(sum, kLanes, squared + i);
      const auto beyond = hn::Gt(sum, bar);
      closed = hn::Min(closed, hn::IfThenElse(beyond, sum, closed));
      left |= (~bitsOf(beyond) & kStepBits) << i;
    }
    closed_ = hn::GetLane(hn::MinOfLanes(kLanes, closed));
    return left;
  }

  // A box around a segment is loose. A plane perpendicular to the line from the segment to the
  // middle of each box gives another bound. Returns its square; 0 if it proves nothing and for
  // empty columns.
  HWY_INLINE Floats acrossWay(const WideBox& box, std::size_t i) const {
    const Floats zero = hn::Zero(kLanes), half = hn::Set(kLanes, 0.5F);
    const auto set = [](double x) HWY_ATTR { return hn::Set(kLanes, static_cast<float>(x)); };
    Floats w[3], side[3], along = zero;
    for (int k = 0; k < 3; ++k) {
      const Floats low = hn::Load(kLanes, box.low[k] + i), high = hn::Load(kLanes, box.high[k] + i);
      w[k] = hn::Sub(hn::Mul(hn::Add(low, high), half), set(p_[k]));
      side[k] = hn::Mul(hn::Sub(high, low), half);
      along = hn::Add(along, hn::Mul(w[k], set(h_[k])));
    }
    // Any start on the segment is correct, because only the segment's reach along the way matters.
    const Floats s = hn::Max(hn::Min(hn::Mul(along, set(1 / half_squared_)), hn::Set(kLanes, 1.0F)),
                             hn::Set(kLanes, -1.0F));
    Floats squared = zero, middle = zero, reach = zero, own = zero;
    for (int k = 0; k < 3; ++k) {
      const Floats way = hn::Sub(w[k], hn::Mul(s, set(h_[k])));
      squared = hn::Add(squared, hn::Mul(way, way));
      middle = hn::Add(middle, hn::Mul(way, w[k]));
      reach = hn::Add(reach, hn::Mul(hn::Abs(way), side[k]));
      own = hn::Add(own, hn::Mul(way, set(h_[k])));
    }
    const Floats proven = hn::Sub(hn::Sub(middle, reach), hn::Abs(own));
    const auto usable = hn::And(hn::Gt(squared, hn::Set(kLanes, kLeastWaySquared)),
                                hn::Lt(squared, hn::Set(kLanes, kLargest)));
    const Floats length = hn::Sqrt(hn::IfThenElse(usable, squared, hn::Set(kLanes, 1.0F)));
    const Floats lower = hn::Sub(hn::Div(proven, length), set(kSingleRounding * search_.size));
    // A NaN, as in empty columns, compares as not greater.
    const auto known = hn::And(usable, hn::Gt(lower, zero));
    return hn::IfThenElse(known, hn::Mul(lower, lower), zero);
  }

  // Closes children whose vertices prove that they are above the bar.
  HWY_INLINE void close(std::int32_t id, const WideBox& box, float* squared, unsigned& left) {
    const DeformTree::Node& node = tree_.node(id);
    const DeformTree::RefitOffsets& refit = tree_.refitOffsets()[static_cast<std::size_t>(id) + 1];
    const std::int32_t* const vertices = tree_.refitVertices().data() + refit.vertices;
    const std::uint8_t* const corners = tree_.refitCorners().data() + refit.corners;
    for (unsigned open = left; open != 0; open &= open - 1) {
      const auto column = static_cast<std::size_t>(std::countr_zero(open));
      const std::int32_t child = node.child[column];
      float& near = squared[column];
      if (DeformTree::isLeaf(child)) {
        if (isBeyondLeaf(box, column, vertices, corners, near))
          left &= ~(1U << column);
        else
          __builtin_prefetch(&tree_.leaf(DeformTree::leafOf(child)));
      } else {
        source_.fetch(child);
        if (!source_.isThere(child) && isBeyondLeaves(box, column, child, near))
          left &= ~(1U << column);
      }
    }
  }

  HWY_INLINE void push(std::int32_t id, const float* squared, unsigned left) {
    const DeformTree::Node& node = tree_.node(id);
    const std::size_t first = open_.size();
    for (; left != 0; left &= left - 1) {
      const auto column = static_cast<std::size_t>(std::countr_zero(left));
      const std::int32_t child = node.child[column];
      if (DeformTree::isLeaf(child)) {
        const DeformTree::Leaf& leaf = tree_.leaf(DeformTree::leafOf(child));
        __builtin_prefetch(&tree_.corners(leaf.slot_begin));
        __builtin_prefetch(&tree_.corners(leaf.slot_end - 1));
      }
      open_.pushSibling(first, {squared[column], child});
    }
  }

  // The vector from the core to the middle of a box.
  struct Way {
    double n[3];
    double length;
  };
  HWY_INLINE bool wayTo(const WideBox& box, std::size_t column, Way& way) const {
    for (int k = 0; k < 3; ++k)
      way.n[k] = static_cast<double>(0.5F * (box.low[k][column] + box.high[k][column])) - p_[k];
    if (kSegment && half_squared_ > 0) {
      const double s = std::clamp(dotOf(way.n, h_) / half_squared_, -1.0, 1.0);
      for (int k = 0; k < 3; ++k) way.n[k] -= s * h_[k];
    }
    const double sum = dotOf(way.n, way.n);
    way.length = std::sqrt(sum);
    return sum > static_cast<double>(kLeastWaySquared) && sum < kInfinity;
  }
  static double dotOf(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }

  // Whether vertices, and all points that they span, are above the bar; they are settled in that
  // case. Otherwise raises `near`, a squared lower bound.
  HWY_INLINE bool isBeyond(const LeastAlong& along, const Way& way, float& near) {
    if (!along.isFinite()) return false;
    const double own = dotOf(way.n, p_) + (kSegment ? std::abs(dotOf(way.n, h_)) : 0);
    const double lower = (along.least() - own) / way.length - rounding_;
    if (lower > bar_) {
      settle(lower);
      return true;
    }
    if (lower > 0) {
      const float down = roundedDown(lower * (1 - kNearestBoxRounding));
      near = std::max(near, down * down);
    }
    return false;
  }

  // isBeyond() for a leaf; vertices and corners are those of its node.
  HWY_INLINE bool isBeyondLeaf(const WideBox& box, std::size_t column, const std::int32_t* vertices,
                               const std::uint8_t* corners, float& near) {
    Way way;
    if (!wayTo(box, column, way)) return false;
    const std::size_t count = *corners;
    const std::uint8_t* const place = corners + 1 + column * count;
    LeastAlong along(way.n);
    along.add(vertices_, count, [vertices, place](std::size_t i) { return vertices[place[i]]; });
    return isBeyond(along, way, near);
  }

  // isBeyond() for a node that has only leaves; false for other nodes.
  HWY_INLINE bool isBeyondLeaves(const WideBox& box, std::size_t column, std::int32_t child,
                                 float& near) {
    for (const std::int32_t below : tree_.node(child).child)
      if (below >= 0) return false;
    Way way;
    if (!wayTo(box, column, way)) return false;
    const DeformTree::RefitOffsets &begin =
                                       tree_.refitOffsets()[static_cast<std::size_t>(child) + 1],
                                   &end = tree_.refitOffsets()[static_cast<std::size_t>(child)];
    LeastAlong along(way.n);
    along.add(vertices_, tree_.refitVertices().data() + begin.vertices,
              static_cast<std::size_t>(end.vertices - begin.vertices));
    return isBeyond(along, way, near);
  }

  HWY_INLINE void triangles(std::int32_t begin, std::int32_t end) {
    Ends of;
    const auto count = static_cast<std::size_t>(end - begin);
    for (std::size_t i = 0; i < count; i += kManyLanes)
      ends(begin + static_cast<std::int32_t>(i), end, i, of);
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t slot = begin + static_cast<std::int32_t>(i);
      if (slot == found_.slot) continue;
      if (!(of.upper[i] < found_.upper)) {
        settle(of.lower[i]);
        continue;
      }
      if (found_.slot >= 0) settle(found_.own_lower);
      found_.slot = slot;
      found_.upper = of.upper[i];
      found_.own_lower = of.lower[i];
      found_.from = {of.from[0][i], of.from[1][i], of.from[2][i]};
      found_.way = {of.way[0][i], of.way[1][i], of.way[2][i]};
    }
    if (found_.slot < 0) return;
    setBar(std::min(search_.reach, found_.upper - search_.tolerance));
    over_ = found_.upper <= search_.enough;
  }

  // For triangles: lower and upper bound of the distance, and the other data as in NearestFound.
  struct Ends {
    HWY_ALIGN double lower[kWidth], upper[kWidth];
    HWY_ALIGN double from[3][kWidth], way[3][kWidth];
  };
  // Bounds of the distances of one triangle in each vector lane; unused lanes repeat the last
  // triangle. A triangle that is not finite gets 0 and NaN.
  HWY_INLINE void ends(std::int32_t begin, std::int32_t end, std::size_t i, Ends& of) const {
    const double* from[3][kManyLanes];
    for (std::size_t lane = 0; lane < kManyLanes; ++lane) {
      const DeformTree::Triangle& t =
          tree_.corners(std::min(begin + static_cast<std::int32_t>(lane), end - 1));
      for (std::size_t c = 0; c < 3; ++c) from[c][lane] = at(vertices_, t[c]);
    }
    // Relative to the middle of the core.
    const Triple a = verticesFrom(from[0], p_), b = verticesFrom(from[1], p_),
                 c = verticesFrom(from[2], p_);
    const Triple half = setTriple(h_);
    PointPair best = nearestTo<kSegment>(half, a, b, c);
    if constexpr (kSegment) {
      keepNearer(nearestTo<kSegment>(negative(half), a, b, c), best);
      keepNearer(nearestOnEdge(half, a, b), best);
      keepNearer(nearestOnEdge(half, b, c), best);
      keepNearer(nearestOnEdge(half, c, a), best);
    }
    const Many zero = hn::Zero(kMany);
    for (int k = 0; k < 3; ++k) {
      hn::Store(best.from.x[k], kMany, of.from[k] + i);
      hn::Store(best.way.x[k], kMany, of.way[k] + i);
    }
    const Many length = hn::Sqrt(best.squared);
    Many least = hn::Min(hn::Min(dot(best.way, a), dot(best.way, b)), dot(best.way, c));
    // Rounding is proportional to the corners' coordinates relative to the core. It must not depend
    // on the update strategy, for example on the box of the mesh.
    Many size = hn::Max(hn::Max(sizeOf(a), sizeOf(b)), sizeOf(c));
    if constexpr (kSegment) {
      least = hn::Sub(least, hn::Abs(dot(best.way, half)));
      size = hn::Add(size, sizeOf(half));
    }
    const Many rounding = hn::Add(hn::Mul(size, hn::Set(kMany, kNearestTriangleRounding)),
                                  hn::Set(kMany, search_.slack));
    // A way without direction and a NaN prove nothing here.
    const Many beyond = hn::Sub(hn::Div(least, length), rounding);
    const auto known =
        hn::And(hn::Gt(beyond, zero),
                hn::Gt(best.squared, hn::Set(kMany, static_cast<double>(kLeastWaySquared))));
    hn::Store(hn::IfThenElse(known, beyond, zero), kMany, of.lower + i);
    hn::Store(hn::Add(length, rounding), kMany, of.upper + i);
  }

  const NearestSearch& search_;
  const DeformTree& tree_;
  const Eigen::Vector3d* vertices_;
  const BoxSource& source_;
  double p_[3], h_[3];  // the core's middle, and from there to an end
  double half_squared_ = 0;
  double rounding_ = 0;     // of distances along any way, including the core's own error [m]
  float low_[3], high_[3];  // a box around the core, in single precision
  double bar_ = kInfinity;
  float bar_squared_ = kLargest;
  float closed_ = kLargest;     // least squared lower bound of the subtrees that were closed by
                                // their boxes
  double settled_ = kInfinity;  // least lower bound of the triangles that were compared or closed
                                // otherwise
  NearestFound found_;
  bool over_ = false;
  // The children of nodes that are opened together are pushed on top, above all shallower nodes, so
  // each level of the hierarchy has at most the children of one such batch here.
  BranchAndBound<Open, (DeformTree::kMaxDepth + 1) * kWidth * kTogether> open_;
};

template <bool kSegment>
HWY_NOINLINE NearestFound findFor(const NearestSearch& search,
                                  const DeformableSnapshotImpl& snapshot, const BoxSource& source) {
  return NearestDescent<kSegment>(search, snapshot, source).run();
}

NearestFound find(const NearestSearch& search, const DeformableSnapshotImpl& snapshot,
                  const BoxSource& source) {
  return search.half.isZero(0) ? findFor<false>(search, snapshot, source)
                               : findFor<true>(search, snapshot, source);
}

// Prefetches the code of a search from a point; sizes as compiled by g++ 12 [bytes].
void fetchFinder() {
  prefetchCode(findFor<false>, 6144);
  prefetchCode(NearestDescent<false>::trianglesFor, 2816);
}

}  // namespace

using Find = NearestFound (*)(const NearestSearch&, const DeformableSnapshotImpl&,
                              const BoxSource&);
Find nearestFinder() { return find; }
using Fetch = void (*)();
Fetch finderFetcher() { return fetchFinder; }

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(nearestFinder);
HWY_EXPORT(finderFetcher);

void fetchNearestCode() { HWY_DYNAMIC_DISPATCH(finderFetcher)()(); }

NearestFound findNearest(const NearestSearch& search, const DeformableSnapshotImpl& snapshot,
                         const BoxSource& source) {
  return HWY_DYNAMIC_DISPATCH(nearestFinder)()(search, snapshot, source);
}

}  // namespace leeway::collision
#endif
