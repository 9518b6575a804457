// The kernels of LaneSweep: balls against obstacles and balls, an interval a lane. One rounding an
// operation (no fused multiply and add), the same operations in every lane, and decisions by masks
// of all kLanes intervals, so that all instruction sets give the same answers.
//
// Rounding. Let u = 2^-24 and s the sum of the magnitudes at play (how far a ball's centre can be
// from the world's origin, the obstacle's centre, half extents and radius). A ball's centre in the
// obstacle's axes passes a difference (u s), a product with rounded entries (3 u + u per row: below
// 5 u s), absolute values and differences with half extents that are rounded themselves (3 u s):
// below 10 u s in each coordinate, 18 u s in length. Its distance adds 3 u, the plane's part of the
// way 6 u of a length that is at most s for an interval of a sixteenth of an edge: below 32 u s in
// all; 64 u s is taken (kLaneSweepRounding). Given a computed centre, the plane is a plane of the
// obstacle whatever rounding did to its direction: a box's is spanned by coordinates beyond its
// faces, each right to u of itself; a cylinder's radial part errs by u s, counted above.
//
// Planes. Over half an interval a point v of A's frame moves by w = slide + turn x R v, its path
// stays within `growth` of the segment o + R v -+ w, and n . (turn x R v) = (n x turn) . R v: the
// least n . x on the segments of all points is the lesser of two supports of A's points, along
// R^T (n - m) and R^T (n + m) with m = n x turn. Seen from B's frame, the turn is the difference of
// both, and the slide that of the origins less B's turn of A's origin. The differences of origins
// err by u s, the turned directions by 14 u (1 + |turn|) in length, products with points by 3 u,
// the points themselves by u: below (32 + 17 |turn|) u s, and |turn| is below 13 for 60 joints; 256
// u s is taken (four times kLaneSweepRounding). B's frame is within its slack of a rigid one, and
// its R^T R within twice that of 1: four slacks in place of two. The normal's length is within 61
// kLaneRounding < 2^-11 of 1.
//
// Planes of each lane's own have normals that are computed in the lane. In the obstacle's axes such
// a normal's support of the core is a sum of |n| times half extents, right to 6 u s; turned into
// the world the normal errs by 5 u, which moves what is between A's points and the obstacle's
// centre by 5 u s; two sums more: below 13 u s besides the above, one more kLaneSweepRounding.
//
// Clusters of points. A cluster with centre c holds points v with |v - c| <= r, all as they are
// rounded. A computed f . v errs by 3.1 u |f| |v|, so that it is at least the computed f . c less
// |f| (r + 3.1 u (2 |c| + r)); the computed length of f is within 3 u of |f|, or larger, its
// product with a radius and the difference round by u each, of at most |f| (|c| + r): a radius of
// (r + 16 u (|c| + r)) (1 + 16 u) takes all of that in. What is subtracted or added then is the
// same for the cluster and its points, and sums round in one direction with what they are of: no
// point of a cluster is lower than the cluster, as computed.

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "collision/lanes/lane_sweep_impl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/lanes/lane_sweep_simd.cc"
#include "collision/base/targets.h"
#include "collision/base/tolerances.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kLanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using Sweep = LaneSweepKernel::Sweep;
using Scratch = LaneSweepKernel::Scratch;
using Placed = Scratch::Placed;
constexpr std::uint32_t kAll = (1U << kLanes) - 1;

HWY_INLINE std::uint32_t bitsOf(D d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  const std::uint32_t all = (1U << hn::Lanes(d)) - 1;
  return (bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8U) & all;
}

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

/// A point of a frame, from its origin.
HWY_INLINE V3 armOf(D d, const LaneFrame& frame, const V3& point, std::size_t at) {
  const auto row = [&](std::size_t i) {
    return dot({hn::Load(d, frame.rotation[i].at + at), hn::Load(d, frame.rotation[3 + i].at + at),
                hn::Load(d, frame.rotation[6 + i].at + at)},
               point);
  };
  return {row(0), row(1), row(2)};
}

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

/// From a ball's centre to an obstacle: the part of it outside the core (its length is the
/// distance), how deep the centre is inside (<= 0, 0 outside), and the way in the same axes.
struct Gap {
  V3 outside, way;
  V depth;
};

/// The first and last of these, for a point in the obstacle's axes, from its centre.
HWY_INLINE V3 outsideOf(D d, const Sweep::Obstacle& o, const V3& p, V& depth) {
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

/// How far the core goes along a direction in the obstacle's axes, from its centre.
HWY_INLINE V supportOf(D d, const Sweep::Obstacle& o, const V3& n) {
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
HWY_INLINE Gap gapOf(D d, const Sweep::Obstacle& o, const V3& center, const V3& way) {
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
HWY_INLINE Gap gapTo(D d, const Sweep::Obstacle& o, const Placed& ball, std::size_t at) {
  const V3 center = load(d, ball.center, at);
  return gapOf<kStill>(d, o, center, kStill ? center : load(d, ball.way, at));
}

/// Lanes of `lanes` in which the capsule is not proven to keep `above`. For key != null also the
/// least signed distance of centres in any lane.
template <bool kStill>
HWY_INLINE std::uint32_t openToObstacle(const Sweep::Obstacle& o, const Placed& ball, float above,
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

/// Lanes in which the ball, in the middle of the interval, is within `below` of the obstacle.
HWY_INLINE std::uint32_t contactWithObstacle(const Sweep::Obstacle& o, const Placed& ball,
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

HWY_INLINE V3 pointOf(D d, const Sweep& s, int i) {
  const auto k = static_cast<std::size_t>(i);
  return {hn::Set(d, s.point[0][k]), hn::Set(d, s.point[1][k]), hn::Set(d, s.point[2][k])};
}

/// Lanes of `lanes` in which one of the points [begin, end), placed in the middle of the interval,
/// is within `below` of the obstacle: the first that is so in any of them, which `point` becomes,
/// or else `end`.
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

/// openToObstacle() for two balls, seen from the second's frame, whose turn moves the first across
/// the way between them and so drops out.
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

/// Lanes in which two balls are within `below` of each other in the middle of the interval.
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

/// What points count that are seen along a plane: of clusters most are left out.
HWY_INLINE std::int64_t workOf(const Sweep::LanePiece::Points& points) {
  const int clusters = points.clusters_end - points.clusters_begin;
  return kLanePointWork *
         (clusters == 0 ? points.end - points.begin : clusters + 3 * kClusterPoints);
}

/// A direction as the points of a frame meet it in the two ends of their ways: the least of
/// first . v - drift and second . v + drift over points v, from the frame's origin, is the least of
/// the segments that they move along.
template <bool kStill>
struct Ways {
  V3 first, second;
  V drift;
  V doubt;  // 0; NaN where any of them is no number, which hn::Min() drops with some targets

  /// columns: the frame's rotation; turn, slide: its motion.
  HWY_INLINE Ways(D d, const V3* columns, const V3& n, const V3& turn, const V3& slide) {
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
    // (Where `second` is none, the way is none, nor is `first`.)
    doubt = hn::Add(doubtOf(first), hn::Sub(drift, drift));
  }

 private:
  static HWY_INLINE V doubtOf(const V3& v) {
    const V sum = hn::Add(hn::Add(v.x, v.y), v.z);
    return hn::Sub(sum, sum);
  }
};

/// Least values of Ways over clusters of points: below none of those that are computed one by one.
template <bool kStill>
class ClusterWays {
 public:
  HWY_INLINE ClusterWays(D d, const Ways<kStill>& ways)
      : ways_(ways), first_(lengthOf(d, ways.first)), second_(first_) {
    if (!kStill) second_ = lengthOf(d, ways.second);
  }

  /// At most what any of the cluster's points comes to, as computed; drift included.
  HWY_INLINE V leastOf(D d, const Sweep::Cluster& cluster) const {
    const V3 center = broadcast(d, cluster.center);
    const V radius = hn::Set(d, cluster.radius);
    const V least =
        hn::Sub(hn::Sub(dot(ways_.first, center), hn::Mul(first_, radius)), ways_.drift);
    if (kStill) return least;
    return hn::Min(
        least, hn::Add(hn::Sub(dot(ways_.second, center), hn::Mul(second_, radius)), ways_.drift));
  }

 private:
  // Its square would be 0 for what is very short.
  static HWY_INLINE V lengthOf(D d, const V3& v) {
    return hn::Sqrt(hn::Add(dot(v, v), hn::Set(d, kLaneInsteadOfZero)));
  }

  const Ways<kStill>& ways_;
  V first_, second_;
};

/// Lanes of `lanes` in which the plane does not part the pair as it must, A being told by `points`.
template <bool kStill>
HWY_INLINE std::uint32_t notPartedBy(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
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
      pair.part_above + points.radius + growth + (pair.pieces ? 4 : 1) * kernel.slack;
  const V bar = hn::Set(d, plane.offset + above * kLaneNormalOutwards);
  kernel.scratch.work->add(kLanePlaneWork + workOf(points));
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
    const Ways<kStill> ways(d, columns, n, turn, slide);
    V low_first = hn::Set(d, 1e30f), low_second = low_first;
    const auto scan = [&](int begin, int end) HWY_ATTR {
      for (int i = begin; i < end; ++i) {
        const V3 v = pointOf(d, s, i);
        low_first = hn::Min(low_first, dot(ways.first, v));
        if (!kStill) low_second = hn::Min(low_second, dot(ways.second, v));
      }
    };
    const V from = hn::Add(dot(n, o), ways.doubt);
    if (points.clusters_begin == points.clusters_end) scan(points.begin, points.end);
    // What is parted as a whole need not be looked at one by one: sums round alike.
    const ClusterWays<kStill> clusters(d, ways);
    for (int i = points.clusters_begin; i < points.clusters_end; ++i) {
      const Sweep::Cluster& cluster = s.clusters[static_cast<std::size_t>(i)];
      if (!hn::AllTrue(d, hn::Gt(hn::Add(from, clusters.leastOf(d, cluster)), bar)))
        scan(cluster.begin, cluster.end);
    }
    V low = hn::Sub(low_first, ways.drift);
    if (!kStill) low = hn::Min(low, hn::Add(low_second, ways.drift));
    // NaN stays open.
    open |= bitsOf(d, hn::Not(hn::Gt(hn::Add(from, low), bar))) << at;
  }
  return open & lanes;
}

/// The same with a few points, and then with more.
template <bool kStill>
HWY_INLINE std::uint32_t notParted(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                                   const Scratch::Plane& plane, std::uint32_t lanes) {
  const Sweep::LanePiece& a = kernel.sweep.pieces[static_cast<std::size_t>(pair.a)];
  lanes = notPartedBy<kStill>(kernel, pair, a.points, plane, lanes);
  if (lanes == 0 || a.fine.begin == a.points.begin) return lanes;
  return notPartedBy<kStill>(kernel, pair, a.fine, plane, lanes);
}

/// Lanes of `lanes` in which one of the points [begin, end) of A proves a contact with an obstacle.
HWY_INLINE std::uint32_t pointsInside(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                                      std::int32_t begin, std::int32_t end, std::uint32_t lanes,
                                      std::int32_t& point) {
  const Sweep& s = kernel.sweep;
  const Sweep::LanePiece& a = s.pieces[static_cast<std::size_t>(pair.a)];
  if (pair.pieces || a.frame < 0 || a.own < 0) return 0;
  const Sweep::Obstacle& o = s.obstacles[static_cast<std::size_t>(pair.b)];
  if (!o.exact) return 0;
  const float below = pair.contact_below - kernel.slack - a.own + o.radius;
  const std::uint32_t met =
      contactOfPoints(s, kernel.frames[a.frame], o, begin, end, below, lanes, point);
  kernel.scratch.work->add((point - begin + 1) * kLanePointWork);
  return met;
}

/// Steps towards an obstacle with a few points, and then with more [count].
constexpr int kCoarseSteps = 4, kFineSteps = 4;

/// Planes for each lane by itself, found on the way to the obstacle that Gilbert goes ("An
/// iterative procedure for computing the minimum of a quadratic form on a convex set", 1966): from
/// a point of A's sweep, at first the middle of its ball, the direction from what is nearest of the
/// core is a plane's; the point of the sweep that is least along it is the next to go towards.
template <bool kStill>
class Approach {
 public:
  HWY_INLINE Approach(const LaneSweepKernel& kernel, const Sweep::Pair& pair)
      : kernel_(kernel),
        s_(kernel.sweep),
        a_(s_.pieces[static_cast<std::size_t>(pair.a)]),
        o_(s_.obstacles[static_cast<std::size_t>(pair.b)]),
        frame_(kernel.frames[a_.frame]),
        above_(pair.part_each_above + o_.radius + (kStill ? 0 : kernel.growth[pair.motion]) +
               kernel.slack) {}

  HWY_INLINE void run(std::uint32_t lanes, LaneSweepKernel::Each& each) {
    const D d;
    each.open = each.touching = 0;
    int coarse = 0, fine = 0;  // steps, of the lane that takes most: the same for any registers
    for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
      const std::uint32_t asked = lanes >> at & ((1U << hn::Lanes(d)) - 1);
      if (asked == 0) continue;
      begin(at);
      std::uint32_t open = asked;
      int step = 0;
      for (; step < kCoarseSteps && open != 0; ++step) open &= next(a_.points);
      coarse = std::max(coarse, step);
      step = 0;
      for (; step < kFineSteps && open != 0 && a_.fine.begin != a_.points.begin; ++step)
        open &= next(a_.fine);
      fine = std::max(fine, step);
      each.open |= open << at;
      each.touching |= (open & touching()) << at;
      store(d, parting_, each.normal, at);
    }
    kernel_.scratch.work->add(coarse * workOf(a_.points) + fine * workOf(a_.fine));
  }

 private:
  HWY_INLINE void begin(std::size_t at) {
    const D d;
    at_ = at;
    const V3 center = broadcast(d, o_.center);
    origin_ = difference(load(d, frame_.origin, at), center);
    const V3 arm = armOf(d, frame_, broadcast(d, a_.outer.center), at);
    from_ = {hn::Add(origin_.x, arm.x), hn::Add(origin_.y, arm.y), hn::Add(origin_.z, arm.z)};
    parting_ = from_;
    done_ = hn::Lt(origin_.x, origin_.x);  // none
    for (std::size_t k = 0; k < 3; ++k) columns_[k] = load(d, frame_.rotation + 3 * k, at);
    lowest_ = hn::Set(hn::RebindToSigned<D>(), a_.points.begin);
    turn_ = slide_ = from_;
    if (!kStill) turn_ = load(d, frame_.turn, at), slide_ = load(d, frame_.slide, at);
  }

  /// From the core to where the way has come, in the obstacle's axes, and the depth inside.
  HWY_INLINE V3 outside(V& depth) const {
    const D d;
    V3 p = from_;
    if (!o_.aligned)
      p = {dot(broadcast(d, o_.rotation), p), dot(broadcast(d, o_.rotation + 3), p),
           dot(broadcast(d, o_.rotation + 6), p)};
    return outsideOf(d, o_, p, depth);
  }

  /// Lanes in which the way has come to the obstacle.
  HWY_INLINE std::uint32_t touching() const {
    const D d;
    V depth;
    const V3 gap = outside(depth);
    const V near = hn::Set(d, o_.radius + kLaneTouching);
    return bitsOf(d, hn::Le(dot(gap, gap), hn::Mul(near, near)));
  }

  /// One step, with these points; lanes that its plane does not part.
  HWY_INLINE std::uint32_t next(const Sweep::LanePiece::Points& points) {
    const D d;
    V depth;
    V3 n = outside(depth);
    // Squares of less would be lost, and a normal longer than 1 would prove what is not so.
    const V squared = dot(n, n), length = hn::Sqrt(squared);
    const V scale = hn::IfThenElseZero(hn::Gt(squared, hn::Set(d, kLeastWaySquared)),
                                       hn::Div(hn::Set(d, 1.0f), length));
    n = {hn::Mul(n.x, scale), hn::Mul(n.y, scale), hn::Mul(n.z, scale)};  // 0 inside
    const V support = supportOf(d, o_, n);
    if (!o_.aligned) {
      const V3 x = broadcast(d, o_.rotation), y = broadcast(d, o_.rotation + 3),
               z = broadcast(d, o_.rotation + 6);
      n = {dot({x.x, y.x, z.x}, n), dot({x.y, y.y, z.y}, n), dot({x.z, y.z, z.z}, n)};
    }
    const Ways<kStill> ways(d, columns_, n, turn_, slide_);
    const V low = hn::Add(least(points, ways), ways.doubt);
    // NaN, and what is inside, stays open.
    const V bar = hn::Set(d, (above_ + points.radius) * kLaneNormalOutwards);
    const M parted = hn::Gt(hn::Add(dot(n, origin_), low), hn::Add(support, bar));
    // The first of a lane is kept: how many follow is a matter of its neighbours in the register.
    const M first = hn::AndNot(done_, parted);
    done_ = hn::Or(done_, parted);
    parting_ = {hn::IfThenElse(first, n.x, parting_.x), hn::IfThenElse(first, n.y, parting_.y),
                hn::IfThenElse(first, n.z, parting_.z)};
    goTowards(n, length);
    return bitsOf(d, hn::Not(parted));
  }

  HWY_INLINE V valueOf(const Ways<kStill>& ways, const V3& v) const {
    const V value = hn::Sub(dot(ways.first, v), ways.drift);
    return kStill ? value : hn::Min(value, hn::Add(dot(ways.second, v), ways.drift));
  }

  HWY_INLINE V3 lowestPoint() const {
    const D d;
    return {hn::GatherIndex(d, s_.point[0].data(), lowest_),
            hn::GatherIndex(d, s_.point[1].data(), lowest_),
            hn::GatherIndex(d, s_.point[2].data(), lowest_)};
  }

  /// The least of the points' values; lowest_ becomes whose it is.
  HWY_INLINE V least(const Sweep::LanePiece::Points& points, const Ways<kStill>& ways) {
    const D d;
    const hn::RebindToSigned<D> di;
    V low = hn::Set(d, 1e30f);
    const auto scan = [&](int begin, int end) HWY_ATTR {
      for (int i = begin; i < end; ++i) {
        const V value = valueOf(ways, pointOf(d, s_, i));
        const M less = hn::Lt(value, low);
        low = hn::Min(value, low);
        lowest_ = hn::IfThenElse(hn::RebindMask(di, less), hn::Set(di, i), lowest_);
      }
    };
    if (points.clusters_begin == points.clusters_end) {
      scan(points.begin, points.end);
      return low;
    }
    // What was lowest, or is next to it, is nearly so again: most clusters are above it. To leave
    // them out changes nothing, so that a lane does not depend on its neighbours.
    lowest_ = hn::GatherIndex(di, s_.begin_with.data(), lowest_);
    low = valueOf(ways, lowestPoint());
    const ClusterWays<kStill> clusters(d, ways);
    std::uint64_t wanted = 0;
    for (int i = points.clusters_begin; i < points.clusters_end; ++i) {
      const Sweep::Cluster& cluster = s_.clusters[static_cast<std::size_t>(i)];
      // (Not AllFalse() of less: what is no number is not above.)
      const bool above = hn::AllTrue(d, hn::Ge(clusters.leastOf(d, cluster), low));
      wanted |= std::uint64_t{above ? 0U : 1U} << (i - points.clusters_begin);
    }
    for (; wanted != 0; wanted &= wanted - 1) {
      const int i = points.clusters_begin + std::countr_zero(wanted);
      const Sweep::Cluster& cluster = s_.clusters[static_cast<std::size_t>(i)];
      scan(cluster.begin, cluster.end);
    }
    return low;
  }

  HWY_INLINE void goTowards(const V3& n, V length) {
    const D d;
    const V one = hn::Set(d, 1.0f);
    const V3 v = lowestPoint();
    const V3 arm = armOf(d, frame_, v, at_);
    V3 to = {hn::Add(origin_.x, arm.x), hn::Add(origin_.y, arm.y), hn::Add(origin_.z, arm.z)};
    if (!kStill) {
      const V3 t = cross(turn_, arm);
      const V3 w = {hn::Add(slide_.x, t.x), hn::Add(slide_.y, t.y), hn::Add(slide_.z, t.z)};
      const V end = hn::CopySign(one, dot(n, w));  // of the segment, the one that is less along n
      to = {hn::Sub(to.x, hn::Mul(end, w.x)), hn::Sub(to.y, hn::Mul(end, w.y)),
            hn::Sub(to.z, hn::Mul(end, w.z))};
    }
    const V3 way = difference(to, from_);
    const V nearer = hn::Neg(hn::Mul(dot(n, way), length));
    const V share = hn::Div(hn::Max(nearer, hn::Zero(d)),
                            hn::Max(dot(way, way), hn::Set(d, kLaneInsteadOfZero)));
    const V taken = hn::Min(share, one);
    from_ = {hn::Add(from_.x, hn::Mul(taken, way.x)), hn::Add(from_.y, hn::Mul(taken, way.y)),
             hn::Add(from_.z, hn::Mul(taken, way.z))};
  }

  const LaneSweepKernel& kernel_;
  const Sweep& s_;
  const Sweep::LanePiece& a_;
  const Sweep::Obstacle& o_;
  const LaneFrame& frame_;
  float above_;
  std::size_t at_ = 0;
  V3 columns_[3], turn_, slide_, origin_;  // origin_ and from_: from the obstacle's centre
  V3 from_, parting_;
  M done_;
  hn::VFromD<hn::RebindToSigned<D>> lowest_;
};

/// One run; the steps stand in the order in which they are taken.
template <bool kStill>
class Run {
 public:
  explicit Run(const LaneSweepKernel& kernel)
      : s_(kernel.sweep), scratch_(kernel.scratch), kernel_(kernel) {}

  HWY_INLINE LaneSweepKernel::Contact again() {
    ++scratch_.stamp;
    for (const Scratch::Killer& killer : scratch_.killers) {
      if (killer.pair < 0) break;
      const Sweep::Pair& pair = s_.pairs[size(killer.pair)];
      std::int32_t point = killer.point;
      const std::uint32_t lanes = point < 0
                                      ? contact(pair, kAll)
                                      : pointsInside(kernel_, pair, point, point + 1, kAll, point);
      if (lanes != 0) return kernel_.told(killer.pair, point, lanes);
    }
    return {};
  }

  HWY_INLINE LaneSweepKernel::Contact one(std::int32_t number) {
    ++scratch_.stamp;
    const Sweep::Pair& pair = s_.pairs[size(number)];
    const std::uint32_t by_balls = contact(pair, kAll);
    if (by_balls != 0) return kernel_.told(number, -1, by_balls);
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    std::int32_t point = -1;
    const auto inside = [&](const Sweep::LanePiece::Points& points) {
      return pointsInside(kernel_, pair, points.begin, points.end, kAll, point);
    };
    std::uint32_t lanes = inside(a.points);
    if (lanes == 0 && a.fine.begin != a.points.begin) lanes = inside(a.fine);
    return lanes != 0 ? kernel_.told(number, point, lanes) : LaneSweepKernel::Contact{};
  }

  /// For each pair of parts of a pair, the lanes of `lanes` in which their balls are not proven to
  /// keep the threshold.
  HWY_INLINE void nearParts(std::int32_t number, std::uint32_t lanes, std::uint32_t* near) {
    const Sweep::Pair& whole = s_.pairs[size(number)];
    const float fixed = fixedPart(whole, whole.cover_above);
    for (std::int32_t p = whole.parts_begin; p < whole.parts_end; ++p, ++near) {
      const Sweep::Pair& pair = s_.pairs[size(p)];
      const float above = fixed + s_.pieces[size(pair.a)].outer.radius;
      scratch_.work->add(2 * kLaneBallWork);
      placePart(size(pair.a));
      if (pair.pieces) {
        placePart(size(pair.b));
        *near = openToBall<kStill>(scratch_.outer[size(pair.a)], scratch_.outer[size(pair.b)],
                                   above + s_.pieces[size(pair.b)].outer.radius, lanes);
      } else {
        *near = openToObstacle<kStill>(s_.obstacles[size(pair.b)], scratch_.outer[size(pair.a)],
                                       above, lanes);
      }
    }
  }

  HWY_INLINE LaneSweepKernel::Contact all() {
    ++scratch_.stamp;
    scratch_.open.clear();
    scratch_.open_pairs.clear();
    scratch_.candidates.clear();
    placeOuter();
    cull();
    std::sort(scratch_.candidates.begin(), scratch_.candidates.end(),
              [](const Scratch::Candidate& x, const Scratch::Candidate& y) {
                return x.key < y.key || (x.key == y.key && x.pair < y.pair);
              });
    // Obstacles are met deep more often than they are missed by little; pieces the other way.
    for (const Scratch::Candidate& c : scratch_.candidates) {
      const Sweep::Pair& pair = s_.pairs[size(c.pair)];
      const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
      if (pair.pieces || !(c.key <= a.inner_reach - a.outer.radius)) continue;
      const std::uint32_t lanes = contact(pair, c.lanes);
      if (lanes != 0) return kernel_.told(c.pair, -1, lanes);
    }
    for (const Scratch::Candidate& c : scratch_.candidates) {
      const Sweep::Pair& pair = s_.pairs[size(c.pair)];
      std::uint32_t open = c.lanes;
      // Pairs stay about as they are from edge to edge.
      const Scratch::Plane& plane = scratch_.planes[size(c.pair)];
      if (plane.known) open = notParted<kStill>(kernel_, pair, plane, open);
      if (open == 0) continue;
      open = uncovered(pair, open);
      if (open == 0) continue;
      if (pair.pieces) {
        const std::uint32_t lanes = contact(pair, open);
        if (lanes != 0) return kernel_.told(c.pair, -1, lanes);
      }
      scratch_.open.push_back({pair.id, open});
      scratch_.open_pairs.push_back(c.pair);
    }
    return {};
  }

 private:
  static std::size_t size(std::int32_t i) { return static_cast<std::size_t>(i); }

  const LaneFrame& frame(const Sweep::LanePiece& piece) const {
    return kernel_.frames[piece.frame];
  }
  float growthOf(int motion) const { return kStill || motion < 0 ? 0 : kernel_.growth[motion]; }

  HWY_INLINE void placeOuter() {
    const D d;
    for (std::size_t p = 0; p < s_.wholes; ++p) {
      const Sweep::LanePiece& piece = s_.pieces[p];
      if (piece.frame < 0) continue;
      Placed& placed = scratch_.outer[p];
      placeBall<kStill>(frame(piece), piece.outer.center, placed);
      const float radius = piece.outer.radius + growthOf(piece.motion) + kernel_.slack;
      V sum = hn::Zero(d);
      for (int k = 0; k < 3; ++k) {
        V low = hn::Set(d, 1e30f), high = hn::Set(d, -1e30f);
        for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
          const V c = hn::Load(d, placed.center[k].at + at);
          const V w = kStill ? hn::Zero(d) : hn::Abs(hn::Load(d, placed.way[k].at + at));
          const V end = hn::Add(c, w);
          low = hn::Min(low, hn::Sub(c, w));
          high = hn::Max(high, end);
          sum = hn::Add(sum, end);
        }
        scratch_.low[3 * p + static_cast<std::size_t>(k)] =
            hn::GetLane(hn::MinOfLanes(d, low)) - radius;
        scratch_.high[3 * p + static_cast<std::size_t>(k)] =
            hn::GetLane(hn::MaxOfLanes(d, high)) + radius;
      }
      // What is no number may have been dropped: then nothing is known to be apart.
      if (hn::AllTrue(d, hn::Eq(hn::Sub(sum, sum), hn::Zero(d)))) continue;
      std::fill_n(&scratch_.low[3 * p], 3, std::numeric_limits<float>::quiet_NaN());
      std::fill_n(&scratch_.high[3 * p], 3, std::numeric_limits<float>::quiet_NaN());
    }
  }

  HWY_INLINE void cull() {
    const D d;
    const std::size_t padded = s_.paddedObstacles();
    for (std::size_t p = 0; p < s_.wholes; ++p) {
      if (!s_.pieces[p].has_obstacles) continue;
      const float* low = &scratch_.low[3 * p];
      const float* high = &scratch_.high[3 * p];
      for (std::size_t i = 0; i < padded; i += hn::Lanes(d)) {
        M apart = hn::Lt(hn::Set(d, high[0]), hn::LoadU(d, s_.low[0].data() + i));
        for (int k = 0; k < 3; ++k) {
          if (k > 0)
            apart = hn::Or(apart, hn::Lt(hn::Set(d, high[k]), hn::LoadU(d, s_.low[k].data() + i)));
          apart = hn::Or(apart, hn::Gt(hn::Set(d, low[k]), hn::LoadU(d, s_.high[k].data() + i)));
        }
        std::uint32_t near = bitsOf(d, hn::Not(apart));
        for (std::size_t j = i; near != 0; near >>= 1U, ++j)
          if ((near & 1U) != 0) considerObstacle(p, s_.pair_of[p * padded + j]);
      }
    }
    for (const std::int32_t pair : s_.piece_pairs) considerPieces(pair);
  }

  HWY_INLINE void considerObstacle(std::size_t p, std::int32_t number) {
    if (number < 0) return;
    const Sweep::Pair& pair = s_.pairs[size(number)];
    const Sweep::Obstacle& o = s_.obstacles[size(pair.b)];
    const Sweep::LanePiece& piece = s_.pieces[p];
    const float above = fixedPart(pair) + piece.outer.radius;
    float key;
    const std::uint32_t lanes = openToObstacle<kStill>(o, scratch_.outer[p], above, kAll, &key);
    if (lanes != 0) scratch_.candidates.push_back({key - above, number, lanes});
    scratch_.work->add(kLaneBallWork);
  }

  HWY_INLINE void considerPieces(std::int32_t number) {
    const Sweep::Pair& pair = s_.pairs[size(number)];
    const std::size_t a = size(pair.a), b = size(pair.b);
    for (std::size_t k = 0; k < 3; ++k)
      if (scratch_.low[3 * a + k] - scratch_.high[3 * b + k] > pair.free_above ||
          scratch_.low[3 * b + k] - scratch_.high[3 * a + k] > pair.free_above)
        return;
    const float above = fixedPart(pair) + s_.pieces[a].outer.radius + s_.pieces[b].outer.radius;
    float key;
    const std::uint32_t lanes =
        openToBall<kStill>(scratch_.outer[a], scratch_.outer[b], above, kAll, &key);
    scratch_.work->add(kLaneBallWork);
    if (lanes != 0) scratch_.candidates.push_back({key - above, number, lanes});
  }

  /// What a pair's separation must exceed besides radii.
  float fixedPart(const Sweep::Pair& pair) const { return fixedPart(pair, pair.free_above); }
  float fixedPart(const Sweep::Pair& pair, float above) const {
    const float growth = growthOf(pair.motion);
    if (pair.pieces) return above + growth + 2 * kernel_.slack;
    return above + growth + kernel_.slack + s_.obstacles[size(pair.b)].radius;
  }

  HWY_INLINE void placePart(std::size_t p) {
    if (scratch_.part_stamp[p] == scratch_.stamp) return;
    scratch_.part_stamp[p] = scratch_.stamp;
    const Sweep::LanePiece& piece = s_.pieces[p];
    if (piece.frame >= 0) placeBall<kStill>(frame(piece), piece.outer.center, scratch_.outer[p]);
  }

  HWY_INLINE void placeCover(std::size_t p) {
    if (scratch_.cover_stamp[p] == scratch_.stamp) return;
    scratch_.cover_stamp[p] = scratch_.stamp;
    const Sweep::LanePiece& piece = s_.pieces[p];
    scratch_.work->add((piece.inner - piece.cover) * kLaneBallWork);
    if (piece.frame < 0) return;
    for (int i = piece.cover; i < piece.inner; ++i)
      placeBall<kStill>(frame(piece), s_.balls[size(i)].center, scratch_.balls[size(i)]);
  }
  HWY_INLINE void placeInner(std::size_t p) {
    if (scratch_.inner_stamp[p] == scratch_.stamp) return;
    scratch_.inner_stamp[p] = scratch_.stamp;
    const Sweep::LanePiece& piece = s_.pieces[p];
    scratch_.work->add((piece.end - piece.inner) * kLaneBallWork);
    if (piece.frame < 0) return;
    for (int i = piece.inner; i < piece.end; ++i)
      placeBall<true>(frame(piece), s_.balls[size(i)].center, scratch_.balls[size(i)]);
  }

  /// Lanes of `lanes` in which inner balls prove that the threshold is not kept.
  HWY_INLINE std::uint32_t contact(const Sweep::Pair& pair, std::uint32_t lanes) {
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    if (a.inner == a.end) return 0;
    placeInner(size(pair.a));
    if (!pair.pieces && s_.obstacles[size(pair.b)].exact) {
      const Sweep::Obstacle& o = s_.obstacles[size(pair.b)];
      const float below = pair.contact_below - kernel_.slack + o.radius;
      for (int i = a.inner; i < a.end; ++i) {
        const std::uint32_t found = lanes & contactWithObstacle(o, scratch_.balls[size(i)],
                                                                below + s_.balls[size(i)].radius);
        if (found != 0) return found;
      }
      return 0;
    }
    if (pair.balls < 0) return 0;
    const Sweep::LanePiece& b = s_.pieces[size(pair.balls)];
    placeInner(size(pair.balls));
    const float below = pair.contact_below - 2 * kernel_.slack;
    for (int i = a.inner; i < a.end; ++i)
      for (int j = b.inner; j < b.end; ++j) {
        const std::uint32_t found =
            lanes & contactWithBall(scratch_.balls[size(i)], scratch_.balls[size(j)],
                                    below + s_.balls[size(i)].radius + s_.balls[size(j)].radius);
        if (found != 0) return found;
      }
    return 0;
  }

  /// Lanes of `lanes` in which some ball of the covers is not proven to keep the threshold.
  HWY_INLINE std::uint32_t uncovered(const Sweep::Pair& pair, std::uint32_t lanes) {
    placeCover(size(pair.a));
    const Sweep::LanePiece& a = s_.pieces[size(pair.a)];
    if (!pair.pieces) {
      const Sweep::Obstacle& o = s_.obstacles[size(pair.b)];
      const float fixed = fixedPart(pair, pair.cover_above);
      std::uint32_t open = 0;
      for (int i = a.cover; i < a.inner && open != lanes; ++i)
        open |= openToObstacle<kStill>(o, scratch_.balls[size(i)], fixed + s_.balls[size(i)].radius,
                                       lanes & ~open);
      scratch_.work->add((a.inner - a.cover) * kLaneBallWork);
      if (open == 0 || pair.balls < 0) return open;
      lanes = open;
    }
    return uncoveredPieces(a, size(pair.balls),
                           pair.cover_above + growthOf(pair.motion) + 2 * kernel_.slack, lanes);
  }

  HWY_INLINE std::uint32_t uncoveredPieces(const Sweep::LanePiece& a, std::size_t number,
                                           float fixed, std::uint32_t lanes) {
    placeCover(number);
    const Sweep::LanePiece& b = s_.pieces[number];
    std::uint32_t open = 0;
    for (int i = a.cover; i < a.inner && open != lanes; ++i) {
      const Placed& ball = scratch_.balls[size(i)];
      const float above = fixed + s_.balls[size(i)].radius;
      scratch_.work->add(kLaneBallWork);
      const std::uint32_t near =
          openToBall<kStill>(ball, scratch_.outer[number], above + b.outer.radius, lanes & ~open);
      if (near == 0) continue;
      scratch_.work->add((b.inner - b.cover) * kLaneBallWork);
      for (int j = b.cover; j < b.inner && open != lanes; ++j)
        open |= openToBall<kStill>(ball, scratch_.balls[size(j)], above + s_.balls[size(j)].radius,
                                   near & ~open);
    }
    return open;
  }

  const Sweep& s_;
  Scratch& scratch_;
  const LaneSweepKernel& kernel_;
};

LaneSweepKernel::Contact MeetAgain(const LaneSweepKernel& kernel) {
  return Run<true>(kernel).again();
}
LaneSweepKernel::Contact MeetPair(const LaneSweepKernel& kernel, std::int32_t pair) {
  return Run<true>(kernel).one(pair);
}
LaneSweepKernel::Contact SweepAll(const LaneSweepKernel& kernel) {
  return Run<false>(kernel).all();
}
LaneSweepKernel::Contact StillAll(const LaneSweepKernel& kernel) { return Run<true>(kernel).all(); }

std::uint32_t SweepPlane(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                         const Scratch::Plane& plane, std::uint32_t lanes) {
  return notParted<false>(kernel, pair, plane, lanes);
}
void SweepNearParts(const LaneSweepKernel& kernel, std::int32_t pair, std::uint32_t lanes,
                    std::uint32_t* near) {
  Run<false>(kernel).nearParts(pair, lanes, near);
}
void StillNearParts(const LaneSweepKernel& kernel, std::int32_t pair, std::uint32_t lanes,
                    std::uint32_t* near) {
  Run<true>(kernel).nearParts(pair, lanes, near);
}
void SweepEach(const LaneSweepKernel& kernel, const Sweep::Pair& pair, std::uint32_t lanes,
               LaneSweepKernel::Each& each) {
  Approach<false>(kernel, pair).run(lanes, each);
}
void StillEach(const LaneSweepKernel& kernel, const Sweep::Pair& pair, std::uint32_t lanes,
               LaneSweepKernel::Each& each) {
  Approach<true>(kernel, pair).run(lanes, each);
}
std::uint32_t PointsInside(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                           const Sweep::LanePiece::Points& points, std::uint32_t lanes,
                           std::int32_t& point) {
  return pointsInside(kernel, pair, points.begin, points.end, lanes, point);
}
std::uint32_t StillPlane(const LaneSweepKernel& kernel, const Sweep::Pair& pair,
                         const Scratch::Plane& plane, std::uint32_t lanes) {
  return notParted<true>(kernel, pair, plane, lanes);
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {
namespace {

/// Planes that are searched for a pair in a run, one after the other as long as each parts a lane.
constexpr int kPlaneTries = 3;

/// The middle one of the lanes.
int middleOf(std::uint32_t lanes) {
  int half = (std::popcount(lanes) - 1) / 2, lane = 0;
  while ((lanes >> lane & 1U) == 0 || half-- > 0) ++lane;
  return lane;
}

}  // namespace

HWY_EXPORT(MeetAgain);
HWY_EXPORT(MeetPair);
HWY_EXPORT(SweepAll);
HWY_EXPORT(StillAll);
HWY_EXPORT(SweepPlane);
HWY_EXPORT(StillPlane);
HWY_EXPORT(PointsInside);
HWY_EXPORT(SweepEach);
HWY_EXPORT(SweepNearParts);
HWY_EXPORT(StillNearParts);
HWY_EXPORT(StillEach);

LaneSweepKernel::Parted LaneSweepKernel::partEach(std::int32_t number, std::uint32_t lanes) const {
  const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
  Each each;
  if (growth == nullptr)
    HWY_DYNAMIC_DISPATCH(StillEach)(*this, pair, lanes, each);
  else
    HWY_DYNAMIC_DISPATCH(SweepEach)(*this, pair, lanes, each);
  if (each.open != lanes) remember(number, each, middleOf(lanes & ~each.open));
  Parted parted{each.open, false, false};
  if (each.open == 0) return parted;
  if (growth != nullptr) HWY_DYNAMIC_DISPATCH(StillEach)(*this, pair, parted.open, each);
  parted.apart = each.open == 0;
  parted.touching = each.touching != 0;
  return parted;
}

bool LaneSweepKernel::partByQueries(std::int32_t number, bool closely, std::uint32_t& lanes) const {
  const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
  bool apart = false;
  for (int look = 0; look < kPlaneTries && lanes != 0; ++look) {
    Scratch::Plane plane{};
    apart = findPlane(pair, middleOf(lanes), closely, plane,
                      &scratch.searches[static_cast<std::size_t>(number)]);
    if (!apart) break;
    const std::uint32_t left = growth == nullptr
                                   ? HWY_DYNAMIC_DISPATCH(StillPlane)(*this, pair, plane, lanes)
                                   : HWY_DYNAMIC_DISPATCH(SweepPlane)(*this, pair, plane, lanes);
    if (left == lanes && closely) break;
    closely = closely || left == lanes;
    if (left != lanes) scratch.planes[static_cast<std::size_t>(number)] = plane;
    lanes = left;
  }
  return apart;
}

LaneSweepKernel::Parted LaneSweepKernel::partPair(std::int32_t number, std::uint32_t lanes,
                                                  bool closely) const {
  const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
  Parted parted{lanes, false, false};
  if (pair.part_each_above >= 0) parted = partEach(number, lanes);
  // What has come to a box around a hull may still be apart from that.
  const bool touching = parted.touching &&
                        (!pair.by_parts || sweep.obstacles[static_cast<std::size_t>(pair.b)].exact);
  if (pair.part_above >= 0 && !parted.apart && !touching)
    parted.apart = partByQueries(number, closely, parted.open);
  return parted;
}

LaneSweepKernel::Parted LaneSweepKernel::partParts(std::int32_t number, std::uint32_t lanes,
                                                   bool closely) const {
  const Scratch::Plane& plane = scratch.planes[static_cast<std::size_t>(number)];
  if (plane.known) {
    const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
    lanes = growth == nullptr ? HWY_DYNAMIC_DISPATCH(StillPlane)(*this, pair, plane, lanes)
                              : HWY_DYNAMIC_DISPATCH(SweepPlane)(*this, pair, plane, lanes);
    if (lanes == 0) return {0, true, false};
  }
  return partPair(number, lanes, closely);
}

LaneSweepKernel::Parted LaneSweepKernel::partByParts(std::int32_t number, std::uint32_t lanes,
                                                     bool closely) const {
  const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
  std::uint32_t near[Sweep::kMostPartPairs];
  if (growth == nullptr)
    HWY_DYNAMIC_DISPATCH(StillNearParts)(*this, number, lanes, near);
  else
    HWY_DYNAMIC_DISPATCH(SweepNearParts)(*this, number, lanes, near);
  Parted parted{0, true, false};
  const std::int32_t count = pair.parts_end - pair.parts_begin;
  std::int32_t& stubborn = scratch.manners[static_cast<std::size_t>(number)].stubborn;
  // What was in the way last is likely to be again, and then nothing else matters.
  const std::int32_t first = stubborn;
  for (std::int32_t k = 0; k < count && parted.open != lanes; ++k) {
    if (scratch.work->isSpent()) return {lanes, false, false};
    const std::int32_t part = k == 0 ? first : k <= first ? k - 1 : k;
    const std::uint32_t left = near[part] & ~parted.open;
    if (left == 0) continue;
    const Parted found = partParts(pair.parts_begin + part, left, closely);
    if (found.open == 0) continue;
    parted.open |= found.open;
    parted.apart = parted.apart && found.apart;
    stubborn = part;
  }
  return parted;
}

LaneSweep::Contact LaneSweepKernel::meetOpen() const {
  for (std::size_t i = 0; i < scratch.open.size(); ++i) {
    const std::int32_t number = scratch.open_pairs[i];
    const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
    std::int32_t point = -1;
    const std::uint32_t met = HWY_DYNAMIC_DISPATCH(PointsInside)(
        *this, pair, sweep.pieces[static_cast<std::size_t>(pair.a)].points, scratch.open[i].lanes,
        point);
    if (met != 0) return told(number, point, met);
  }
  return {};
}

LaneSweep::Contact LaneSweepKernel::partOpen(bool closely) const {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < scratch.open.size(); ++i) {
    const std::int32_t number = scratch.open_pairs[i];
    const Sweep::Pair& pair = sweep.pairs[static_cast<std::size_t>(number)];
    const Sweep::LanePiece& a = sweep.pieces[static_cast<std::size_t>(pair.a)];
    std::uint32_t lanes = scratch.open[i].lanes;
    if (scratch.work->isSpent()) {
      scratch.open_pairs[kept] = number;
      scratch.open[kept++] = {pair.id, lanes, false};
      continue;
    }
    Parted parted{lanes, false, false};
    Scratch::Manner& manner = scratch.manners[static_cast<std::size_t>(number)];
    if (!manner.by_parts) parted = partPair(number, lanes, closely);
    if (parted.open != 0 && !parted.apart && pair.parts_begin < pair.parts_end) {
      const std::uint32_t before = parted.open;
      parted = partByParts(number, before, closely);
      manner.by_parts = before == lanes && parted.open != lanes;
    }
    lanes = parted.open;
    if (lanes == 0) continue;
    if (!parted.apart && a.fine.begin != a.points.begin) {
      std::int32_t point = -1;
      const std::uint32_t met =
          HWY_DYNAMIC_DISPATCH(PointsInside)(*this, pair, a.fine, lanes, point);
      if (met != 0) return told(number, point, met);
    }
    scratch.open_pairs[kept] = number;
    scratch.open[kept++] = {pair.id, lanes, parted.apart};
  }
  scratch.open.resize(kept);
  scratch.open_pairs.resize(kept);
  return {};
}

LaneSweep::Contact LaneSweep::meetAgain(std::span<const LaneFrame> frames, float slack,
                                        Scratch& scratch) const {
  return HWY_DYNAMIC_DISPATCH(MeetAgain)({*impl_, *scratch.impl_, frames.data(), nullptr, slack});
}

LaneSweep::Contact LaneSweep::meet(int pair, std::span<const LaneFrame> frames, float slack,
                                   Scratch& scratch) const {
  return HWY_DYNAMIC_DISPATCH(MeetPair)({*impl_, *scratch.impl_, frames.data(), nullptr, slack},
                                        pair);
}

LaneSweep::Contact LaneSweep::run(std::span<const LaneFrame> frames, std::span<const float> growth,
                                  float slack, Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), growth.data(), slack};
  const Contact contact = HWY_DYNAMIC_DISPATCH(SweepAll)(kernel);
  return contact.id < 0 ? kernel.meetOpen() : contact;
}

LaneSweep::Contact LaneSweep::part(std::span<const LaneFrame> frames, std::span<const float> growth,
                                   float slack, Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), growth.data(), slack};
  ++scratch.impl_->stamp;  // looks at other places may have come between
  return kernel.partOpen(false);
}

LaneSweep::Contact LaneSweep::runPairs(std::span<const Open> pairs,
                                       std::span<const LaneFrame> frames,
                                       std::span<const float> growth, float slack,
                                       Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), growth.data(), slack};
  ++scratch.impl_->stamp;
  scratch.impl_->open.clear();
  scratch.impl_->open_pairs.clear();
  for (const auto& [number, lanes, apart] : pairs) {
    const Impl::Pair& pair = impl_->pairs[static_cast<std::size_t>(number)];
    const Scratch::Impl::Plane& plane = scratch.impl_->planes[static_cast<std::size_t>(number)];
    const std::uint32_t open =
        plane.known ? HWY_DYNAMIC_DISPATCH(SweepPlane)(kernel, pair, plane, lanes) : lanes;
    if (open == 0) continue;
    scratch.impl_->open.push_back({pair.id, open});
    scratch.impl_->open_pairs.push_back(number);
  }
  const Contact contact = kernel.meetOpen();
  return contact.id < 0 ? kernel.partOpen(true) : contact;
}

LaneSweep::Contact LaneSweep::runStill(std::span<const LaneFrame> frames, float slack,
                                       Scratch& scratch) const {
  const LaneSweepKernel kernel{*impl_, *scratch.impl_, frames.data(), nullptr, slack};
  Contact contact = HWY_DYNAMIC_DISPATCH(StillAll)(kernel);
  // What is met deep in any pair is told sooner than planes are looked for in one.
  if (contact.id < 0) contact = kernel.meetOpen();
  return contact.id < 0 ? kernel.partOpen(false) : contact;
}

}  // namespace leeway::collision
#endif  // HWY_ONCE
