#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "collision/base/fetch_code.h"
#include "collision/base/round_box.h"
#include "collision/base/tolerances.h"
#include "collision/deform/query/nearest_triangle.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform/query/nearest_triangle_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "collision/deform/tree/node_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

// Eight floats, or a part of them.
const hn::CappedTag<float, kWidth> kLanes;
using Floats = hn::Vec<decltype(kLanes)>;
constexpr std::size_t kStep = hn::MaxLanes(decltype(kLanes)());
constexpr unsigned kStepBits = (1U << kStep) - 1;

// As many triangles, in double.
const hn::CappedTag<double, kWidth> kMany;
using Many = hn::Vec<decltype(kMany)>;
constexpr std::size_t kManyLanes = hn::MaxLanes(decltype(kMany)());

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
// Nodes that are looked at together, so that nobody waits for what one comes to before the next is
// begun.
constexpr std::size_t kTogether = 8;

template <class M>
HWY_INLINE unsigned bitsOf(M mask) {
  std::uint8_t bits[8] = {};  // as many as StoreMaskBits() may write
  hn::StoreMaskBits(kLanes, mask, bits);
  return bits[0] & kStepBits;
}

// Of a segment, or a point.
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
    open_[size_++] = {0, 0};
    bool within = true;
    while (size_ > 0 && !over_ && within) {
      // Before there is an upper end one at a time, since the nearest leads to it.
      const std::size_t most = found_.slot >= 0 ? kTogether : 1;
      std::array<std::int32_t, kTogether> taken;
      std::size_t count = 0;
      while (size_ > 0 && count < most) {
        const Open next = open_[size_ - 1];
        if (next.squared > bar_squared_) {
          closed_ = std::min(closed_, next.squared);
          --size_;
          continue;
        }
        const bool leaf = DeformTree::isLeaf(next.ref);
        if (leaf && count > 0) break;
        within = found_.visited < search_.limit;
        if (!within) break;
        ++found_.visited;
        --size_;
        if (!leaf) {
          taken[count++] = next.ref;
          continue;
        }
        // Most leaves that come here share the nearest vertex or edge. The plane across the
        // shortest way so far would close them, and 3 to 8 % of the time with them; but which of
        // the triangles there is told, and its last digits, would hang on what this thread has
        // asked before.
        const DeformTree::Leaf& l = tree_.leaf(DeformTree::leafOf(next.ref));
        trianglesFor(*this, l.slot_begin, l.slot_end);
        break;
      }
      if (count > 0) nodes(taken.data(), count);
    }
    // What the limit has left.
    while (size_ > 0) closed_ = std::min(closed_, open_[--size_].squared);
    found_.lower = over_ ? 0 : std::min(settled_, distanceOf(closed_));
    return found_;
  }

  // Triangles of these slots, at most eight. (One function, whose code has a place of its own.)
  HWY_NOINLINE static void trianglesFor(NearestDescent& descent, std::int32_t begin,
                                        std::int32_t end) {
    descent.triangles(begin, end);
  }

 private:
  struct Open {
    float squared;     // of a distance that is proven for everything below
    std::int32_t ref;  // as in DeformTree::Node
  };

  // What is above needs no closer look.
  void setBar(double bar) {
    bar_ = bar;
    // Rounded up; below the least square nothing is closed, above the largest nothing that is not
    // so far.
    const float up =
        roundedUpToFloat((std::max(bar, 0.0) + search_.slack) * (1 + kNearestBoxRounding));
    bar_squared_ = std::clamp(up * up * static_cast<float>(1 + kNearestBoxRounding),
                              kLeastWaySquared, 0.5F * kLargest);
  }
  // (Squares of the smallest numbers round by more.)
  double distanceOf(float squared) const {
    if (!(squared >= kLeastWaySquared)) return -search_.slack;
    return std::sqrt(static_cast<double>(squared)) * (1 - kNearestBoxRounding) - search_.slack;
  }
  void settle(double lower) { settled_ = std::min(settled_, lower); }

  // Boxes of several nodes; those of their children that need a closer look, the first node's last,
  // and of each the nearest last.
  void nodes(const std::int32_t* ids, std::size_t count) {
    std::array<WideBox, kTogether> room;
    std::array<const WideBox*, kTogether> boxes;
    HWY_ALIGN float squared[kTogether][kWidth];
    std::array<unsigned, kTogether> left;
    for (std::size_t i = 0; i < count; ++i) boxes[i] = &source_.boxes(ids[i], room[i]);
    for (std::size_t i = 0; i < count; ++i) left[i] = squares(*boxes[i], squared[i]);
    for (std::size_t i = 0; i < count; ++i) close(ids[i], *boxes[i], squared[i], left[i]);
    for (std::size_t i = count; i-- > 0;) push(ids[i], squared[i], left[i]);
  }

  // Those that are not above the bar, a bit each.
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
      // Empty lanes are infinitely far; what overflows is as far as the largest number at least.
      sum = hn::Min(sum, most);
      hn::Store(sum, kLanes, squared + i);
      const auto beyond = hn::Gt(sum, bar);
      closed = hn::Min(closed, hn::IfThenElse(beyond, sum, closed));
      left |= (~bitsOf(beyond) & kStepBits) << i;
    }
    closed_ = hn::GetLane(hn::MinOfLanes(kLanes, closed));
    return left;
  }

  // The plane across the way from the segment to the middle of each box: a box around a segment is
  // loose. The square of what it proves; 0 for nothing, and for empty lanes.
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
    // Wherever on the segment it starts, a way is one; the reach of the segment along it counts.
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
    // (What is no number, as in empty lanes, is not greater.)
    const auto known = hn::And(usable, hn::Gt(lower, zero));
    return hn::IfThenElse(known, hn::Mul(lower, lower), zero);
  }

  // Takes off children that their vertices show to be above the bar.
  HWY_INLINE void close(std::int32_t id, const WideBox& box, float* squared, unsigned& left) {
    const DeformTree::Node& node = tree_.node(id);
    const DeformTree::Refit& refit = tree_.refits()[static_cast<std::size_t>(id) + 1];
    const std::int32_t* const vertices = tree_.refitVertices().data() + refit.vertices;
    const std::uint8_t* const corners = tree_.refitCorners().data() + refit.corners;
    for (unsigned open = left; open != 0; open &= open - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(open));
      const std::int32_t child = node.child[lane];
      float& near = squared[lane];
      if (DeformTree::isLeaf(child)) {
        if (isBeyondLeaf(box, lane, vertices, corners, near))
          left &= ~(1U << lane);
        else
          __builtin_prefetch(&tree_.leaf(DeformTree::leafOf(child)));
      } else {
        source_.fetch(child);
        if (!source_.isThere(child) && isBeyondLeaves(box, lane, child, near))
          left &= ~(1U << lane);
      }
    }
  }

  HWY_INLINE void push(std::int32_t id, const float* squared, unsigned left) {
    const DeformTree::Node& node = tree_.node(id);
    const std::size_t first = size_;
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      const std::int32_t child = node.child[lane];
      if (DeformTree::isLeaf(child)) {
        const DeformTree::Leaf& leaf = tree_.leaf(DeformTree::leafOf(child));
        __builtin_prefetch(&tree_.corners(leaf.slot_begin));
        __builtin_prefetch(&tree_.corners(leaf.slot_end - 1));
      }
      const float near = squared[lane];
      std::size_t place = size_++;
      for (; place > first && open_[place - 1].squared < near; --place)
        open_[place] = open_[place - 1];
      open_[place] = {near, child};
    }
  }

  // From the core to the middle of a box.
  struct Way {
    double n[3];
    double length;
  };
  HWY_INLINE bool wayTo(const WideBox& box, std::size_t lane, Way& way) const {
    for (int k = 0; k < 3; ++k)
      way.n[k] = static_cast<double>(0.5F * (box.low[k][lane] + box.high[k][lane])) - p_[k];
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

  // Whether vertices, and what they span, are above the bar; they are settled then. Else `near` may
  // grow.
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

  // A leaf, of a node with these vertices.
  HWY_INLINE bool isBeyondLeaf(const WideBox& box, std::size_t lane, const std::int32_t* vertices,
                               const std::uint8_t* corners, float& near) {
    Way way;
    if (!wayTo(box, lane, way)) return false;
    const std::size_t count = *corners;
    const std::uint8_t* const place = corners + 1 + lane * count;
    LeastAlong along(way.n);
    along.add(vertices_, count, [vertices, place](std::size_t i) { return vertices[place[i]]; });
    return isBeyond(along, way, near);
  }

  // A node that has nothing but leaves.
  HWY_INLINE bool isBeyondLeaves(const WideBox& box, std::size_t lane, std::int32_t child,
                                 float& near) {
    for (const std::int32_t below : tree_.node(child).child)
      if (below >= 0) return false;
    Way way;
    if (!wayTo(box, lane, way)) return false;
    const DeformTree::Refit &begin = tree_.refits()[static_cast<std::size_t>(child) + 1],
                            &end = tree_.refits()[static_cast<std::size_t>(child)];
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

  // Of triangles, one a lane.
  struct Ends {
    HWY_ALIGN double lower[kWidth], upper[kWidth];
    HWY_ALIGN double from[3][kWidth], way[3][kWidth];  // as in NearestFound
  };
  struct Triple {
    Many x[3];
  };
  // Two points, of core and triangle, and the way between them.
  struct Pair {
    Triple from, way;
    Many squared;
  };

  // Both ends of the distances of as many triangles as a vector has lanes; lanes that are left over
  // hold the last one again. What is not finite comes to 0 and NaN.
  HWY_INLINE void ends(std::int32_t begin, std::int32_t end, std::size_t i, Ends& of) const {
    const double* from[3][kManyLanes];
    for (std::size_t lane = 0; lane < kManyLanes; ++lane) {
      const DeformTree::Triangle& t =
          tree_.corners(std::min(begin + static_cast<std::int32_t>(lane), end - 1));
      for (std::size_t c = 0; c < 3; ++c) from[c][lane] = at(vertices_, t[c]);
    }
    // Seen from the middle of the core.
    const Triple a = cornersAt(from[0]), b = cornersAt(from[1]), c = cornersAt(from[2]);
    const Triple half = setTriple(h_);
    Pair best;
    if constexpr (kSegment) {
      best = nearestTo(half, a, b, c);
      offer(nearestTo(negative(half), a, b, c), best);
      offer(nearestOnEdge(half, a, b), best);
      offer(nearestOnEdge(half, b, c), best);
      offer(nearestOnEdge(half, c, a), best);
    } else {
      best = nearestTo(half, a, b, c);
    }
    const Many zero = hn::Zero(kMany);
    for (int k = 0; k < 3; ++k) {
      hn::Store(best.from.x[k], kMany, of.from[k] + i);
      hn::Store(best.way.x[k], kMany, of.way[k] + i);
    }
    const Many length = hn::Sqrt(best.squared);
    Many least = hn::Min(hn::Min(dot(best.way, a), dot(best.way, b)), dot(best.way, c));
    // It grows with where the corners are, seen from the core, and with nothing else: not with what
    // holds the mesh, which depends on who updates it.
    Many size = hn::Max(hn::Max(sizeOf(a), sizeOf(b)), sizeOf(c));
    if constexpr (kSegment) {
      least = hn::Sub(least, hn::Abs(dot(best.way, half)));
      size = hn::Add(size, sizeOf(half));
    }
    const Many rounding = hn::Add(hn::Mul(size, hn::Set(kMany, kNearestTriangleRounding)),
                                  hn::Set(kMany, search_.slack));
    // Written so that a way without direction, and what is no number, prove nothing.
    const Many beyond = hn::Sub(hn::Div(least, length), rounding);
    const auto known =
        hn::And(hn::Gt(beyond, zero),
                hn::Gt(best.squared, hn::Set(kMany, static_cast<double>(kLeastWaySquared))));
    hn::Store(hn::IfThenElse(known, beyond, zero), kMany, of.lower + i);
    hn::Store(hn::Add(length, rounding), kMany, of.upper + i);
  }

  // A point, the same for all, and the triangles.
  static HWY_INLINE Pair nearestTo(const Triple& p, const Triple& from_a, const Triple& from_b,
                                   const Triple& from_c) {
    const Triple a = kSegment ? difference(from_a, p) : from_a,
                 b = kSegment ? difference(from_b, p) : from_b,
                 c = kSegment ? difference(from_c, p) : from_c;
    const Triple ab = difference(b, a), ac = difference(c, a);
    const Many zero = hn::Zero(kMany), one = hn::Set(kMany, 1.0);
    const Many d1 = hn::Neg(dot(ab, a)), d2 = hn::Neg(dot(ac, a)), d3 = hn::Neg(dot(ab, b)),
               d4 = hn::Neg(dot(ac, b)), d5 = hn::Neg(dot(ab, c)), d6 = hn::Neg(dot(ac, c));
    const Many va = hn::Sub(hn::Mul(d3, d6), hn::Mul(d5, d4)),
               vb = hn::Sub(hn::Mul(d5, d2), hn::Mul(d1, d6)),
               vc = hn::Sub(hn::Mul(d1, d4), hn::Mul(d3, d2));
    const Many along_bc = hn::Sub(d4, d3), back_bc = hn::Sub(d5, d6);
    const auto at_a = hn::And(hn::Le(d1, zero), hn::Le(d2, zero)),
               at_b = hn::And(hn::Ge(d3, zero), hn::Le(d4, d3)),
               at_c = hn::And(hn::Ge(d6, zero), hn::Le(d5, d6));
    const auto on_ab = hn::And(hn::Le(vc, zero), hn::And(hn::Ge(d1, zero), hn::Le(d3, zero))),
               on_ac = hn::And(hn::Le(vb, zero), hn::And(hn::Ge(d2, zero), hn::Le(d6, zero))),
               on_bc = hn::And(hn::Le(va, zero),
                               hn::And(hn::Ge(along_bc, zero), hn::Ge(back_bc, zero)));
    // Weights of b and c times `all`; the first of Ericson's cases is the last to be put in.
    Many v = vb, w = vc, all = hn::Add(hn::Add(va, vb), vc);
    const auto put = [&](auto mask, Many weight_b, Many weight_c, Many sum) HWY_ATTR {
      v = hn::IfThenElse(mask, weight_b, v);
      w = hn::IfThenElse(mask, weight_c, w);
      all = hn::IfThenElse(mask, sum, all);
    };
    put(on_bc, back_bc, along_bc, hn::Add(along_bc, back_bc));
    put(on_ac, zero, d2, hn::Sub(d2, d6));
    put(at_c, zero, one, one);
    put(on_ab, d1, zero, hn::Sub(d1, d3));
    put(at_b, one, zero, one);
    put(at_a, zero, zero, one);
    // Some convex combination, whatever rounding did and where there is no plane.
    const Many safe = hn::IfThenElse(hn::Gt(all, zero), all, one);
    v = clampTo(hn::Div(v, safe), one);
    w = clampTo(hn::Div(w, safe), hn::Sub(one, v));
    Pair pair;
    pair.from = p;
    for (int k = 0; k < 3; ++k)
      pair.way.x[k] = hn::Add(a.x[k], hn::Add(hn::Mul(v, ab.x[k]), hn::Mul(w, ac.x[k])));
    pair.squared = dot(pair.way, pair.way);
    return pair;
  }

  // The segment from -half to half and the edges from a to b: the points of the two lines that are
  // nearest, the edge's brought into it, and the segment's that is nearest to that.
  static HWY_INLINE Pair nearestOnEdge(const Triple& half, const Triple& a, const Triple& b) {
    const Many zero = hn::Zero(kMany), one = hn::Set(kMany, 1.0);
    const Triple edge = difference(b, a);
    const Many hh = dot(half, half), he = dot(half, edge), ee = dot(edge, edge), ha = dot(half, a),
               ea = dot(edge, a);
    const auto positive = [&](Many x) HWY_ATTR { return hn::IfThenElse(hn::Gt(x, zero), x, one); };
    const auto along = [&](Many t) HWY_ATTR {
      const Many s = hn::Div(hn::Add(ha, hn::Mul(t, he)), positive(hh));
      return hn::Max(hn::Min(s, one), hn::Neg(one));
    };
    // Of lines: s hh - t he = ha, s he - t ee = ea.
    const Many across = hn::Sub(hn::Mul(hh, ee), hn::Mul(he, he));
    const Many s_lines =
        hn::Max(hn::Min(hn::Div(hn::Sub(hn::Mul(ha, ee), hn::Mul(ea, he)), positive(across)), one),
                hn::Neg(one));
    const Many t = clampTo(hn::Div(hn::Sub(hn::Mul(s_lines, he), ea), positive(ee)), one);
    const Many s = along(t);
    Pair pair;
    for (int k = 0; k < 3; ++k) {
      pair.from.x[k] = hn::Mul(s, half.x[k]);
      pair.way.x[k] = hn::Sub(hn::Add(a.x[k], hn::Mul(t, edge.x[k])), pair.from.x[k]);
    }
    pair.squared = dot(pair.way, pair.way);
    return pair;
  }

  static HWY_INLINE void offer(const Pair& pair, Pair& best) {
    const auto nearer = hn::Lt(pair.squared, best.squared);
    best.squared = hn::IfThenElse(nearer, pair.squared, best.squared);
    for (int k = 0; k < 3; ++k) {
      best.from.x[k] = hn::IfThenElse(nearer, pair.from.x[k], best.from.x[k]);
      best.way.x[k] = hn::IfThenElse(nearer, pair.way.x[k], best.way.x[k]);
    }
  }

  // From 0 to `most`.
  static HWY_INLINE Many clampTo(Many x, Many most) {
    return hn::Min(hn::Max(x, hn::Zero(kMany)), most);
  }
  HWY_INLINE Triple cornersAt(const double* const* from) const {
    Triple t;
    loadMany(kMany, from, t.x);
    for (int k = 0; k < 3; ++k) t.x[k] = hn::Sub(t.x[k], hn::Set(kMany, p_[k]));
    return t;
  }
  static HWY_INLINE Triple setTriple(const double* x) {
    Triple t;
    for (int k = 0; k < 3; ++k) t.x[k] = hn::Set(kMany, x[k]);
    return t;
  }
  static HWY_INLINE Triple negative(const Triple& a) {
    Triple t;
    for (int k = 0; k < 3; ++k) t.x[k] = hn::Neg(a.x[k]);
    return t;
  }
  static HWY_INLINE Triple difference(const Triple& a, const Triple& b) {
    Triple t;
    for (int k = 0; k < 3; ++k) t.x[k] = hn::Sub(a.x[k], b.x[k]);
    return t;
  }
  static HWY_INLINE Many sizeOf(const Triple& a) {
    return hn::Add(hn::Add(hn::Abs(a.x[0]), hn::Abs(a.x[1])), hn::Abs(a.x[2]));
  }
  static HWY_INLINE Many dot(const Triple& a, const Triple& b) {
    return hn::Add(hn::Add(hn::Mul(a.x[0], b.x[0]), hn::Mul(a.x[1], b.x[1])),
                   hn::Mul(a.x[2], b.x[2]));
  }

  const NearestSearch& search_;
  const DeformTree& tree_;
  const Eigen::Vector3d* vertices_;
  const BoxSource& source_;
  double p_[3], h_[3];  // the core's middle, and from there to an end
  double half_squared_ = 0;
  double rounding_ = 0;     // of vertices' distances along any way, the core's error included
  float low_[3], high_[3];  // a box around the core, in single precision
  double bar_ = kInfinity;
  float bar_squared_ = kLargest;
  float closed_ = kLargest;  // the least square of what is closed by its box
  double settled_ =
      kInfinity;  // no other triangle that was looked at, or closed otherwise, is nearer
  NearestFound found_;
  bool over_ = false;
  // What is taken together stands on top, deeper nodes above others: no level of the hierarchy has
  // more than the children of one taking there.
  std::array<Open, (DeformTree::kMaxDepth + 1) * kWidth * kTogether> open_;
  std::size_t size_ = 0;
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

// About as many bytes as compilers make of it.
void fetchFinder() {
  fetchCode(findFor<false>, 6144);
  fetchCode(NearestDescent<false>::trianglesFor, 2816);
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
