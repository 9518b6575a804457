#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "collision/base/rounding.h"
#include "collision/deform/tree/refit.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform/tree/refit_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "collision/deform/tree/vertex_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

// Four floats in one or more vectors.
const hn::CappedTag<float, 4> kFourFloats;
using FourFloats = hn::Vec<decltype(kFourFloats)>;
constexpr std::size_t kFourLanes = hn::MaxLanes(decltype(kFourFloats)());
constexpr std::size_t kFloatParts = 4 / kFourLanes;

// Writes the union of the eight boxes of a node to the node's column of its parent.
HWY_INLINE void unite(const WideBox& box, WideBox& parent, std::size_t column) {
  for (int k = 0; k < 3; ++k) {
    Floats low = hn::Load(kLanes, box.low[k]), high = hn::Load(kLanes, box.high[k]);
    for (std::size_t i = kStep; i < kWidth; i += kStep) {
      low = hn::Min(low, hn::Load(kLanes, box.low[k] + i));
      high = hn::Max(high, hn::Load(kLanes, box.high[k] + i));
    }
    parent.low[k][column] = hn::GetLane(hn::MinOfLanes(kLanes, low));
    parent.high[k][column] = hn::GetLane(hn::MaxOfLanes(kLanes, high));
  }
}

// The boxes of a node's leaves, column by column, from its vertices `near`, rounded to nearest.
// Rounding is monotonic, so the least of the rounded numbers is the rounded least. All leaves of a
// node are padded to one size, because a mispredicted loop end costs more.
HWY_INLINE void leavesFrom(const float (*near)[4], const std::uint8_t* corners, float (*low)[4],
                           float (*high)[4]) {
  const std::size_t count = *corners++;
  for (std::size_t column = 0; column < kWidth; ++column, corners += count) {
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
      hn::Store(l[i], kFourFloats, low[column] + kFourLanes * i);
      hn::Store(h[i], kFourFloats, high[column] + kFourLanes * i);
    }
  }
}

// Writes the boxes of leaves, rounded outwards, to the columns of leaves. Empties columns without a
// child, and keeps those of child nodes, which unite() has filled.
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
      if (!none_inner) {  // otherwise avoids a load that misses the cache
        l[k] = hn::IfThenElse(inner, hn::Load(kLanes, box.low[k] + i), l[k]);
        h[k] = hn::IfThenElse(inner, hn::Load(kLanes, box.high[k] + i), h[k]);
      }
      hn::Store(l[k], kLanes, box.low[k] + i);
      hn::Store(h[k], kLanes, box.high[k] + i);
    }
  }
}

// One backward loop over the nodes: first the boxes of a node's leaves from their vertices, then
// the union of all its boxes into its parent, which is processed later.
bool refit(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
           std::int32_t end, WideBox* boxes) {
  // Vertices and leaf boxes of the current node; columns without a leaf have old values.
  HWY_ALIGN float near[3 * DeformTree::kLeafTriangles * kWidth][4];
  HWY_ALIGN float low[kWidth][4] = {}, high[kWidth][4] = {};
  const std::span<const DeformTree::RefitOffsets> offsets = tree.refitOffsets();
  Extremes sums[4];  // four independent chains of additions
  for (std::int32_t id = end - 1; id >= begin; --id) {
    const DeformTree::Node& node = tree.node(id);
    const DeformTree::RefitOffsets &from = offsets[static_cast<std::size_t>(id) + 1],
                                   &to = offsets[static_cast<std::size_t>(id)];
    WideBox& box = boxes[id];
    const std::int32_t* v = tree.refitVertices().data() + from.vertices;
    const std::int32_t* const last = tree.refitVertices().data() + to.vertices;
    if (v != last) {
      // Each vertex is prefetched and read once.
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
    if (up.parent >= begin) unite(box, boxes[up.parent], static_cast<std::size_t>(up.column));
  }
  for (std::size_t i = 1; i < 4; ++i) sums[0].add(sums[i]);
  return sums[0].finite();
}

// Writes the box of `four` and of the single vertices of the runs to a column. Returns whether the
// single vertices are finite.
HWY_INLINE bool endRuns(const DeformTree& tree, const Eigen::Vector3d* vertices,
                        const DeformTree::Runs& runs, const FourExtremes& four, WideBox& box,
                        std::int32_t column) {
  Extremes e;
  for (std::int32_t i = runs.single_begin; i < runs.single_end; ++i)
    e.add(at(vertices, tree.singles()[static_cast<std::size_t>(i)]));
  double low[3], high[3];
  four.fold(e, low, high);
  for (int k = 0; k < 3; ++k) {
    box.low[k][column] = roundedDown(low[k]);
    box.high[k][column] = roundedUpToFloat(high[k]);
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
    const DeformTree::Up& up = tree.up(branch.root);
    finite &= endRuns(tree, vertices, branch.runs, four, boxes[up.parent], up.column);
  }
  return finite;
}

constexpr std::size_t kRowAhead = 384;  // prefetch distance [doubles]

// Reads vertices in the order of memory instead of branches, prefetching 3 KB ahead: together 30 %
// less time.
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
    const DeformTree::Up& up = tree.up(branches[b].root);
    finite &= endRuns(tree, vertices, branches[b].runs, four, boxes[up.parent], up.column);
  }
  return finite;
}

// The boxes of a node that has only leaves, as refit() computes them. False if a vertex is not
// finite.
bool fromLeaves(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t id,
                WideBox& box) {
  HWY_ALIGN float near[3 * DeformTree::kLeafTriangles * kWidth][4];
  HWY_ALIGN float low[kWidth][4], high[kWidth][4];
  const DeformTree::RefitOffsets &from = tree.refitOffsets()[static_cast<std::size_t>(id) + 1],
                                 &to = tree.refitOffsets()[static_cast<std::size_t>(id)];
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
  for (std::size_t column = 0; column < kWidth; ++column) {
    const std::int32_t child = node.child[column];
    bool finite = true;
    if (child == DeformTree::kNone) {
      fillColumn(box, column, std::numeric_limits<float>::infinity(),
                 -std::numeric_limits<float>::infinity());
    } else if (child >= tree.upperCount() && id >= tree.upperCount()) {
      const DeformTree::Runs& runs = tree.runs(child);
      FourExtremes four;
      addFours<16>(tree.fours(), runs.four_begin, runs.four_end, vertices, four);
      finite = endRuns(tree, vertices, runs, four, box, static_cast<std::int32_t>(column));
      finite = four.finite() && finite;
    } else {
      const std::span<const std::int32_t> below = tree.vertices(id, static_cast<int>(column));
      const Extremes e = boxOf(vertices, below.data(), below.data() + below.size());
      finite = e.finite();
      putColumn(e, box, column);
    }
    if (!finite) {
      fillColumn(box, column, -std::numeric_limits<float>::max(),
                 std::numeric_limits<float>::max());
    }
  }
}

void triangles(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
               std::int32_t end, WideBox& box) {
  box.clear();
  for (std::int32_t slot = begin; slot < end; ++slot) {
    const DeformTree::Triangle& t = tree.corners(slot);
    const Extremes e = boxOf(vertices, t.data(), t.data() + 3);
    const auto column = static_cast<std::size_t>(slot - begin);
    putColumn(e, box, column);
    if (!e.finite())
      fillColumn(box, column, -std::numeric_limits<float>::max(),
                 std::numeric_limits<float>::max());
  }
}

// Adds consecutive vertices, four at a time. Not inlined, because within a larger function g++ 12
// spills some of the extremes, which takes 2.5 times as long.
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

}  // namespace

const DeformKernels* deformKernelsOfTarget() {
  static constexpr DeformKernels kKernels = {refit,        branches,  allBranches,
                                             fromVertices, triangles, bound};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(deformKernelsOfTarget);

const DeformKernels& deformKernels() { return *HWY_DYNAMIC_DISPATCH(deformKernelsOfTarget)(); }

}  // namespace leeway::collision
#endif
