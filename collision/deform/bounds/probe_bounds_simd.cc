#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/deform/bounds/probe_bounds.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform/bounds/probe_bounds_simd.cc"
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

// A bit for each column at or below the bar; lowers `closed` to the least bound of the other
// columns.
HWY_INLINE unsigned openOf(Floats lower, Floats bar, Floats& closed) {
  // A column with NaN stays open.
  const auto above = hn::Gt(lower, bar);
  closed = hn::Min(closed, hn::IfThenElse(above, lower, closed));
  return ~bitsOf(above) & kStepBits;
}

// Lower bounds by the boxes alone; kTurned: also along the body's own axes.
//
// Tried and rejected: slabs in addition to the boxes, along one normal for each branch, because
// boxes are loose around tilted sheets. On waves of 20k and 200k triangles they closed 20 to 30 %
// of the nodes that boxes leave open, but evaluating them cost as much (the time of 12 distances
// was the same) and a refit took a third longer. Boxes in a separate frame for each branch would
// close no more.
template <bool kTurned>
HWY_INLINE void lowerBounds(const Probe& probe, const WideBox& box, float bar, WideBounds& bounds) {
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
    // Axes that depart from a rotation by 1e-6 overstate distances by half of that. A square that
    // overflows is at least the largest float. A square near the subnormal numbers has lost its
    // digits and proves nothing.
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

// Uses a plane for each triangle, perpendicular to the line from the body's nearest point to the
// triangle's centroid, in coordinates along the probe's own axes, in which the body is a box. This
// is nearly exact for triangles that are small compared with the distance, whose boxes are loose.
void triangleBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                    std::int32_t begin, std::int32_t end, WideBounds& bounds) {
  HWY_ALIGN float corner[3][kWidth][4];  // corner, triangle, axis
  for (std::int32_t slot = begin; slot < begin + kWidth; ++slot) {
    // Unused lanes repeat the last triangle.
    const DeformTree::Triangle& t = tree.corners(std::min(slot, end - 1));
    const std::size_t lane = static_cast<std::size_t>(slot - begin);
    for (std::size_t c = 0; c < 3; ++c) putSingle(at(vertices, t[c]), corner[c][lane]);
  }
  const auto set = [](float x) { return hn::Set(kLanes, x); };
  const Floats third = set(1.0F / 3), zero = hn::Zero(kLanes);
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    Floats p[3][3], outside = zero;  // corner, axis; distance of the boxes, squared
    for (int c = 0; c < 3; ++c) {
      Floats next;  // the number after the three coordinates
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
    // The line's length is inexact if the axes depart from a rotation by 1e-6.
    lower =
        hn::Sub(lower, hn::Mul(hn::Abs(lower), set(static_cast<float>(2 * kRotationTolerance))));
    // Overlapping boxes prove nothing about depth; squares as in lowerBounds().
    const Floats unknown = set(-std::numeric_limits<float>::infinity());
    const Floats by_box =
        hn::IfThenElse(hn::Gt(outside, set(kLeastWaySquared)),
                       hn::Sqrt(hn::Min(outside, set(std::numeric_limits<float>::max()))), unknown);
    lower = hn::Max(hn::IfThenElse(usable, lower, unknown), by_box);
    // Minimum and maximum may have dropped a NaN, but the sum of all coordinates has not.
    const auto finite = hn::Eq(hn::Sub(sum, sum), zero);
    lower = hn::IfThenElse(finite, lower, unknown);
    hn::Store(hn::Sub(hn::Sub(lower, set(probe.radius)), set(probe.slack)), kLanes,
              bounds.lower + i);
  }
}

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

// Computes `open` and `closed` again.
void openColumns(float bar, WideBounds& bounds) {
  bounds.open = 0;
  Floats closed = hn::Set(kLanes, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    bounds.open |= openOf(hn::Load(kLanes, bounds.lower + i), hn::Set(kLanes, bar), closed) << i;
  }
  bounds.closed = hn::GetLane(hn::MinOfLanes(kLanes, closed));
}

// A bit for each child that is a leaf.
unsigned leafColumns(const DeformTree::Node& node) {
  const hn::RebindToSigned<decltype(kLanes)> ints;
  unsigned leaves = 0;
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    const auto leaf = hn::Lt(hn::LoadU(ints, node.child + i), hn::Set(ints, DeformTree::kNone));
    leaves |= bitsOf(hn::RebindMask(kLanes, leaf)) << i;
  }
  return leaves;
}

// Unit vectors from the body's point nearest to the middle of each box to that middle, in the
// boxes' frame, and the body's reach along them. A direction too short to normalise is not finite.
struct Directions {
  HWY_ALIGN float way[3][kWidth], reach[kWidth];
};

HWY_INLINE void directionsTo(const Probe& probe, const WideBox& box, Directions& directions) {
  const Floats zero = hn::Zero(kLanes), half = hn::Set(kLanes, 0.5F);
  const auto set = [](float x) { return hn::Set(kLanes, x); };
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
    const Floats scale = hn::Div(
        set(1.0F), hn::Sqrt(hn::IfThenElseZero(hn::Gt(squared, set(kLeastWaySquared)), squared)));
    hn::Store(hn::Mul(x, scale), kLanes, directions.way[0] + i);
    hn::Store(hn::Mul(y, scale), kLanes, directions.way[1] + i);
    hn::Store(hn::Mul(z, scale), kLanes, directions.way[2] + i);
    hn::Store(hn::Mul(along_way, scale), kLanes, directions.reach + i);
  }
}

// Tightens the bounds of open leaves by their vertices. The body, a box along the probe's axes, is
// convex, so none of its points is farther along the direction to a leaf than its nearest point.
// The leaf's least vertex along that direction, minus that point, is a lower bound on the
// separation.
void leafBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                const DeformTree::Node& node, const WideBox& box, float bar, WideBounds& bounds) {
  const unsigned leaves = bounds.open & leafColumns(node);
  if (leaves == 0) return;
  // Prefetches the numbers of the leaves' vertices, which are read below.
  for (unsigned left = leaves; left != 0; left &= left - 1) {
    const auto column = static_cast<std::size_t>(std::countr_zero(left));
    const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(node.child[column]));
    hwy::Prefetch(tree.leafVertices().data() + leaf.vertex_begin);
  }
  Directions directions;
  directionsTo(probe, box, directions);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  HWY_ALIGN double least[kWidth];
  std::fill_n(least, kWidth, unknown);
  for (unsigned left = leaves; left != 0; left &= left - 1) {
    const auto column = static_cast<std::size_t>(std::countr_zero(left));
    const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(node.child[column]));
    const double n[3] = {static_cast<double>(directions.way[0][column]),
                         static_cast<double>(directions.way[1][column]),
                         static_cast<double>(directions.way[2][column])};
    double lowest = 0;
    const bool finite =
        leastOf(n, vertices, tree.leafVertices().data() + leaf.vertex_begin,
                static_cast<std::size_t>(leaf.vertex_end - leaf.vertex_begin), lowest);
    if (finite) least[column] = lowest;
  }
  const Doubles grown =
      hn::Set(kDoubles, static_cast<double>(probe.radius) + static_cast<double>(probe.slack));
  for (std::size_t i = 0; i < kWidth; i += kDoubleLanes) {
    const hn::Rebind<float, decltype(kDoubles)> singles;
    const Doubles along = hn::Load(kDoubles, least + i);
    Doubles lower =
        hn::Sub(along, hn::PromoteTo(kDoubles, hn::Load(singles, directions.reach + i)));
    lower = hn::Sub(
        lower, hn::Add(hn::Mul(hn::Abs(lower), hn::Set(kDoubles, 2 * kRotationTolerance)), grown));
    lower = hn::Sub(lower, hn::Mul(hn::Abs(lower), hn::Set(kDoubles, 0x1p-23)));
    // NaN means that no bound is known; it compares as not greater on every instruction set.
    const auto found = hn::DemoteTo(singles, lower), before = hn::Load(singles, bounds.lower + i);
    hn::Store(hn::IfThenElse(hn::Gt(found, before), found, before), singles, bounds.lower + i);
  }
  openColumns(bar, bounds);
}

void childBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                 std::span<const std::int32_t> nodes, const WideBox* const* boxes, float bar,
                 WideBounds* bounds) {
  bar = std::min(bar, std::numeric_limits<float>::max());  // empty columns stay above it
  // Two loops: the first has no data-dependent branch, so the processor overlaps its iterations.
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

const ProbeKernels* probeKernelsOfTarget() {
  static constexpr ProbeKernels kKernels = {childBounds, triangleBounds, leastAlong};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(probeKernelsOfTarget);

const ProbeKernels& probeKernels() { return *HWY_DYNAMIC_DISPATCH(probeKernelsOfTarget)(); }

}  // namespace leeway::collision
#endif
