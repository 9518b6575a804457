// Private to collision/: vertices and nodes of a deforming mesh, one in each vector lane. Included
// once for each of Highway's targets, so it has no #pragma once.

#if defined(LEEWAY_COLLISION_DEFORM_NODE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_DEFORM_NODE_LANES_INL_H
#undef LEEWAY_COLLISION_DEFORM_NODE_LANES_INL_H
#else
#define LEEWAY_COLLISION_DEFORM_NODE_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "collision/deform/tree/deform_tree.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Four doubles, x, y, z of a vertex and the number that follows, in one, two or four vectors.
const hn::CappedTag<double, 4> kDoubles;
using Doubles = hn::Vec<decltype(kDoubles)>;
constexpr std::size_t kDoubleLanes = hn::MaxLanes(decltype(kDoubles)());

// Eight floats, one for each child of a node, in one or more vectors.
const hn::CappedTag<float, kWidth> kLanes;
using Floats = hn::Vec<decltype(kLanes)>;
constexpr std::size_t kStep = hn::MaxLanes(decltype(kLanes)());
constexpr unsigned kStepBits = (1U << kStep) - 1;

// A bit for each lane of a mask.
template <class M>
HWY_INLINE unsigned bitsOf(M mask) {
  std::uint8_t bits[8] = {};  // as many as StoreMaskBits() may write
  hn::StoreMaskBits(kLanes, mask, bits);
  return bits[0] & kStepBits;
}

HWY_INLINE const double* at(const Eigen::Vector3d* vertices, std::int32_t i) {
  return vertices->data() + 3 * static_cast<std::ptrdiff_t>(i);
}

// Rounds a vertex and the number that follows to the nearest floats. `to` is aligned.
HWY_INLINE void putSingle(const double* from, float* to) {
  if constexpr (kDoubleLanes == 4) {
    const hn::Rebind<float, decltype(kDoubles)> four;
    hn::Store(hn::DemoteTo(four, hn::LoadU(kDoubles, from)), four, to);
  } else {
    for (int k = 0; k < 4; ++k) to[k] = static_cast<float>(from[k]);
  }
}

// The coordinates of one vertex for each vector lane. Reads four doubles of each vertex.
HWY_INLINE void loadVertices(const double* const* v, Doubles& x, Doubles& y, Doubles& z) {
#if HWY_TARGET == HWY_SCALAR
  x = hn::LoadU(kDoubles, v[0]);
  y = hn::LoadU(kDoubles, v[0] + 1);
  z = hn::LoadU(kDoubles, v[0] + 2);
#else
  const Doubles a = hn::LoadU(kDoubles, v[0]), b = hn::LoadU(kDoubles, v[1]);
  const Doubles xz_ab = hn::InterleaveLower(kDoubles, a, b),
                y_ab = hn::InterleaveUpper(kDoubles, a, b);
  if constexpr (kDoubleLanes == 2) {
    x = xz_ab;
    y = y_ab;
    z = hn::InterleaveLower(kDoubles, hn::LoadU(kDoubles, v[0] + 2), hn::LoadU(kDoubles, v[1] + 2));
  } else {
    const Doubles c = hn::LoadU(kDoubles, v[2]), d = hn::LoadU(kDoubles, v[3]);
    const Doubles xz_cd = hn::InterleaveLower(kDoubles, c, d);
    x = hn::ConcatLowerLower(kDoubles, xz_cd, xz_ab);
    y = hn::ConcatLowerLower(kDoubles, hn::InterleaveUpper(kDoubles, c, d), y_ab);
    z = hn::ConcatUpperUpper(kDoubles, xz_cd, xz_ab);
  }
#endif
}

// Coordinates of one vertex for each lane of a vector of D, which has as many lanes as Doubles or
// twice as many.
template <class D>
HWY_INLINE void loadMany([[maybe_unused]] D d, const double* const* v, hn::Vec<D>* p) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (hn::MaxLanes(D()) > kDoubleLanes) {
    static_assert(hn::MaxLanes(D()) == 2 * kDoubleLanes);
    Doubles low[3], high[3];
    loadVertices(v, low[0], low[1], low[2]);
    loadVertices(v + kDoubleLanes, high[0], high[1], high[2]);
    for (int k = 0; k < 3; ++k) p[k] = hn::Combine(d, high[k], low[k]);
    return;
  }
#endif
  if constexpr (hn::MaxLanes(D()) == kDoubleLanes) loadVertices(v, p[0], p[1], p[2]);
}

// The least scalar product of n and the vertices added so far.
class LeastAlong {
 public:
  HWY_INLINE explicit LeastAlong(const double* n)
      : n_x_(hn::Set(kDoubles, n[0])),
        n_y_(hn::Set(kDoubles, n[1])),
        n_z_(hn::Set(kDoubles, n[2])),
        lowest_(hn::Set(kDoubles, std::numeric_limits<double>::infinity())),
        doubt_(hn::Zero(kDoubles)) {}

  // Adds one vertex for each vector lane.
  HWY_INLINE void add(const double* const* from) {
    Doubles x, y, z;
    loadVertices(from, x, y, z);
    const Doubles along = hn::Add(hn::Add(hn::Mul(n_x_, x), hn::Mul(n_y_, y)), hn::Mul(n_z_, z));
    lowest_ = hn::Min(along, lowest_);
    doubt_ = hn::Add(doubt_, hn::Sub(along, along));  // 0 for finite numbers only
  }
  // Adds `count` vertices, at least one; the i-th is vertexOf(i).
  template <class VertexOf>
  HWY_INLINE void add(const Eigen::Vector3d* vertices, std::size_t count,
                      const VertexOf& vertexOf) {
    const double* from[kDoubleLanes];
    if (count < kDoubleLanes) {
      for (std::size_t k = 0; k < kDoubleLanes; ++k)
        from[k] = at(vertices, vertexOf(std::min(k, count - 1)));
      add(from);
      return;
    }
    // The last vector ends with the last vertex and may repeat some.
    const std::size_t last = count - kDoubleLanes;
    for (std::size_t i = 0;; i = std::min(i + kDoubleLanes, last)) {
      for (std::size_t k = 0; k < kDoubleLanes; ++k) from[k] = at(vertices, vertexOf(i + k));
      add(from);
      if (i == last) return;
    }
  }
  HWY_INLINE void add(const Eigen::Vector3d* vertices, const std::int32_t* v, std::size_t count) {
    add(vertices, count, [v](std::size_t i) { return v[i]; });
  }
  // Adding 0.0 turns -0 into +0, because which of the two a minimum picks depends on the lanes.
  HWY_INLINE double least() const { return hn::GetLane(hn::MinOfLanes(kDoubles, lowest_)) + 0.0; }
  // Whether all vertices are finite.
  HWY_INLINE bool isFinite() const {
    return hn::AllTrue(kDoubles, hn::Eq(doubt_, hn::Zero(kDoubles)));
  }

 private:
  Doubles n_x_, n_y_, n_z_, lowest_, doubt_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#endif
