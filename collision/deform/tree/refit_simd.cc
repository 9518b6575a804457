#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

#include "collision/base/round_box.h"
#include "collision/base/tolerances.h"
#include "collision/deform/tree/refit.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform/tree/refit_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "collision/deform/tree/node_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kParts = 4 / kDoubleLanes;
// Eight floats, or a part of them.
const hn::CappedTag<float, kWidth> kLanes;
using Floats = hn::Vec<decltype(kLanes)>;
constexpr std::size_t kStep = hn::MaxLanes(decltype(kLanes)());

// Four floats, or a part of them.
const hn::CappedTag<float, 4> kFourFloats;
using FourFloats = hn::Vec<decltype(kFourFloats)>;
constexpr std::size_t kFourLanes = hn::MaxLanes(decltype(kFourFloats)());
constexpr std::size_t kFloatParts = 4 / kFourLanes;

// x - x is 0 for finite x only.
template <class D, class V>
HWY_INLINE bool isFinite(D d, V x) {
  return hn::AllTrue(d, hn::Eq(hn::Sub(x, x), hn::Zero(d)));
}

// The box of vertices, in double. Minimum and maximum are exact, so that the order of vertices and
// the number of lanes do not show.
struct Extremes {
  Doubles low[kParts], high[kParts];
  Doubles sum[kParts];  // not finite when a vertex is not

  // Of nothing.
  HWY_INLINE Extremes() {
    for (std::size_t i = 0; i < kParts; ++i) {
      low[i] = hn::Set(kDoubles, std::numeric_limits<double>::infinity());
      high[i] = hn::Neg(low[i]);
      sum[i] = hn::Zero(kDoubles);
    }
  }
  HWY_INLINE explicit Extremes(const double* v) {
    for (std::size_t i = 0; i < kParts; ++i) {
      low[i] = high[i] = hn::LoadU(kDoubles, v + kDoubleLanes * i);
      sum[i] = low[i];
    }
  }
  HWY_INLINE void add(const double* v) {
    for (std::size_t i = 0; i < kParts; ++i) {
      const Doubles p = hn::LoadU(kDoubles, v + kDoubleLanes * i);
      low[i] = hn::Min(p, low[i]);
      high[i] = hn::Max(p, high[i]);
      sum[i] = hn::Add(sum[i], p);
    }
  }
  HWY_INLINE void add(const Extremes& other) {
    for (std::size_t i = 0; i < kParts; ++i) {
      low[i] = hn::Min(other.low[i], low[i]);
      high[i] = hn::Max(other.high[i], high[i]);
      sum[i] = hn::Add(sum[i], other.sum[i]);
    }
  }
  // Looks only whether it is finite.
  HWY_INLINE void count(const double* v) {
    for (std::size_t i = 0; i < kParts; ++i)
      sum[i] = hn::Add(sum[i], hn::LoadU(kDoubles, v + kDoubleLanes * i));
  }
  HWY_INLINE bool finite() const {
    bool all = true;
    for (const Doubles& part : sum) all = all && isFinite(kDoubles, part);
    return all;
  }
};

// How far a single can be off that is the nearest to some number, and then some: that is half a
// unit in the last place; 2^-23 |x| is one unit at least, and what is below the normal numbers is
// covered by their least.
template <class D, class V>
HWY_INLINE V doubtOf(D d, V x) {
  return hn::Add(hn::Mul(hn::Abs(x), hn::Set(d, 0x1p-23F)), hn::Set(d, 0x1p-126F));
}

// Single precision, outwards.
template <class D>
HWY_INLINE void outwards(D d, const Doubles* low, const Doubles* high, float* l, float* h) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    const hn::Rebind<float, D> four;
    const auto below = hn::DemoteTo(four, low[0]), above = hn::DemoteTo(four, high[0]);
    hn::StoreU(hn::Sub(below, doubtOf(four, below)), four, l);
    hn::StoreU(hn::Add(above, doubtOf(four, above)), four, h);
  } else {
    HWY_ALIGN double a[4], b[4];
    for (std::size_t i = 0; i < kParts; ++i) {
      hn::StoreU(low[i], d, a + kDoubleLanes * i);
      hn::StoreU(high[i], d, b + kDoubleLanes * i);
    }
    for (int k = 0; k < 3; ++k) {
      const auto below = static_cast<float>(a[k]), above = static_cast<float>(b[k]);
      l[k] = below - (std::abs(below) * 0x1p-23F + 0x1p-126F);
      h[k] = above + (std::abs(above) * 0x1p-23F + 0x1p-126F);
    }
  }
}

HWY_INLINE void putLane(const Extremes& e, WideBox& box, std::size_t lane) {
  HWY_ALIGN float l[4], h[4];
  outwards(kDoubles, e.low, e.high, l, h);
  for (int k = 0; k < 3; ++k) {
    box.low[k][lane] = l[k];
    box.high[k][lane] = h[k];
  }
}

// Three doubles and what comes behind them, to the nearest floats; aligned.
HWY_INLINE void putSingle(const double* from, float* to) {
  if constexpr (kParts == 1) {
    const hn::Rebind<float, decltype(kDoubles)> four;
    hn::Store(hn::DemoteTo(four, hn::LoadU(kDoubles, from)), four, to);
  } else {
    for (int k = 0; k < 4; ++k) to[k] = static_cast<float>(from[k]);
  }
}

HWY_INLINE Extremes boxOf(const Eigen::Vector3d* vertices, const std::int32_t* v,
                          const std::int32_t* end) {
  Extremes e(at(vertices, *v));
  if (end - v < 32) {
    for (++v; v != end; ++v) e.add(at(vertices, *v));
    return e;
  }
  Extremes other = e;  // two chains of dependent operations
  for (++v; end - v >= 2; v += 2) {
    e.add(at(vertices, v[0]));
    other.add(at(vertices, v[1]));
  }
  if (v != end) e.add(at(vertices, *v));
  e.add(other);
  return e;
}

// The box of all lanes into one lane of another box.
HWY_INLINE void unite(const WideBox& box, WideBox& parent, std::size_t lane) {
  for (int k = 0; k < 3; ++k) {
    Floats low = hn::Load(kLanes, box.low[k]), high = hn::Load(kLanes, box.high[k]);
    for (std::size_t i = kStep; i < kWidth; i += kStep) {
      low = hn::Min(low, hn::Load(kLanes, box.low[k] + i));
      high = hn::Max(high, hn::Load(kLanes, box.high[k] + i));
    }
    parent.low[k][lane] = hn::GetLane(hn::MinOfLanes(kLanes, low));
    parent.high[k][lane] = hn::GetLane(hn::MaxOfLanes(kLanes, high));
  }
}

void fillLane(WideBox& box, std::size_t lane, float low, float high) {
  for (int k = 0; k < 3; ++k) {
    box.low[k][lane] = low;
    box.high[k][lane] = high;
  }
}

// The boxes of a node's leaves, lane by lane, from its vertices as `near` has them: in single
// precision, for what is nearest to the least is the least of what is nearest. Leaves of a node are
// made out to be of the same size, since the end of a loop that comes as a surprise costs more.
HWY_INLINE void leavesFrom(const float (*near)[4], const std::uint8_t* corners, float (*low)[4],
                           float (*high)[4]) {
  const std::size_t count = *corners++;
  for (std::size_t lane = 0; lane < kWidth; ++lane, corners += count) {
    FourFloats l[kFloatParts], h[kFloatParts];
    for (std::size_t i = 0; i < kFloatParts; ++i)
      l[i] = h[i] = hn::Load(kFourFloats, near[corners[0]] + kFourLanes * i);
    for (std::size_t c = 1; c < count; ++c) {
      for (std::size_t i = 0; i < kFloatParts; ++i) {
        const FourFloats p = hn::Load(kFourFloats, near[corners[c]] + kFourLanes * i);
        l[i] = hn::Min(p, l[i]);
        h[i] = hn::Max(p, h[i]);
      }
    }
    for (std::size_t i = 0; i < kFloatParts; ++i) {
      hn::Store(l[i], kFourFloats, low[lane] + kFourLanes * i);
      hn::Store(h[i], kFourFloats, high[lane] + kFourLanes * i);
    }
  }
}

// The lanes of leaves, rounded outwards, into the node's boxes; lanes without a child become empty;
// those of nodes stay.
HWY_INLINE void putLeaves(const float (*low)[4], const float (*high)[4],
                          const DeformTree::Node& node, WideBox& box) {
  const hn::RebindToSigned<decltype(kLanes)> ints;
  const Floats infinity = hn::Set(kLanes, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    const auto child = hn::LoadU(ints, node.child + i);
    const auto none = hn::RebindMask(kLanes, hn::Eq(child, hn::Set(ints, DeformTree::kNone)));
    const auto inner = hn::RebindMask(kLanes, hn::Gt(child, hn::Set(ints, DeformTree::kNone)));
    const bool none_inner = hn::AllFalse(kLanes, inner);
    Floats l[4], h[4];
    hn::LoadInterleaved4(kLanes, low[i], l[0], l[1], l[2], l[3]);
    hn::LoadInterleaved4(kLanes, high[i], h[0], h[1], h[2], h[3]);
    for (int k = 0; k < 3; ++k) {
      l[k] = hn::IfThenElse(none, infinity, hn::Sub(l[k], doubtOf(kLanes, l[k])));
      h[k] = hn::IfThenElse(none, hn::Neg(infinity), hn::Add(h[k], doubtOf(kLanes, h[k])));
      if (!none_inner) {  // the box comes from far
        l[k] = hn::IfThenElse(inner, hn::Load(kLanes, box.low[k] + i), l[k]);
        h[k] = hn::IfThenElse(inner, hn::Load(kLanes, box.high[k] + i), h[k]);
      }
      hn::Store(l[k], kLanes, box.low[k] + i);
      hn::Store(h[k], kLanes, box.high[k] + i);
    }
  }
}

bool refit(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
           std::int32_t end, WideBox* boxes) {
  // Of the last node that was looked at; lanes without a leaf hold anything.
  HWY_ALIGN float near[3 * DeformTree::kLeafTriangles * kWidth][4];
  HWY_ALIGN float low[kWidth][4] = {}, high[kWidth][4] = {};
  const std::span<const DeformTree::Refit> refits = tree.refits();
  Extremes sums[4];  // a chain of dependent additions each
  for (std::int32_t id = end - 1; id >= begin; --id) {
    const DeformTree::Node& node = tree.node(id);
    const DeformTree::Refit &from = refits[static_cast<std::size_t>(id) + 1],
                            &to = refits[static_cast<std::size_t>(id)];
    WideBox& box = boxes[id];
    const std::int32_t* v = tree.refitVertices().data() + from.vertices;
    const std::int32_t* const last = tree.refitVertices().data() + to.vertices;
    if (v != last) {
      // Vertices come from far: each is fetched early, and read once.
      for (float(*put)[4] = near; v != last; v += 4, put += 4) {
        for (std::size_t i = 0; i < 4; ++i) {
          hwy::Prefetch(at(vertices, v[i + DeformTree::kAhead]));
          putSingle(at(vertices, v[i]), put[i]);
          sums[i].count(at(vertices, v[i]));
        }
      }
      leavesFrom(near, tree.refitCorners().data() + from.corners, low, high);
    }
    putLeaves(low, high, node, box);
    const DeformTree::Up& up = tree.up(id);
    if (up.parent >= begin) unite(box, boxes[up.parent], static_cast<std::size_t>(up.lane));
  }
  for (std::size_t i = 1; i < 4; ++i) sums[0].add(sums[i]);
  return sums[0].finite();
}

// Four vertices that stand side by side fill three vectors, or six or twelve: coordinates x, y, z,
// x, ... of as many vertices as a vector has lanes in any three of them.
struct FourExtremes {
  struct Third {
    Doubles low, high, sum;

    HWY_INLINE Third() {
      low = hn::Set(kDoubles, std::numeric_limits<double>::infinity());
      high = hn::Neg(low);
      sum = hn::Zero(kDoubles);
    }
    HWY_INLINE void add(const double* v) {
      const Doubles p = hn::LoadU(kDoubles, v);
      low = hn::Min(p, low);
      high = hn::Max(p, high);
      sum = hn::Add(sum, p);
    }
  };
  Third first, second, last;  // no array, so that they stay in registers

  HWY_INLINE FourExtremes() = default;
  HWY_INLINE void add(const double* v) {
    for (std::size_t part = 0; part < kParts; ++part, v += 3 * kDoubleLanes) {
      first.add(v);
      second.add(v + kDoubleLanes);
      last.add(v + 2 * kDoubleLanes);
    }
  }
  // Lowest and highest so far, to go on with others; what is not finite is summed up over all.
  HWY_INLINE void save(BranchBox& box) const {
    hn::Store(first.low, kDoubles, box.low);
    hn::Store(second.low, kDoubles, box.low + kDoubleLanes);
    hn::Store(last.low, kDoubles, box.low + 2 * kDoubleLanes);
    hn::Store(first.high, kDoubles, box.high);
    hn::Store(second.high, kDoubles, box.high + kDoubleLanes);
    hn::Store(last.high, kDoubles, box.high + 2 * kDoubleLanes);
  }
  HWY_INLINE void resume(const BranchBox& box) {
    first.low = hn::Load(kDoubles, box.low);
    second.low = hn::Load(kDoubles, box.low + kDoubleLanes);
    last.low = hn::Load(kDoubles, box.low + 2 * kDoubleLanes);
    first.high = hn::Load(kDoubles, box.high);
    second.high = hn::Load(kDoubles, box.high + kDoubleLanes);
    last.high = hn::Load(kDoubles, box.high + 2 * kDoubleLanes);
  }
  // All of them, and those of `e`. Number by number: a vector that straddles two that were just
  // stored waits for both.
  HWY_INLINE void fold(const Extremes& e, double* lowest, double* highest) const {
    HWY_ALIGN double l[3 * kDoubleLanes + 4], h[3 * kDoubleLanes + 4];
    hn::Store(first.low, kDoubles, l);
    hn::Store(second.low, kDoubles, l + kDoubleLanes);
    hn::Store(last.low, kDoubles, l + 2 * kDoubleLanes);
    hn::Store(first.high, kDoubles, h);
    hn::Store(second.high, kDoubles, h + kDoubleLanes);
    hn::Store(last.high, kDoubles, h + 2 * kDoubleLanes);
    for (std::size_t i = 0; i < kParts; ++i) {
      hn::StoreU(e.low[i], kDoubles, l + kDoubleLanes * (3 + i));
      hn::StoreU(e.high[i], kDoubles, h + kDoubleLanes * (3 + i));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      lowest[k] = l[k];
      highest[k] = h[k];
      for (std::size_t v = 1; v <= kDoubleLanes; ++v) {
        lowest[k] = std::min(lowest[k], l[3 * v + k]);
        highest[k] = std::max(highest[k], h[3 * v + k]);
      }
    }
  }
  HWY_INLINE bool finite() const {
    return isFinite(kDoubles, first.sum) && isFinite(kDoubles, second.sum) &&
           isFinite(kDoubles, last.sum);
  }
};

// Adds the fours begin .. end - 1. Vertices come from far: fetching them kAhead fours early saves a
// third of the time. An update goes on to those of the next branch, a query seldom past its node.
template <std::size_t kAhead>
HWY_INLINE void addFours(std::span<const std::int32_t> fours, std::int32_t begin, std::int32_t end,
                         const Eigen::Vector3d* vertices, FourExtremes& four) {
  for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
    const double* ahead = at(vertices, fours[std::min(i + kAhead, fours.size() - 1)]);
    hwy::Prefetch(ahead);
    hwy::Prefetch(ahead + 8);
    four.add(at(vertices, fours[i]));
  }
}

// The vertices of a branch that stand alone, and all that `four` holds, into its parent's lane.
HWY_INLINE bool endBranch(const DeformTree& tree, const Eigen::Vector3d* vertices,
                          const DeformTree::Branch& branch, const FourExtremes& four,
                          WideBox* boxes) {
  Extremes e;
  for (std::int32_t i = branch.runs.single_begin; i < branch.runs.single_end; ++i)
    e.add(at(vertices, tree.singles()[static_cast<std::size_t>(i)]));
  double low[3], high[3];
  four.fold(e, low, high);
  const DeformTree::Up& up = tree.up(branch.root);
  WideBox& box = boxes[up.parent];
  for (int k = 0; k < 3; ++k) {
    box.low[k][up.lane] = roundedDown(low[k]);
    box.high[k][up.lane] = roundedUpToFloat(high[k]);
  }
  return e.finite();
}

bool branches(const DeformTree& tree, const Eigen::Vector3d* vertices, std::size_t begin,
              std::size_t end, WideBox* boxes) {
  bool finite = true;
  for (const DeformTree::Branch& branch : tree.branches().subspan(begin, end - begin)) {
    FourExtremes four;
    addFours<96>(tree.fours(), branch.runs.four_begin, branch.runs.four_end, vertices, four);
    finite &= four.finite();
    finite &= endBranch(tree, vertices, branch, four, boxes);
  }
  return finite;
}

constexpr std::size_t kRowAhead = 384;  // doubles

// Memory comes faster in its own order than in that of the branches, and faster still where it is
// fetched 3 KB early: 30 % less time together.
bool allBranches(const DeformTree& tree, const Eigen::Vector3d* vertices, BranchBox* room,
                 WideBox* boxes) {
  const std::span<const DeformTree::Branch> branches = tree.branches();
  FourExtremes four;
  for (std::size_t b = 0; b < branches.size(); ++b) four.save(room[b]);
  for (const DeformTree::Row& row : tree.rows()) {
    BranchBox& box = room[static_cast<std::size_t>(row.branch)];
    four.resume(box);
    const std::int32_t last = row.begin + row.count - 4;
    for (std::int32_t i = row.begin; i < last; i += 4) {
      const double* v = at(vertices, i);
      hwy::Prefetch(v + kRowAhead);
      hwy::Prefetch(v + kRowAhead + 8);
      four.add(v);
    }
    four.add(at(vertices, last));
    four.save(box);
  }
  bool finite = four.finite();
  for (std::size_t b = 0; b < branches.size(); ++b) {
    four.resume(room[b]);
    finite &= endBranch(tree, vertices, branches[b], four, boxes);
  }
  return finite;
}

// One lane of a box from the vertices in the runs; false when one is not finite.
HWY_INLINE bool fromRuns(const DeformTree& tree, const Eigen::Vector3d* vertices,
                         const DeformTree::Runs& runs, WideBox& box, std::size_t lane) {
  FourExtremes four;
  addFours<16>(tree.fours(), runs.four_begin, runs.four_end, vertices, four);
  Extremes e;
  for (std::int32_t i = runs.single_begin; i < runs.single_end; ++i)
    e.add(at(vertices, tree.singles()[static_cast<std::size_t>(i)]));
  double low[3], high[3];
  four.fold(e, low, high);
  for (int k = 0; k < 3; ++k) {
    box.low[k][lane] = roundedDown(low[k]);
    box.high[k][lane] = roundedUpToFloat(high[k]);
  }
  return four.finite() && e.finite();
}

// Of a node that has nothing but leaves, as refit() does it. False when a vertex is not finite.
bool fromLeaves(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t id,
                WideBox& box) {
  HWY_ALIGN float near[3 * DeformTree::kLeafTriangles * kWidth][4];
  HWY_ALIGN float low[kWidth][4], high[kWidth][4];
  const DeformTree::Refit &from = tree.refits()[static_cast<std::size_t>(id) + 1],
                          &to = tree.refits()[static_cast<std::size_t>(id)];
  const std::int32_t* v = tree.refitVertices().data() + from.vertices;
  const std::int32_t* const last = tree.refitVertices().data() + to.vertices;
  Extremes sum;
  for (float(*put)[4] = near; v != last; ++v, ++put) {
    putSingle(at(vertices, *v), *put);
    sum.count(at(vertices, *v));
  }
  leavesFrom(near, tree.refitCorners().data() + from.corners, low, high);
  putLeaves(low, high, tree.node(id), box);
  return sum.finite();
}

void fromVertices(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t id,
                  WideBox& box) {
  const DeformTree::Node& node = tree.node(id);
  if (std::all_of(node.child, node.child + kWidth, [](std::int32_t child) { return child < 0; }) &&
      fromLeaves(tree, vertices, id, box))
    return;
  for (std::size_t lane = 0; lane < kWidth; ++lane) {
    const std::int32_t child = node.child[lane];
    bool finite = true;
    if (child == DeformTree::kNone) {
      fillLane(box, lane, std::numeric_limits<float>::infinity(),
               -std::numeric_limits<float>::infinity());
    } else if (child >= tree.upperCount() && id >= tree.upperCount()) {
      finite = fromRuns(tree, vertices, tree.runs(child), box, lane);
    } else {
      const std::span<const std::int32_t> below = tree.vertices(id, static_cast<int>(lane));
      const Extremes e = boxOf(vertices, below.data(), below.data() + below.size());
      finite = e.finite();
      putLane(e, box, lane);
    }
    if (!finite) {
      fillLane(box, lane, -std::numeric_limits<float>::max(), std::numeric_limits<float>::max());
    }
  }
}

void triangles(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
               std::int32_t end, WideBox& box) {
  box.clear();
  for (std::int32_t slot = begin; slot < end; ++slot) {
    const DeformTree::Triangle& t = tree.corners(slot);
    const Extremes e = boxOf(vertices, t.data(), t.data() + 3);
    const auto lane = static_cast<std::size_t>(slot - begin);
    putLane(e, box, lane);
    if (!e.finite())
      fillLane(box, lane, -std::numeric_limits<float>::max(), std::numeric_limits<float>::max());
  }
}

// Fours of vertices that stand one after the other, each fetched early. A function of its own: in
// one with more to do g++ 12 keeps some of the extremes in memory, which takes 2.5 times as long.
HWY_NOINLINE void addRow(const double* v, const double* last, FourExtremes& four) {
  FourExtremes held = four;
  for (; v != last; v += 12) {
    hwy::Prefetch(v + kRowAhead);
    hwy::Prefetch(v + kRowAhead + 8);
    held.add(v);
  }
  four = held;
}

bool bound(const Eigen::Vector3d* vertices, std::size_t count, double limit, Eigen::Vector3d& low,
           Eigen::Vector3d& high) {
  const double* v = vertices->data();
  const double* const last = v + 12 * (count / 4);
  FourExtremes four;
  addRow(v, last, four);
  Extremes e;
  for (v = last; v != vertices->data() + 3 * count; v += 3) e.add(v);
  double l[3], h[3];
  four.fold(e, l, h);
  bool good = four.finite() && e.finite();
  for (std::size_t k = 0; k < 3; ++k) {
    low[static_cast<Eigen::Index>(k)] = l[k];
    high[static_cast<Eigen::Index>(k)] = h[k];
    good = good && l[k] >= -limit && h[k] <= limit;
  }
  return good;
}

constexpr unsigned kStepBits = (1U << kStep) - 1;

template <class M>
HWY_INLINE unsigned bitsOf(M mask) {
  std::uint8_t bits[8] = {};  // as many as StoreMaskBits() may write
  hn::StoreMaskBits(kLanes, mask, bits);
  return bits[0] & kStepBits;
}

// Those at or below the bar, a bit each; the least of the others goes into `closed`.
HWY_INLINE unsigned openOf(Floats lower, Floats bar, Floats& closed) {
  // Written so that what is no number stays open; the others are settled by their least.
  const auto above = hn::Gt(lower, bar);
  closed = hn::Min(closed, hn::IfThenElse(above, lower, closed));
  return ~bitsOf(above) & kStepBits;
}

// By boxes; kTurned: along the body's own axes, too.
//
// Boxes are loose on tilted sheets. Slabs beside them, along one normal a branch, with the way
// across it, close a fifth to three tenths of the nodes that boxes leave open, seen on 20k and 200k
// triangles in waves; but the bound takes in every node what is saved, so that 12 distances come
// out even, and a refit that finds the slabs takes a third longer. Boxes in a frame of each branch
// would close no more.
template <bool kTurned>
HWY_INLINE void lowerBounds(const Probe& probe, const WideBox& box, float bar, Bounds& bounds) {
  const Floats zero = hn::Zero(kLanes), half = hn::Set(kLanes, 0.5F);
  const auto set = [](float x) { return hn::Set(kLanes, x); };
  Floats closed = set(std::numeric_limits<float>::infinity());
  bounds.open = 0;
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    Floats middle[3], size[3];
    Floats squared = zero, deepest = set(-std::numeric_limits<float>::infinity());
    for (int k = 0; k < 3; ++k) {
      const Floats low = hn::Load(kLanes, box.low[k] + i), high = hn::Load(kLanes, box.high[k] + i);
      if constexpr (kTurned) {
        middle[k] = hn::Mul(hn::Add(low, high), half);
        size[k] = hn::Mul(hn::Sub(high, low), half);
      }
      const Floats gap =
          hn::Max(hn::Sub(low, set(probe.high[k])), hn::Sub(set(probe.low[k]), high));
      deepest = hn::Max(deepest, gap);
      const Floats outside = hn::Max(gap, zero);
      squared = hn::Add(squared, hn::Mul(outside, outside));
    }
    if constexpr (kTurned) {
      Floats squared_axes = zero;
      for (int j = 0; j < 3; ++j) {
        Floats center = zero, reach = zero;
        for (int k = 0; k < 3; ++k) {
          const float n = probe.axis[j][k];
          center = hn::Add(center, hn::Mul(set(n), middle[k]));
          reach = hn::Add(reach, hn::Mul(set(std::abs(n)), size[k]));
        }
        const Floats gap = hn::Sub(hn::Max(hn::Sub(center, set(probe.axis_high[j])),
                                           hn::Sub(set(probe.axis_low[j]), center)),
                                   reach);
        deepest = hn::Max(deepest, gap);
        const Floats outside = hn::Max(gap, zero);
        squared_axes = hn::Add(squared_axes, hn::Mul(outside, outside));
      }
      squared = hn::Max(squared, squared_axes);
    }
    // Axes that depart from a rotation by 1e-6 make distances along them too large by half of that.
    // Squares beyond the range of float still are squares of at least its root; those that lost
    // digits to the numbers below the normal ones say nothing.
    const Floats kept = hn::Min(squared, set(std::numeric_limits<float>::max()));
    Floats lower = hn::Mul(hn::Sqrt(kept), set(static_cast<float>(1 - kRotationTolerance)));
    lower = hn::IfThenElse(hn::Gt(kept, set(kLeastWaySquared)), lower, hn::Min(deepest, zero));
    lower = hn::Sub(hn::Sub(lower, set(probe.radius)), set(probe.slack));
    lower =
        hn::IfThenElse(hn::Le(hn::Load(kLanes, box.low[0] + i), hn::Load(kLanes, box.high[0] + i)),
                       lower, set(std::numeric_limits<float>::infinity()));
    hn::Store(lower, kLanes, bounds.lower + i);
    bounds.open |= openOf(lower, set(bar), closed) << i;
  }
  bounds.closed = hn::GetLane(hn::MinOfLanes(kLanes, closed));
}

// The plane across the way from the body's point that is nearest to the middle of the triangle: as
// good as exact when the triangle is small beside the distance, where its box is not. In
// coordinates along the probe's own axes, in which the body is a box.
void triangleBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                    std::int32_t begin, std::int32_t end, Bounds& bounds) {
  HWY_ALIGN float corner[3][kWidth][4];  // corner, triangle, axis
  for (std::int32_t slot = begin; slot < begin + kWidth; ++slot) {
    // Lanes that are left over hold the last triangle again.
    const DeformTree::Triangle& t = tree.corners(std::min(slot, end - 1));
    const std::size_t lane = static_cast<std::size_t>(slot - begin);
    for (std::size_t c = 0; c < 3; ++c) putSingle(at(vertices, t[c]), corner[c][lane]);
  }
  const auto set = [](float x) { return hn::Set(kLanes, x); };
  const Floats third = set(1.0F / 3), zero = hn::Zero(kLanes);
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    Floats p[3][3], outside = zero;  // corner, axis; distance of the boxes, squared
    for (int c = 0; c < 3; ++c) {
      Floats next;  // what came behind the three coordinates
      hn::LoadInterleaved4(kLanes, corner[c][i], p[c][0], p[c][1], p[c][2], next);
    }
    for (int k = 0; k < 3; ++k) {
      const Floats low = hn::Min(hn::Min(p[0][k], p[1][k]), p[2][k]),
                   high = hn::Max(hn::Max(p[0][k], p[1][k]), p[2][k]);
      const Floats gap = hn::Max(
          hn::Max(hn::Sub(low, set(probe.high[k])), hn::Sub(set(probe.low[k]), high)), zero);
      outside = hn::Add(outside, hn::Mul(gap, gap));
    }
    Floats along[3][3], way[3], nearest[3], squared = zero, sum = zero;
    for (int j = 0; j < 3; ++j) {
      for (int c = 0; c < 3; ++c) {
        along[c][j] = hn::Add(hn::Add(hn::Mul(set(probe.axis[j][0]), p[c][0]),
                                      hn::Mul(set(probe.axis[j][1]), p[c][1])),
                              hn::Mul(set(probe.axis[j][2]), p[c][2]));
      }
      sum = hn::Add(hn::Add(along[0][j], along[1][j]), along[2][j]);
      const Floats middle = hn::Mul(sum, third);
      nearest[j] = hn::Min(hn::Max(middle, set(probe.axis_low[j])), set(probe.axis_high[j]));
      way[j] = hn::Sub(middle, nearest[j]);
      squared = hn::Add(squared, hn::Mul(way[j], way[j]));
    }
    Floats least = set(std::numeric_limits<float>::infinity());
    for (const auto& of_corner : along) {
      Floats reach = zero;
      for (int j = 0; j < 3; ++j)
        reach = hn::Add(reach, hn::Mul(way[j], hn::Sub(of_corner[j], nearest[j])));
      least = hn::Min(least, reach);
    }
    const auto usable = hn::Gt(squared, set(kLeastWaySquared));
    const Floats safe = hn::IfThenElse(usable, squared, set(1.0F));
    Floats lower = hn::Div(least, hn::Sqrt(safe));
    // Axes that depart from a rotation by 1e-6 make the way longer or shorter than its square says.
    lower =
        hn::Sub(lower, hn::Mul(hn::Abs(lower), set(static_cast<float>(2 * kRotationTolerance))));
    // Boxes that meet say nothing of how deep; squares as in lowerBounds().
    const Floats unknown = set(-std::numeric_limits<float>::infinity());
    const Floats by_box =
        hn::IfThenElse(hn::Gt(outside, set(kLeastWaySquared)),
                       hn::Sqrt(hn::Min(outside, set(std::numeric_limits<float>::max()))), unknown);
    lower = hn::Max(hn::IfThenElse(usable, lower, unknown), by_box);
    // Boxes may have left out a corner that is not finite; this sum of all coordinates has not.
    const auto finite = hn::Eq(hn::Sub(sum, sum), zero);
    lower = hn::IfThenElse(finite, lower, unknown);
    hn::Store(hn::Sub(hn::Sub(lower, set(probe.radius)), set(probe.slack)), kLanes,
              bounds.lower + i);
  }
}

// The least scalar product of n and some vertices; false when one is not finite.
HWY_INLINE bool leastOf(const double* n, const Eigen::Vector3d* vertices, const std::int32_t* v,
                        std::size_t count, double& least) {
  LeastAlong along(n);
  along.add(vertices, v, count);
  least = along.least();
  return along.isFinite();
}

bool leastAlong(const double* n, const Eigen::Vector3d* vertices, std::span<const std::int32_t> of,
                double& least) {
  return leastOf(n, vertices, of.data(), of.size(), least);
}

void openLanes(float bar, Bounds& bounds) {
  bounds.open = 0;
  Floats closed = hn::Set(kLanes, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    bounds.open |= openOf(hn::Load(kLanes, bounds.lower + i), hn::Set(kLanes, bar), closed) << i;
  }
  bounds.closed = hn::GetLane(hn::MinOfLanes(kLanes, closed));
}

// Those that are leaves, a bit each.
unsigned leafLanes(const DeformTree::Node& node) {
  const hn::RebindToSigned<decltype(kLanes)> ints;
  unsigned leaves = 0;
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    const auto leaf = hn::Lt(hn::LoadU(ints, node.child + i), hn::Set(ints, DeformTree::kNone));
    leaves |= bitsOf(hn::RebindMask(kLanes, leaf)) << i;
  }
  return leaves;
}

// In exact arithmetic no point of a convex body is farther along the way from its nearest point to
// some other than that nearest point, so that the plane across it bounds all that is beyond; the
// body is a box along the probe's axes.
void leafBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                const DeformTree::Node& node, const WideBox& box, float bar, Bounds& bounds) {
  const unsigned leaves = bounds.open & leafLanes(node);
  if (leaves == 0) return;
  // They come from far: which they are first, and below what they say.
  for (unsigned left = leaves; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(node.child[lane]));
    hwy::Prefetch(tree.leafVertices().data() + leaf.vertex_begin);
  }
  const Floats zero = hn::Zero(kLanes), half = hn::Set(kLanes, 0.5F);
  const auto set = [](float x) { return hn::Set(kLanes, x); };
  // The way, a unit vector, in the boxes' frame, and how far the body reaches along it.
  HWY_ALIGN float way[3][kWidth], reach[kWidth];
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    Floats middle[3], x = zero, y = zero, z = zero, squared = zero, along_way = zero;
    for (int k = 0; k < 3; ++k) {
      middle[k] = hn::Mul(
          hn::Add(hn::Load(kLanes, box.low[k] + i), hn::Load(kLanes, box.high[k] + i)), half);
    }
    for (int j = 0; j < 3; ++j) {
      const Floats a = set(probe.axis[j][0]), b = set(probe.axis[j][1]), c = set(probe.axis[j][2]);
      const Floats along =
          hn::Add(hn::Add(hn::Mul(a, middle[0]), hn::Mul(b, middle[1])), hn::Mul(c, middle[2]));
      const Floats nearest =
          hn::Min(hn::Max(along, set(probe.axis_low[j])), set(probe.axis_high[j]));
      const Floats d = hn::Sub(along, nearest);
      squared = hn::Add(squared, hn::Mul(d, d));
      along_way = hn::Add(along_way, hn::Mul(d, nearest));
      x = hn::Add(x, hn::Mul(d, a));
      y = hn::Add(y, hn::Mul(d, b));
      z = hn::Add(z, hn::Mul(d, c));
    }
    // Too short a way, or none, becomes NaN and infinity, and fails below.
    const Floats scale = hn::Div(
        set(1.0F), hn::Sqrt(hn::IfThenElseZero(hn::Gt(squared, set(kLeastWaySquared)), squared)));
    hn::Store(hn::Mul(x, scale), kLanes, way[0] + i);
    hn::Store(hn::Mul(y, scale), kLanes, way[1] + i);
    hn::Store(hn::Mul(z, scale), kLanes, way[2] + i);
    hn::Store(hn::Mul(along_way, scale), kLanes, reach + i);
  }
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  HWY_ALIGN double least[kWidth];
  std::fill_n(least, kWidth, unknown);
  for (unsigned left = leaves; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(node.child[lane]));
    const double n[3] = {static_cast<double>(way[0][lane]), static_cast<double>(way[1][lane]),
                         static_cast<double>(way[2][lane])};
    double lowest = 0;
    const bool finite =
        leastOf(n, vertices, tree.leafVertices().data() + leaf.vertex_begin,
                static_cast<std::size_t>(leaf.vertex_end - leaf.vertex_begin), lowest);
    if (finite) least[lane] = lowest;  // a vertex that is not says nothing
  }
  // As in triangleBounds().
  const Doubles grown =
      hn::Set(kDoubles, static_cast<double>(probe.radius) + static_cast<double>(probe.slack));
  for (std::size_t i = 0; i < kWidth; i += kDoubleLanes) {
    const hn::Rebind<float, decltype(kDoubles)> singles;
    const Doubles along = hn::Load(kDoubles, least + i);
    Doubles lower = hn::Sub(along, hn::PromoteTo(kDoubles, hn::Load(singles, reach + i)));
    lower = hn::Sub(
        lower, hn::Add(hn::Mul(hn::Abs(lower), hn::Set(kDoubles, 2 * kRotationTolerance)), grown));
    lower = hn::Sub(lower, hn::Mul(hn::Abs(lower), hn::Set(kDoubles, 0x1p-23)));
    // NaN, where nothing is known, is not greater on any instruction set.
    const auto found = hn::DemoteTo(singles, lower), before = hn::Load(singles, bounds.lower + i);
    hn::Store(hn::IfThenElse(hn::Gt(found, before), found, before), singles, bounds.lower + i);
  }
  openLanes(bar, bounds);
}

void childBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                 std::span<const std::int32_t> nodes, const WideBox* const* boxes, float bar,
                 Bounds* bounds) {
  bar = std::min(bar, std::numeric_limits<float>::max());  // empty lanes are above any
  // Without a branch that hangs on what came before, so that several are worked on at a time.
  if (probe.turned) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      lowerBounds<true>(probe, *boxes[i], bar, bounds[i]);
  } else {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      lowerBounds<false>(probe, *boxes[i], bar, bounds[i]);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    leafBounds(probe, tree, vertices, tree.node(nodes[i]), *boxes[i], bar, bounds[i]);
}

}  // namespace

const DeformKernels* kernels() {
  static constexpr DeformKernels kKernels = {refit,        branches,    allBranches,
                                             fromVertices, triangles,   triangleBounds,
                                             bound,        childBounds, leastAlong};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(kernels);

const DeformKernels& deformKernels() { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace leeway::collision
#endif
