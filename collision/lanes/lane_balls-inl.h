// Balls against obstacles and against each other, one interval in each lane.
//
// clang-format off
// Rounding, with u = 2^-24 and s the sum of the magnitudes at play (how far a ball's centre can be
// from the world's origin, the obstacle's centre, half extents and radius):
//   centre in the obstacle's axes:  difference                            u s
//                                   product with rounded entries          < 5 u s  (3 u + u a row)
//                                   absolute value, less half extents,
//                                   which are rounded themselves          3 u s
//                                   a coordinate                          < 10 u s
//   in length                                                             18 u s
//   distance                                                              3 u s
//   plane's part of the way, whose length is at most s for an interval
//   of a sixteenth of an edge                                             6 u s
//   all together                                                          < 32 u s
// 64 u s is taken (kLaneSweepRounding).
// clang-format on
//
// For a computed centre, the plane is a plane of the obstacle in spite of rounding of its
// direction. A box's plane is spanned by coordinates beyond its faces, each accurate to u of
// itself; a cylinder's radial part errs by u s, which is included above.
//
// Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_LANE_BALLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_LANE_BALLS_INL_H
#undef LEEWAY_COLLISION_LANE_BALLS_INL_H
#else
#define LEEWAY_COLLISION_LANE_BALLS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Computes the ball's centre in the middle of each interval and (unless kStill) its displacement
/// over half an interval.
template <bool kStill>
HWY_INLINE void placeBall(const LaneFrame& frame, const float* center, Placed& placed) {
  const D d;
  const V3 c = broadcast(d, center);
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const V3 arm = armOf(d, frame, c, at);
    const V3 o = load(d, frame.origin, at);
    store(d, {hn::Add(o.x, arm.x), hn::Add(o.y, arm.y), hn::Add(o.z, arm.z)}, placed.center, at);
    if (kStill) continue;
    const V3 t = cross(load(d, frame.turn, at), arm), s = load(d, frame.slide, at);
    store(d, {hn::Add(s.x, t.x), hn::Add(s.y, t.y), hn::Add(s.z, t.z)}, placed.way, at);
  }
}

/// The vector from the core of an obstacle (the obstacle without its radius) to a ball's centre, in
/// the obstacle's axes. `outside` is 0 inside, otherwise as long as the distance; `depth` is
/// negative inside, otherwise 0; `way` is the centre's displacement.
struct Gap {
  V3 outside, way;
  V depth;
};

/// Gap::outside and `depth` of a point, relative to the obstacle's centre and in its axes.
HWY_INLINE V3 outsideOf(D d, const Sweep::Core& o, const V3& p, V& depth) {
  const V zero = hn::Zero(d);
  if (o.kind == Sweep::Kind::kHalfSpace) {
    depth = hn::Min(p.z, zero);
    return {zero, zero, hn::Max(p.z, zero)};
  }
  const V ez = hn::Sub(hn::Abs(p.z), hn::Set(d, o.half[2]));
  if (o.kind == Sweep::Kind::kBox) {
    const V ex = hn::Sub(hn::Abs(p.x), hn::Set(d, o.half[0])),
            ey = hn::Sub(hn::Abs(p.y), hn::Set(d, o.half[1]));
    depth = hn::Min(hn::Max(ex, hn::Max(ey, ez)), zero);
    return {hn::CopySign(hn::Max(ex, zero), p.x), hn::CopySign(hn::Max(ey, zero), p.y),
            hn::CopySign(hn::Max(ez, zero), p.z)};
  }
  const V across = hn::Sqrt(hn::Add(hn::Mul(p.x, p.x), hn::Mul(p.y, p.y)));
  const V er = hn::Sub(across, hn::Set(d, o.half[0]));
  const V share =
      hn::Div(hn::Max(er, zero), hn::Max(across, hn::Set(d, kLaneInsteadOfZero)));  // 0 on the axis
  depth = hn::Min(hn::Max(er, ez), zero);
  return {hn::Mul(p.x, share), hn::Mul(p.y, share), hn::CopySign(hn::Max(ez, zero), p.z)};
}

/// Support of the core along a direction in the obstacle's axes, relative to its centre.
HWY_INLINE V supportOf(D d, const Sweep::Core& o, const V3& n) {
  if (o.kind == Sweep::Kind::kHalfSpace) return hn::Zero(d);  // directions are z
  const V z = hn::Mul(hn::Abs(n.z), hn::Set(d, o.half[2]));
  if (o.kind == Sweep::Kind::kCylinder) {
    const V across = hn::Sqrt(hn::Add(hn::Mul(n.x, n.x), hn::Mul(n.y, n.y)));
    return hn::Add(hn::Mul(across, hn::Set(d, o.half[0])), z);
  }
  return hn::Add(hn::Add(hn::Mul(hn::Abs(n.x), hn::Set(d, o.half[0])),
                         hn::Mul(hn::Abs(n.y), hn::Set(d, o.half[1]))),
                 z);
}

template <bool kStill>
HWY_INLINE Gap gapOf(D d, const Sweep::Core& o, const V3& center, const V3& way) {
  V3 p = difference(center, broadcast(d, o.center));
  V3 w = kStill ? p : way;
  if (!o.aligned) {
    const V3 x = broadcast(d, o.rotation), y = broadcast(d, o.rotation + 3),
             z = broadcast(d, o.rotation + 6);
    p = {dot(x, p), dot(y, p), dot(z, p)};
    if (!kStill) w = {dot(x, w), dot(y, w), dot(z, w)};
  }
  Gap gap;
  gap.way = w;
  gap.outside = outsideOf(d, o, p, gap.depth);
  return gap;
}

template <bool kStill>
HWY_INLINE Gap gapTo(D d, const Sweep::Core& o, const Placed& ball, std::size_t at) {
  const V3 center = load(d, ball.center, at);
  return gapOf<kStill>(d, o, center, kStill ? center : load(d, ball.way, at));
}

/// Lanes of `lanes` in which the ball's capsule is not proven to stay farther than `above` from the
/// core. `key`, if not null, becomes the least signed distance of the ball's centre in any lane.
template <bool kStill>
HWY_INLINE std::uint32_t openToObstacle(const Sweep::Core& o, const Placed& ball, float above,
                                        std::uint32_t lanes, float* key = nullptr) {
  const D d;
  const V bar = hn::Set(d, above);
  std::uint32_t open = 0;
  V least = hn::Set(d, 1e30f);
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const Gap gap = gapTo<kStill>(d, o, ball, at);
    const V squared = dot(gap.outside, gap.outside), distance = hn::Sqrt(squared);
    // distance - |n . way| > bar with n = outside / distance; inside, 0 > 0 fails.
    const V lower = kStill ? squared : hn::Sub(squared, hn::Abs(dot(gap.outside, gap.way)));
    open |= bitsOf(d, hn::Not(hn::And(hn::Gt(lower, hn::Mul(bar, distance)),
                                      hn::Gt(distance, hn::Zero(d)))))
            << at;
    if (key != nullptr) least = hn::Min(least, hn::Add(distance, gap.depth));
  }
  if (key != nullptr) *key = hn::GetLane(hn::MinOfLanes(d, least));
  return open & lanes;
}

/// Lanes in which the ball's centre, in the middle of the interval, is within `below` of the core.
HWY_INLINE std::uint32_t contactWithObstacle(const Sweep::Core& o, const Placed& ball,
                                             float below) {
  const D d;
  std::uint32_t found = 0;
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const Gap gap = gapTo<true>(d, o, ball, at);
    const V distance = hn::Add(hn::Sqrt(dot(gap.outside, gap.outside)), gap.depth);
    found |= bitsOf(d, hn::Le(distance, hn::Set(d, below))) << at;
  }
  return found;
}

/// openToObstacle() for two balls, in the second ball's frame. The frame's rotation moves the first
/// ball across the line of their centres and therefore has no effect.
template <bool kStill>
HWY_INLINE std::uint32_t openToBall(const Placed& a, const Placed& b, float above,
                                    std::uint32_t lanes, float* key = nullptr) {
  const D d;
  const V bar = hn::Set(d, above);
  std::uint32_t open = 0;
  V least = hn::Set(d, 1e30f);
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const V3 gap = difference(load(d, a.center, at), load(d, b.center, at));
    const V squared = dot(gap, gap), distance = hn::Sqrt(squared);
    V lower = squared;
    if (!kStill) {
      lower =
          hn::Sub(squared, hn::Abs(dot(gap, difference(load(d, a.way, at), load(d, b.way, at)))));
    }
    open |= bitsOf(d, hn::Not(hn::And(hn::Gt(lower, hn::Mul(bar, distance)),
                                      hn::Gt(distance, hn::Zero(d)))))
            << at;
    if (key != nullptr) least = hn::Min(least, distance);
  }
  if (key != nullptr) *key = hn::GetLane(hn::MinOfLanes(d, least));
  return open & lanes;
}

/// Lanes in which two balls' centres are within `below` of each other in the middle of the
/// interval.
HWY_INLINE std::uint32_t contactWithBall(const Placed& a, const Placed& b, float below) {
  const D d;
  std::uint32_t found = 0;
  if (!(below >= 0)) return 0;
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const V3 gap = difference(load(d, a.center, at), load(d, b.center, at));
    found |= bitsOf(d, hn::Le(hn::Sqrt(dot(gap, gap)), hn::Set(d, below))) << at;
  }
  return found;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
