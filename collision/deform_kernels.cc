#include "collision/deform_kernels.h"

#include <cmath>
#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/deform_kernels.cc"
#include "collision/simd/targets.h"
//
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Four doubles (x, y, z and what comes behind them) in one vector, or in two or four.
const hn::CappedTag<double, 4> kDoubles;
using Doubles = hn::Vec<decltype(kDoubles)>;
constexpr std::size_t kDoubleLanes = hn::MaxLanes(decltype(kDoubles)());
constexpr std::size_t kParts = 4 / kDoubleLanes;
// Eight floats, or a part of them.
const hn::CappedTag<float, kWidth> kLanes;
using Floats = hn::Vec<decltype(kLanes)>;
constexpr std::size_t kStep = hn::MaxLanes(decltype(kLanes)());

// The box of vertices, in double. Minimum and maximum are exact, so that the order of vertices and
// the number of lanes do not show.
struct Extremes {
  Doubles low[kParts], high[kParts];
  Doubles spoiled[kParts];  // NaN when a vertex is not finite, else 0

  HWY_INLINE explicit Extremes(const double* v) {
    for (std::size_t i = 0; i < kParts; ++i) {
      low[i] = high[i] = hn::LoadU(kDoubles, v + kDoubleLanes * i);
      spoiled[i] = hn::Sub(low[i], low[i]);
    }
  }
  HWY_INLINE void add(const double* v) {
    for (std::size_t i = 0; i < kParts; ++i) {
      const Doubles p = hn::LoadU(kDoubles, v + kDoubleLanes * i);
      low[i] = hn::Min(p, low[i]);
      high[i] = hn::Max(p, high[i]);
      spoiled[i] = hn::Add(spoiled[i], hn::Sub(p, p));
    }
  }
  HWY_INLINE bool finite() const {
    bool all = true;
    for (std::size_t i = 0; i < kParts; ++i)
      all = all && hn::AllTrue(kDoubles, hn::Eq(spoiled[i], hn::Zero(kDoubles)));
    return all;
  }
};

// Single precision, outwards: to nearest is off by half a unit in the last place; 2^-23 |x| is one
// unit at least, and what is below the normal numbers is covered by their least.
template <class D>
HWY_INLINE void outwards(D d, const Doubles* low, const Doubles* high, float* l, float* h) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    const hn::Rebind<float, D> four;
    const auto doubt = [&](auto x) {
      return hn::Add(hn::Mul(hn::Abs(x), hn::Set(four, 0x1p-23F)), hn::Set(four, 0x1p-126F));
    };
    const auto below = hn::DemoteTo(four, low[0]), above = hn::DemoteTo(four, high[0]);
    hn::StoreU(hn::Sub(below, doubt(below)), four, l);
    hn::StoreU(hn::Add(above, doubt(above)), four, h);
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

const double* at(const Eigen::Vector3d* vertices, std::int32_t i) {
  return vertices->data() + 3 * static_cast<std::ptrdiff_t>(i);
}

HWY_INLINE Extremes boxOf(const Eigen::Vector3d* vertices, const std::int32_t* v,
                          const std::int32_t* end) {
  Extremes e(at(vertices, *v));
  for (++v; v != end; ++v) e.add(at(vertices, *v));
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

bool refit(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
           std::int32_t end, WideBox* boxes) {
  const std::int32_t* leaf_vertices = tree.leafVertices().data();
  bool finite = true;
  for (std::int32_t id = end - 1; id >= begin; --id) {
    const DeformTree::Node& node = tree.node(id);
    WideBox& box = boxes[id];
    for (std::size_t lane = 0; lane < kWidth; ++lane) {
      const std::int32_t child = node.child[lane];
      if (child >= 0) continue;
      if (child == DeformTree::kNone) {
        for (int k = 0; k < 3; ++k) {
          box.low[k][lane] = std::numeric_limits<float>::infinity();
          box.high[k][lane] = -std::numeric_limits<float>::infinity();
        }
        continue;
      }
      const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(child));
      const Extremes e =
          boxOf(vertices, leaf_vertices + leaf.vertex_begin, leaf_vertices + leaf.vertex_end);
      finite &= e.finite();
      putLane(e, box, lane);
    }
    const DeformTree::Up& up = tree.up(id);
    if (up.parent >= begin) unite(box, boxes[up.parent], static_cast<std::size_t>(up.lane));
  }
  return finite;
}

bool branches(const DeformTree& tree, const Eigen::Vector3d* vertices, WideBox* boxes) {
  bool finite = true;
  const DeformTree::Run* runs = tree.runs().data();
  for (const DeformTree::Branch& branch : tree.branches()) {
    const double* first = at(vertices, runs[branch.run_begin].begin);
    Extremes even(first), odd(first);  // two chains of dependent operations
    for (std::int32_t r = branch.run_begin; r < branch.run_end; ++r) {
      const double* v = at(vertices, runs[r].begin);
      const double* end = v + 3 * static_cast<std::ptrdiff_t>(runs[r].count);
      for (; v + 3 < end; v += 6) {
        even.add(v);
        odd.add(v + 3);
      }
      if (v < end) even.add(v);
    }
    for (std::size_t i = 0; i < kParts; ++i) {
      even.low[i] = hn::Min(even.low[i], odd.low[i]);
      even.high[i] = hn::Max(even.high[i], odd.high[i]);
    }
    finite = finite && even.finite() && odd.finite();
    const DeformTree::Up& up = tree.up(branch.node_begin);
    putLane(even, boxes[up.parent], static_cast<std::size_t>(up.lane));
  }
  return finite;
}

void fromVertices(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t node,
                  WideBox& box) {
  box.clear();
  for (std::size_t lane = 0; lane < kWidth; ++lane) {
    const std::span<const std::int32_t> below = tree.vertices(node, static_cast<int>(lane));
    if (below.empty()) break;
    const Extremes e = boxOf(vertices, below.data(), below.data() + below.size());
    if (e.finite()) {
      putLane(e, box, lane);
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      box.low[k][lane] = -std::numeric_limits<float>::max();
      box.high[k][lane] = std::numeric_limits<float>::max();
    }
  }
}

void triangles(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
               std::int32_t end, WideBox& box) {
  box.clear();
  for (std::int32_t slot = begin; slot < end; ++slot) {
    const DeformTree::Triangle& t = tree.corners(slot);
    const Extremes e = boxOf(vertices, t.data(), t.data() + 3);
    putLane(e, box, static_cast<std::size_t>(slot - begin));
  }
}

bool bound(const Eigen::Vector3d* vertices, std::size_t count, double limit, Eigen::Vector3d& low,
           Eigen::Vector3d& high) {
  const double* v = vertices->data();
  Extremes even(v), odd(v);
  std::size_t i = 1;
  for (; i + 1 < count; i += 2) {
    even.add(v + 3 * i);
    odd.add(v + 3 * (i + 1));
  }
  if (i < count) even.add(v + 3 * i);
  bool good = even.finite() && odd.finite();
  for (std::size_t k = 0; k < kParts; ++k) {
    HWY_ALIGN double l[4], h[4];
    hn::Store(hn::Min(even.low[k], odd.low[k]), kDoubles, l);
    hn::Store(hn::Max(even.high[k], odd.high[k]), kDoubles, h);
    for (std::size_t j = 0; j < kDoubleLanes; ++j) {
      const std::size_t axis = kDoubleLanes * k + j;
      if (axis > 2) continue;
      low[static_cast<Eigen::Index>(axis)] = l[j];
      high[static_cast<Eigen::Index>(axis)] = h[j];
      good = good && l[j] >= -limit && h[j] <= limit;
    }
  }
  return good;
}

void lowerBounds(const Probe& probe, const WideBox& box, Bounds& bounds) {
  const Floats zero = hn::Zero(kLanes), half = hn::Set(kLanes, 0.5F);
  const auto set = [](float x) { return hn::Set(kLanes, x); };
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    Floats middle[3], size[3], low_x = zero, high_x = zero;
    Floats squared = zero, deepest = set(-std::numeric_limits<float>::infinity());
    for (int k = 0; k < 3; ++k) {
      const Floats low = hn::Load(kLanes, box.low[k] + i), high = hn::Load(kLanes, box.high[k] + i);
      if (k == 0) {
        low_x = low;
        high_x = high;
      }
      middle[k] = hn::Mul(hn::Add(low, high), half);
      size[k] = hn::Mul(hn::Sub(high, low), half);
      const Floats gap =
          hn::Max(hn::Sub(low, set(probe.high[k])), hn::Sub(set(probe.low[k]), high));
      deepest = hn::Max(deepest, gap);
      const Floats outside = hn::Max(gap, zero);
      squared = hn::Add(squared, hn::Mul(outside, outside));
    }
    const auto along = [&](const float* n, Floats& center, Floats& reach) {
      center = reach = zero;
      for (int k = 0; k < 3; ++k) {
        center = hn::Add(center, hn::Mul(set(n[k]), middle[k]));
        reach = hn::Add(reach, hn::Mul(set(std::abs(n[k])), size[k]));
      }
    };
    Floats squared_axes = zero, center = zero, reach = zero;
    for (int j = 0; j < 3; ++j) {
      along(probe.axis[j], center, reach);
      const Floats gap = hn::Sub(hn::Max(hn::Sub(center, set(probe.axis_high[j])),
                                         hn::Sub(set(probe.axis_low[j]), center)),
                                 reach);
      deepest = hn::Max(deepest, gap);
      const Floats outside = hn::Max(gap, zero);
      squared_axes = hn::Add(squared_axes, hn::Mul(outside, outside));
    }
    // Axes that depart from a rotation by 1e-6 make distances along them too large by half of that.
    Floats lower = hn::Mul(hn::Sqrt(hn::Max(squared, squared_axes)), set(1 - 1e-6F));
    lower = hn::IfThenElse(hn::Gt(lower, zero), lower, deepest);
    lower = hn::Sub(hn::Sub(lower, set(probe.radius)), set(probe.slack));
    lower =
        hn::IfThenElse(hn::Le(low_x, high_x), lower, set(std::numeric_limits<float>::infinity()));
    hn::Store(lower, kLanes, bounds.lower + i);
  }
}

// The plane across the way from the body's point that is nearest to the middle of the triangle: as
// good as exact when the triangle is small beside the distance, where its box is not. In
// coordinates along the probe's own axes, in which the body is a box.
void triangleBounds(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                    std::int32_t begin, std::int32_t end, Bounds& bounds) {
  HWY_ALIGN float corner[3][3][kWidth] = {};  // corner, axis, triangle
  for (std::int32_t slot = begin; slot < end; ++slot) {
    const DeformTree::Triangle& t = tree.corners(slot);
    const std::size_t lane = static_cast<std::size_t>(slot - begin);
    for (std::size_t c = 0; c < 3; ++c) {
      const double* v = at(vertices, t[c]);
      for (int k = 0; k < 3; ++k) corner[c][k][lane] = static_cast<float>(v[k]);
    }
  }
  const auto set = [](float x) { return hn::Set(kLanes, x); };
  const Floats third = set(1.0F / 3), zero = hn::Zero(kLanes);
  for (std::size_t i = 0; i < kWidth; i += kStep) {
    Floats p[3][3], outside = zero;  // corner, axis; distance of the boxes, squared
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < 3; ++c) p[c][k] = hn::Load(kLanes, corner[c][k] + i);
      const Floats low = hn::Min(hn::Min(p[0][k], p[1][k]), p[2][k]),
                   high = hn::Max(hn::Max(p[0][k], p[1][k]), p[2][k]);
      const Floats gap = hn::Max(
          hn::Max(hn::Sub(low, set(probe.high[k])), hn::Sub(set(probe.low[k]), high)), zero);
      outside = hn::Add(outside, hn::Mul(gap, gap));
    }
    Floats along[3][3], way[3], nearest[3], squared = zero;
    for (int j = 0; j < 3; ++j) {
      for (int c = 0; c < 3; ++c) {
        along[c][j] = hn::Add(hn::Add(hn::Mul(set(probe.axis[j][0]), p[c][0]),
                                      hn::Mul(set(probe.axis[j][1]), p[c][1])),
                              hn::Mul(set(probe.axis[j][2]), p[c][2]));
      }
      const Floats middle = hn::Mul(hn::Add(hn::Add(along[0][j], along[1][j]), along[2][j]), third);
      nearest[j] = hn::Min(hn::Max(middle, set(probe.axis_low[j])), set(probe.axis_high[j]));
      way[j] = hn::Sub(middle, nearest[j]);
      squared = hn::Add(squared, hn::Mul(way[j], way[j]));
    }
    Floats least = set(std::numeric_limits<float>::infinity());
    for (int c = 0; c < 3; ++c) {
      Floats reach = zero;
      for (int j = 0; j < 3; ++j)
        reach = hn::Add(reach, hn::Mul(way[j], hn::Sub(along[c][j], nearest[j])));
      least = hn::Min(least, reach);
    }
    const auto usable = hn::Gt(squared, set(1e-30F));
    const Floats safe = hn::IfThenElse(usable, squared, set(1.0F));
    Floats lower = hn::Div(least, hn::Sqrt(safe));
    // Axes that depart from a rotation by 1e-6 make the way longer or shorter than its square says.
    lower = hn::Sub(lower, hn::Mul(hn::Abs(lower), set(2e-6F)));
    // Boxes that meet say nothing of how deep.
    const Floats unknown = set(-std::numeric_limits<float>::infinity());
    const Floats by_box = hn::IfThenElse(hn::Gt(outside, zero), hn::Sqrt(outside), unknown);
    lower = hn::Max(hn::IfThenElse(usable, lower, unknown), by_box);
    hn::Store(hn::Sub(hn::Sub(lower, set(probe.radius)), set(probe.slack)), kLanes,
              bounds.lower + i);
  }
}

}  // namespace

const DeformKernels* kernels() {
  static constexpr DeformKernels kKernels = {refit,          branches, fromVertices, triangles,
                                             triangleBounds, bound,    lowerBounds};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(kernels);

const DeformKernels& deformKernels() {
  static const DeformKernels& chosen = *HWY_DYNAMIC_DISPATCH(kernels)();
  return chosen;
}

}  // namespace leeway::collision
#endif
