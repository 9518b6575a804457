// Separating planes against hulls of points, one interval in each lane.
//
// clang-format off
// A point v of A's frame moves over half an interval by
//   w = slide + turn x R v,
// and its path stays within `growth` of the segment o + R v -+ w. With m = n x turn,
//   n . (turn x R v) = m . R v,
// so the least n . x on the segments of all points is the lesser of two supports of A's points,
//   along R^T (n - m)  and  along R^T (n + m).
// Seen from B's frame the turn is the difference of both; the slide is the difference of the
// origins' slides, less B's turn of A's origin.
//
// Rounding, with u = 2^-24 and s the sum of the magnitudes at play:
//   differences of origins                u s
//   turned directions, in length          14 u (1 + |turn|)
//   products with points                  3 u
//   the points themselves                 u
//   all together                          < (32 + 17 |turn|) u s,  |turn| < 13 for 60 joints
// 256 u s is taken (4 kLaneSweepRounding). B's frame is within its slack of a rigid one, and its
// R^T R within twice that of 1: four slacks in place of two. The normal's length is within
// 61 kLaneRounding < 2^-11 of 1.
//
// Clusters. A cluster with centre c holds points v with |v - c| <= r, all as they are rounded.
//   a computed f . v errs by 3.1 u |f| |v|, so it is at least
//   the computed f . c  less  |f| (r + 3.1 u (2 |c| + r));
//   the computed |f| is within 3 u of |f|, or larger;
//   its product with a radius, and the difference, round by u each, of at most |f| (|c| + r).
// A radius of (r + 16 u (|c| + r)) (1 + 16 u) covers all of it. What is then added or subtracted is
// equal for the cluster and its points, and rounding is monotonic: as computed, no point of a
// cluster is lower than the cluster.
// clang-format on
//
// Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_LANE_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_LANE_PLANES_INL_H
#undef LEEWAY_COLLISION_LANE_PLANES_INL_H
#else
#define LEEWAY_COLLISION_LANE_PLANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "collision/lanes/lane_points-inl.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Work of a scan of points along a direction; most clusters are skipped as a whole.
HWY_INLINE std::int64_t workOf(const Sweep::LanePiece::Points& points) {
  const int clusters = points.clusters_end - points.clusters_begin;
  return kLanePointWork *
         (clusters == 0 ? points.end - points.begin : clusters + 3 * kClusterPoints);
}

/// A direction n relative to the points v of a moving frame (derived above): the least of n . (R v
/// -+ w) is the lesser of first . v - drift and second . v + drift.
template <bool kStill>
struct SweptDirection {
  V3 first, second;
  V drift;
  V doubt;  // 0, or NaN if any of them is NaN or infinite, because hn::Min() drops NaN on some
            // targets

  /// columns: of the frame's rotation; turn, slide: its motion over half an interval.
  HWY_INLINE SweptDirection(D d, const V3* columns, const V3& n, const V3& turn, const V3& slide) {
    const V3 back = {dot(columns[0], n), dot(columns[1], n), dot(columns[2], n)};
    first = second = back;
    drift = hn::Zero(d);
    doubt = doubtOf(first);
    if (kStill) return;
    const V3 m = cross(n, turn);
    const V3 way = {dot(columns[0], m), dot(columns[1], m), dot(columns[2], m)};
    first = difference(back, way);
    second = {hn::Add(back.x, way.x), hn::Add(back.y, way.y), hn::Add(back.z, way.z)};
    drift = dot(n, slide);
    // NaN in `second` comes from `way` or `back`, both of which are also in `first`.
    doubt = hn::Add(doubtOf(first), hn::Sub(drift, drift));
  }

 private:
  static HWY_INLINE V doubtOf(const V3& v) {
    const V sum = hn::Add(hn::Add(v.x, v.y), v.z);
    return hn::Sub(sum, sum);
  }
};

/// Lower bounds of a SweptDirection over clusters of points: at most the values computed for the
/// points of the cluster one by one.
template <bool kStill>
class ClusterBounds {
 public:
  HWY_INLINE ClusterBounds(D d, const SweptDirection<kStill>& swept)
      : swept_(swept), first_(lengthOf(d, swept.first)), second_(first_) {
    if (!kStill) second_ = lengthOf(d, swept.second);
  }

  HWY_INLINE V leastOf(D d, const Sweep::Cluster& cluster) const {
    const V3 center = broadcast(d, cluster.center);
    const V radius = hn::Set(d, cluster.radius);
    const V least =
        hn::Sub(hn::Sub(dot(swept_.first, center), hn::Mul(first_, radius)), swept_.drift);
    if (kStill) return least;
    return hn::Min(least, hn::Add(hn::Sub(dot(swept_.second, center), hn::Mul(second_, radius)),
                                  swept_.drift));
  }

 private:
  // Rounded up if the square underflows.
  static HWY_INLINE V lengthOf(D d, const V3& v) {
    return hn::Sqrt(hn::Add(dot(v, v), hn::Set(d, kLaneInsteadOfZero)));
  }

  const SweptDirection<kStill>& swept_;
  V first_, second_;
};

/// Lanes of `lanes` in which the plane does not separate B from the hull of A's `points` by the gap
/// that the pair requires.
template <bool kStill>
HWY_INLINE std::uint32_t notSeparatedByPoints(const LaneSweepKernel& kernel,
                                              const Sweep::Pair& pair,
                                              const Sweep::LanePiece::Points& points,
                                              const Scratch::Plane& plane, std::uint32_t lanes) {
  const D d;
  const Sweep& s = kernel.sweep;
  const Sweep::LanePiece& a = s.pieces[static_cast<std::size_t>(pair.a)];
  const LaneFrame& frame_a = kernel.frames[a.frame];
  const LaneFrame* frame_b =
      pair.pieces ? &kernel.frames[s.pieces[static_cast<std::size_t>(pair.b)].frame] : nullptr;
  const float growth = kStill ? 0 : kernel.growth[pair.motion];
  const float above =
      pair.plane_above + points.radius + growth + (pair.pieces ? 4 : 1) * kernel.slack;
  const V bar = hn::Set(d, plane.offset + above * kLaneNormalOutwards);
  kernel.scratch.work.add(kLanePlaneWork + workOf(points));
  std::uint32_t open = 0;
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    if ((lanes >> at & ((1U << hn::Lanes(d)) - 1)) == 0) continue;
    V3 n = broadcast(d, plane.normal), o = load(d, frame_a.origin, at), turn = n, slide = n;
    if (!kStill) turn = load(d, frame_a.turn, at), slide = load(d, frame_a.slide, at);
    if (frame_b != nullptr) {
      const V3 x = load(d, frame_b->rotation, at), y = load(d, frame_b->rotation + 3, at),
               z = load(d, frame_b->rotation + 6, at);
      n = {dot({x.x, y.x, z.x}, n), dot({x.y, y.y, z.y}, n), dot({x.z, y.z, z.z}, n)};
      o = difference(o, load(d, frame_b->origin, at));
      if (!kStill) {
        const V3 turn_b = load(d, frame_b->turn, at);
        turn = difference(turn, turn_b);
        slide = difference(difference(slide, load(d, frame_b->slide, at)), cross(turn_b, o));
      }
    }
    const V3 columns[3] = {load(d, frame_a.rotation, at), load(d, frame_a.rotation + 3, at),
                           load(d, frame_a.rotation + 6, at)};
    const SweptDirection<kStill> swept(d, columns, n, turn, slide);
    V low_first = hn::Set(d, 1e30f), low_second = low_first;
    const auto scan = [&](int begin, int end) HWY_ATTR {
      for (int i = begin; i < end; ++i) {
        const V3 v = pointOf(d, s, i);
        low_first = hn::Min(low_first, dot(swept.first, v));
        if (!kStill) low_second = hn::Min(low_second, dot(swept.second, v));
      }
    };
    const V from = hn::Add(dot(n, o), swept.doubt);
    if (points.clusters_begin == points.clusters_end) scan(points.begin, points.end);
    // A cluster above the bar is skipped, because each of its points would also be above it.
    const ClusterBounds<kStill> clusters(d, swept);
    for (int i = points.clusters_begin; i < points.clusters_end; ++i) {
      const Sweep::Cluster& cluster = s.clusters[static_cast<std::size_t>(i)];
      if (!hn::AllTrue(d, hn::Gt(hn::Add(from, clusters.leastOf(d, cluster)), bar)))
        scan(cluster.begin, cluster.end);
    }
    V low = hn::Sub(low_first, swept.drift);
    if (!kStill) low = hn::Min(low, hn::Add(low_second, swept.drift));
    // Lanes with NaN stay open.
    open |= bitsOf(d, hn::Not(hn::Gt(hn::Add(from, low), bar))) << at;
  }
  return open & lanes;
}

/// Lanes of `lanes` in which the plane does not separate the pair: by A's coarse points, then by
/// its fine points.
template <bool kStill>
HWY_INLINE std::uint32_t notSeparated(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                                      const Scratch::Plane& plane, std::uint32_t lanes) {
  const Sweep::LanePiece& a = kernel.sweep.pieces[static_cast<std::size_t>(pair.a)];
  lanes = notSeparatedByPoints<kStill>(kernel, pair, a.points, plane, lanes);
  if (lanes == 0 || a.fine.begin == a.points.begin) return lanes;
  return notSeparatedByPoints<kStill>(kernel, pair, a.fine, plane, lanes);
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
