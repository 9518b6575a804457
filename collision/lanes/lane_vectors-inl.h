// Vectors and frames of LaneSweep's kernels, one interval in each lane.
// Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_LANE_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_LANE_VECTORS_INL_H
#undef LEEWAY_COLLISION_LANE_VECTORS_INL_H
#else
#define LEEWAY_COLLISION_LANE_VECTORS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "collision/lanes/lane_sweep_impl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kLanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using Sweep = LaneSweepKernel::Sweep;
using Scratch = LaneSweepKernel::Scratch;
using Placed = Scratch::Placed;
constexpr std::uint32_t kAll = (1U << kLanes) - 1;

/// Bit i is set if lane i of the mask is set.
HWY_INLINE std::uint32_t bitsOf(D d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  const std::uint32_t all = (1U << hn::Lanes(d)) - 1;
  return (bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8U) & all;
}

/// Tests one box for each lane, starting at box `i`; returns a bit for each box that is near.
HWY_INLINE std::uint32_t nearBoxes(const float* low, const float* high,
                                   const ObstacleBoxes::Level& boxes, std::size_t i) {
  const D d;
  M apart = hn::Lt(hn::Set(d, high[0]), hn::LoadU(d, boxes.low[0].data() + i));
  for (int k = 0; k < 3; ++k) {
    if (k > 0)
      apart = hn::Or(apart, hn::Lt(hn::Set(d, high[k]), hn::LoadU(d, boxes.low[k].data() + i)));
    apart = hn::Or(apart, hn::Gt(hn::Set(d, low[k]), hn::LoadU(d, boxes.high[k].data() + i)));
  }
  return bitsOf(d, hn::Not(apart));
}

/// A vector in each lane.
struct V3 {
  V x, y, z;
};

HWY_INLINE V dot(const V3& a, const V3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE V3 difference(const V3& a, const V3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE V3 load(D d, const LaneValues* v, std::size_t at) {
  return {hn::Load(d, v[0].at + at), hn::Load(d, v[1].at + at), hn::Load(d, v[2].at + at)};
}
HWY_INLINE void store(D d, const V3& v, LaneValues* out, std::size_t at) {
  hn::Store(v.x, d, out[0].at + at);
  hn::Store(v.y, d, out[1].at + at);
  hn::Store(v.z, d, out[2].at + at);
}
HWY_INLINE V3 broadcast(D d, const float* v) {
  return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

/// R p: a point of a frame, relative to the frame's origin, in the world's axes.
HWY_INLINE V3 armOf(D d, const LaneFrame& frame, const V3& point, std::size_t at) {
  const auto row = [&](std::size_t i) {
    return dot({hn::Load(d, frame.rotation[i].at + at), hn::Load(d, frame.rotation[3 + i].at + at),
                hn::Load(d, frame.rotation[6 + i].at + at)},
               point);
  };
  return {row(0), row(1), row(2)};
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
