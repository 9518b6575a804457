// Private to collision/: boxes of vertices of a deforming mesh. Included once for each of Highway's
// targets, so it has no #pragma once.

#if defined(LEEWAY_COLLISION_DEFORM_VERTEX_BOXES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_DEFORM_VERTEX_BOXES_INL_H
#undef LEEWAY_COLLISION_DEFORM_VERTEX_BOXES_INL_H
#else
#define LEEWAY_COLLISION_DEFORM_VERTEX_BOXES_INL_H
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "collision/deform/tree/deform_tree.h"
#include "collision/deform/tree/node_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kParts = 4 / kDoubleLanes;  // vectors a vertex

// Whether every lane of x is finite: x - x is 0 for finite x only.
template <class D, class V>
HWY_INLINE bool isFinite(D d, V x) {
  return hn::AllTrue(d, hn::Eq(hn::Sub(x, x), hn::Zero(d)));
}

// The box of vertices, in double. Minimum and maximum are exact, so neither the order of the
// vertices nor the number of lanes changes the result.
struct Extremes {
  Doubles low[kParts], high[kParts];
  Doubles sum[kParts];  // not finite if a vertex is not finite

  // The empty box.
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
  // Only records whether the vertex is finite.
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

// A bound on the rounding error of x, the float nearest to some number. The error is half a unit in
// the last place; 2^-23 |x| is at least one unit, and 2^-126 covers subnormal x.
template <class D, class V>
HWY_INLINE V doubtOf(D d, V x) {
  return hn::Add(hn::Mul(hn::Abs(x), hn::Set(d, 0x1p-23F)), hn::Set(d, 0x1p-126F));
}

// A box in single precision, rounded outwards; x, y, z and one more number each.
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

HWY_INLINE void putColumn(const Extremes& e, WideBox& box, std::size_t column) {
  HWY_ALIGN float l[4], h[4];
  outwards(kDoubles, e.low, e.high, l, h);
  for (int k = 0; k < 3; ++k) {
    box.low[k][column] = l[k];
    box.high[k][column] = h[k];
  }
}

// The box of some vertices, at least one.
HWY_INLINE Extremes boxOf(const Eigen::Vector3d* vertices, const std::int32_t* v,
                          const std::int32_t* end) {
  Extremes e(at(vertices, *v));
  if (end - v < 32) {
    for (++v; v != end; ++v) e.add(at(vertices, *v));
    return e;
  }
  Extremes other = e;  // two independent chains of operations
  for (++v; end - v >= 2; v += 2) {
    e.add(at(vertices, v[0]));
    other.add(at(vertices, v[1]));
  }
  if (v != end) e.add(at(vertices, *v));
  e.add(other);
  return e;
}

void fillColumn(WideBox& box, std::size_t column, float low, float high) {
  for (int k = 0; k < 3; ++k) {
    box.low[k][column] = low;
    box.high[k][column] = high;
  }
}

// The box of vertices that are read four consecutive ones at a time: 12 doubles x, y, z, x, ...
// fill three, six or twelve vectors. Three vectors hold one vertex for each vector lane.
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
  Third first, second, last;  // not an array, so that these stay in registers

  HWY_INLINE FourExtremes() = default;
  HWY_INLINE void add(const double* v) {
    for (std::size_t part = 0; part < kParts; ++part, v += 3 * kDoubleLanes) {
      first.add(v);
      second.add(v + kDoubleLanes);
      last.add(v + 2 * kDoubleLanes);
    }
  }
  // Stores the box, and loads it again; the sums, which detect numbers that are not finite,
  // continue.
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
  // The box of all vertices and of those of `e`. It is written number by number, because a vector
  // load across two that were just stored would wait for both.
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

// Adds the fours begin .. end - 1. Prefetching kAhead fours early saves a third of the time. An
// update continues with the next branch's fours and reads far ahead; a query seldom passes the end
// of its node.
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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#endif
