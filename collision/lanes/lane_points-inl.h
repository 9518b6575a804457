// Points of a piece against an obstacle: each point inside proves a contact.
// Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_LANE_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_LANE_POINTS_INL_H
#undef LEEWAY_COLLISION_LANE_POINTS_INL_H
#else
#define LEEWAY_COLLISION_LANE_POINTS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "collision/lanes/lane_balls-inl.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Point i in every lane.
HWY_INLINE V3 pointOf(D d, const Sweep& s, int i) {
  const auto k = static_cast<std::size_t>(i);
  return {hn::Set(d, s.point[0][k]), hn::Set(d, s.point[1][k]), hn::Set(d, s.point[2][k])};
}

/// Finds the first of the points [begin, end) that is within `below` of the obstacle's core in the
/// middle of one of `lanes`. Returns the lanes in which it is; `point` becomes its index, or `end`
/// if there is none.
HWY_INLINE std::uint32_t contactOfPoints(const Sweep& s, const LaneFrame& frame,
                                         const Sweep::Obstacle& o, std::int32_t begin,
                                         std::int32_t end, float below, std::uint32_t lanes,
                                         std::int32_t& point) {
  const D d;
  for (std::int32_t i = begin; i < end; ++i) {
    const V3 v = pointOf(d, s, i);
    std::uint32_t found = 0;
    for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
      const V3 arm = armOf(d, frame, v, at), origin = load(d, frame.origin, at);
      const V3 center = {hn::Add(origin.x, arm.x), hn::Add(origin.y, arm.y),
                         hn::Add(origin.z, arm.z)};
      const Gap gap = gapOf<true>(d, o, center, center);
      const V distance = hn::Add(hn::Sqrt(dot(gap.outside, gap.outside)), gap.depth);
      found |= bitsOf(d, hn::Le(distance, hn::Set(d, below))) << at;
    }
    if ((found & lanes) == 0) continue;
    point = i;
    return found & lanes;
  }
  point = end;
  return 0;
}

/// contactOfPoints() for a pair: lanes in which a point of A proves a contact. `point` is set if
/// the pair's points can prove one.
HWY_INLINE std::uint32_t pointsInside(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                                      std::int32_t begin, std::int32_t end, std::uint32_t lanes,
                                      std::int32_t& point) {
  const Sweep& s = kernel.sweep;
  const Sweep::LanePiece& a = s.pieces[static_cast<std::size_t>(pair.a)];
  if (pair.pieces || a.frame < 0 || a.own < 0) return 0;
  const Sweep::Obstacle& o = kernel.obstacle(pair);
  if (!o.exact) return 0;
  const float below = pair.contact_below - kernel.slack - a.own + o.radius;
  const std::uint32_t met =
      contactOfPoints(s, kernel.frames[a.frame], o, begin, end, below, lanes, point);
  kernel.scratch.work.add((point - begin + 1) * kLanePointWork);
  return met;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
