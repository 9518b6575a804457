// A separating plane between a piece and an obstacle, computed separately in each lane.
//
// clang-format off
// Rounding besides that of lane_planes-inl.h: a normal is computed in the lane.
//   the core's support, |n| times half extents      6 u s
//   the normal, turned into the world, errs by 5 u:
//   of what is between A's points and the centre    5 u s
//   two sums more                                   < 13 u s all together
// One more kLaneSweepRounding (64 u s) is taken.
// clang-format on
//
// Included once for each target (see Highway's foreach_target.h).

#if defined(LEEWAY_COLLISION_GILBERT_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_GILBERT_PLANES_INL_H
#undef LEEWAY_COLLISION_GILBERT_PLANES_INL_H
#else
#define LEEWAY_COLLISION_GILBERT_PLANES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "collision/lanes/lane_balls-inl.h"
#include "collision/lanes/lane_planes-inl.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Steps towards an obstacle by A's coarse points, then by its fine points [count].
constexpr int kCoarseSteps = 4, kFineSteps = 4;

/// A separating plane for each lane by Gilbert's algorithm (E. G. Gilbert, "An iterative procedure
/// for computing the minimum of a quadratic form on a convex set", 1966). The iterate is a point of
/// A's sweep, at first the centre of its ball. The direction to it from the nearest point of the
/// obstacle's core is the plane's normal. The iterate moves towards the sweep's lowest point along
/// the normal, until it is closest to the obstacle.
template <bool kStill>
class GilbertPlanes {
 public:
  HWY_INLINE GilbertPlanes(const LaneSweepKernel& kernel, const Sweep::Pair& pair)
      : kernel_(kernel),
        s_(kernel.sweep),
        a_(s_.pieces[static_cast<std::size_t>(pair.a)]),
        o_(kernel.obstacle(pair)),
        frame_(kernel.frames[a_.frame]),
        above_(pair.own_plane_above + o_.radius + (kStill ? 0 : kernel.growth[pair.motion]) +
               kernel.slack) {}

  HWY_INLINE void run(std::uint32_t lanes, LaneSweepKernel::OwnPlanes& planes) {
    const D d;
    planes.open = planes.touching = 0;
    int coarse = 0, fine = 0;  // steps of the slowest lane: the same for registers of any width
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
      planes.open |= open << at;
      planes.touching |= (open & touching()) << at;
      store(d, normal_, planes.normal, at);
    }
    kernel_.scratch.work.add(coarse * workOf(a_.points) + fine * workOf(a_.fine));
  }

 private:
  HWY_INLINE void begin(std::size_t at) {
    const D d;
    at_ = at;
    const V3 center = broadcast(d, o_.center);
    origin_ = difference(load(d, frame_.origin, at), center);
    const V3 arm = armOf(d, frame_, broadcast(d, a_.outer.center), at);
    iterate_ = {hn::Add(origin_.x, arm.x), hn::Add(origin_.y, arm.y), hn::Add(origin_.z, arm.z)};
    normal_ = iterate_;
    done_ = hn::Lt(origin_.x, origin_.x);  // none
    for (std::size_t k = 0; k < 3; ++k) columns_[k] = load(d, frame_.rotation + 3 * k, at);
    lowest_ = hn::Set(hn::RebindToSigned<D>(), a_.points.begin);
    turn_ = slide_ = iterate_;
    if (!kStill) turn_ = load(d, frame_.turn, at), slide_ = load(d, frame_.slide, at);
  }

  /// The vector from the core to the iterate, in the obstacle's axes, and the depth inside.
  HWY_INLINE V3 outside(V& depth) const {
    const D d;
    V3 p = iterate_;
    if (!o_.aligned)
      p = {dot(broadcast(d, o_.rotation), p), dot(broadcast(d, o_.rotation + 3), p),
           dot(broadcast(d, o_.rotation + 6), p)};
    return outsideOf(d, o_, p, depth);
  }

  /// Lanes in which the iterate is at the obstacle.
  HWY_INLINE std::uint32_t touching() const {
    const D d;
    V depth;
    const V3 gap = outside(depth);
    const V near = hn::Set(d, o_.radius + kLaneTouching);
    return bitsOf(d, hn::Le(dot(gap, gap), hn::Mul(near, near)));
  }

  /// One step with these points; returns the lanes that its plane does not separate.
  HWY_INLINE std::uint32_t next(const Sweep::LanePiece::Points& points) {
    const D d;
    V depth;
    V3 n = outside(depth);
    // Smaller squares lose digits, and a normal longer than 1 would prove too much.
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
    const SweptDirection<kStill> swept(d, columns_, n, turn_, slide_);
    const V low = hn::Add(least(points, swept), swept.doubt);
    // A lane with NaN stays open, and so does one with the iterate inside, whose normal is 0.
    const V bar = hn::Set(d, (above_ + points.radius) * kLaneNormalOutwards);
    const M separated = hn::Gt(hn::Add(dot(n, origin_), low), hn::Add(support, bar));
    // Keeps the first plane of a lane, because the number of later steps depends on other lanes of
    // the register.
    const M first = hn::AndNot(done_, separated);
    done_ = hn::Or(done_, separated);
    normal_ = {hn::IfThenElse(first, n.x, normal_.x), hn::IfThenElse(first, n.y, normal_.y),
               hn::IfThenElse(first, n.z, normal_.z)};
    goTowards(n, length);
    return bitsOf(d, hn::Not(separated));
  }

  HWY_INLINE V valueOf(const SweptDirection<kStill>& swept, const V3& v) const {
    const V value = hn::Sub(dot(swept.first, v), swept.drift);
    return kStill ? value : hn::Min(value, hn::Add(dot(swept.second, v), swept.drift));
  }

  HWY_INLINE V3 lowestPoint() const {
    const D d;
    return {hn::GatherIndex(d, s_.point[0], lowest_), hn::GatherIndex(d, s_.point[1], lowest_),
            hn::GatherIndex(d, s_.point[2], lowest_)};
  }

  /// The least value of the points; lowest_ becomes the point that has it.
  HWY_INLINE V least(const Sweep::LanePiece::Points& points, const SweptDirection<kStill>& swept) {
    const D d;
    const hn::RebindToSigned<D> di;
    V low = hn::Set(d, 1e30f);
    const auto scan = [&](int begin, int end) HWY_ATTR {
      for (int i = begin; i < end; ++i) {
        const V value = valueOf(swept, pointOf(d, s_, i));
        const M less = hn::Lt(value, low);
        low = hn::Min(value, low);
        lowest_ = hn::IfThenElse(hn::RebindMask(di, less), hn::Set(di, i), lowest_);
      }
    };
    if (points.clusters_begin == points.clusters_end) {
      scan(points.begin, points.end);
      return low;
    }
    // The last lowest point, or the one next to it, is nearly the lowest again, and most clusters
    // are above it. Skipping those changes no answer, so a lane does not depend on other lanes.
    lowest_ = hn::GatherIndex(di, s_.nearest_fine, lowest_);
    low = valueOf(swept, lowestPoint());
    const ClusterBounds<kStill> clusters(d, swept);
    std::uint64_t wanted = 0;
    for (int i = points.clusters_begin; i < points.clusters_end; ++i) {
      const Sweep::Cluster& cluster = s_.clusters[static_cast<std::size_t>(i)];
      // Not AllFalse() of Lt(), because NaN is not above.
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
      const V end = hn::CopySign(one, dot(n, w));  // the end of the segment that is lower along n
      to = {hn::Sub(to.x, hn::Mul(end, w.x)), hn::Sub(to.y, hn::Mul(end, w.y)),
            hn::Sub(to.z, hn::Mul(end, w.z))};
    }
    const V3 way = difference(to, iterate_);
    const V nearer = hn::Neg(hn::Mul(dot(n, way), length));
    const V share = hn::Div(hn::Max(nearer, hn::Zero(d)),
                            hn::Max(dot(way, way), hn::Set(d, kLaneInsteadOfZero)));
    const V taken = hn::Min(share, one);
    iterate_ = {hn::Add(iterate_.x, hn::Mul(taken, way.x)),
                hn::Add(iterate_.y, hn::Mul(taken, way.y)),
                hn::Add(iterate_.z, hn::Mul(taken, way.z))};
  }

  const LaneSweepKernel& kernel_;
  const Sweep& s_;
  const Sweep::LanePiece& a_;
  const Sweep::Obstacle& o_;
  const LaneFrame& frame_;
  float above_;
  std::size_t at_ = 0;
  V3 columns_[3], turn_, slide_, origin_;  // origin_, iterate_: from the obstacle's centre
  V3 iterate_, normal_;
  M done_;
  hn::VFromD<hn::RebindToSigned<D>> lowest_;
};

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
