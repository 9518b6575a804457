// One interval of an edge: what its pairs keep between two configurations. Coarse bounds first,
// then the exact sweep of a pair's hulls or surfaces.

#include <algorithm>
#include <cmath>

#include "collision/scene/scene_access.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

std::optional<EdgeCertifier::Impl::PairContact> EdgeCertifier::Impl::sweepOpenPairs(
    EdgeInterval& interval) {
  ++statistics->intervals;
  startInterval();
  int kept = interval.begin;
  for (int i = interval.begin; i < interval.end; ++i) {
    const int p = open_pairs[at(i)];
    double t = 0;
    const PairState state = sweepPair(interval, p, t);
    if (state == PairState::kFree) continue;
    open_pairs[at(kept++)] = p;
    if (state == PairState::kOpen) continue;
    for (++i; i < interval.end; ++i) open_pairs[at(kept++)] = open_pairs[at(i)];  // not looked at
    interval.end = kept;
    return PairContact{p, t};
  }
  interval.end = kept;
  return std::nullopt;
}

EdgeCertifier::Impl::PairState EdgeCertifier::Impl::sweepPair(const EdgeInterval& interval, int p,
                                                              double& t) {
  if (work.isSpent()) return PairState::kOpen;
  const EdgePair& pair = frames.pair(p);
  double growth = 0;
  const double threshold = thresholdOf(pair);
  if (coarseSweep(interval, pair, growth) > threshold ||
      frames.keepsGap(pair, threshold, interval.t0, interval.t0 + interval.h))
    return PairState::kFree;
  if (!pair.by_surfaces)
    return growth <= pair_memory.of(p).growth_limit ? sweepExactly(interval, p, growth, t)
                                                    : PairState::kOpen;
  const collision::MeshSweepResult result = sweepSurfaces(interval, pair);
  t = result.t;
  switch (result.status) {
    case collision::MeshSweepStatus::kFree:
      return PairState::kFree;
    case collision::MeshSweepStatus::kContact:
      return PairState::kNotFree;
    case collision::MeshSweepStatus::kUndecided:
      break;
  }
  return PairState::kOpen;
}

EdgeCertifier::Impl::PairState EdgeCertifier::Impl::sweepExactly(const EdgeInterval& interval,
                                                                 int p, double growth, double& t) {
  const EdgePair& pair = frames.pair(p);
  const double threshold = thresholdOf(pair);
  double& limit = pair_memory.of(p).growth_limit;
  const Interval distance =
      sweep(interval, pair, growth, threshold, growth > kDeepSweepGrowth ? kShallowNodes : 0);
  if (distance.lower > threshold) {
    limit = std::min(std::max(limit, growth) * kGrowthLimitRise, kSweepGrowth);
    return PairState::kFree;
  }
  // A sweep that ran out of work says nothing of its growth.
  if (!work.isSpent()) limit = std::max({growth * kGrowthLimitFall, limit / 2, kLeastGrowthLimit});
  pair_memory.of(p).sweep_failed = interval_stamp;
  if (!(distance.upper <= threshold)) return PairState::kOpen;
  // The proof is of one end or the other.
  const bool at_begin = exactState(interval.slot0, pair) == PairState::kNotFree;
  t = at_begin ? interval.t0 : interval.t0 + interval.h;
  return PairState::kNotFree;
}

const robots::MotionBound& EdgeCertifier::Impl::motionOf(const EdgeInterval& interval, int m) {
  MotionMemory& memory = motion[at(m)];
  if (memory.interval_stamp == interval_stamp) return memory.bound;
  // Each end speaks for the half of the interval next to it. Intervals of a level stand side by
  // side: the right end of the last one is the left end of this one.
  const double half = interval.h / 2;
  const bool is_next = memory.generation == frames.generation() && memory.slot == interval.slot0 &&
                       memory.half == half;
  const robots::MotionBound left =
      is_next ? memory.right : frames.motionNear(m, interval.slot0, half);
  memory.right = frames.motionNear(m, interval.slot1, half);
  memory.generation = frames.generation();
  memory.slot = interval.slot1;
  memory.half = half;
  memory.interval_stamp = interval_stamp;
  memory.bound = {std::max(left.speed, memory.right.speed),
                  std::max(left.acceleration, memory.right.acceleration)};
  return memory.bound;
}

EdgeCertifier::Impl::SweptBall EdgeCertifier::Impl::sweptBall(const EdgeInterval& interval,
                                                              const EdgePair& pair,
                                                              const Eigen::Vector3d& c0,
                                                              const Eigen::Vector3d& c1) {
  // No point leaves the chord between its two places by more than h^2 A / 8.
  const double growth = interval.h * interval.h * motionOf(interval, pair.motion).acceleration / 8;
  const double radius = (c1 - c0).norm() / 2 + growth + frames.piece(pair.a).bounds->outer.radius;
  return {(c0 + c1) / 2, radius, growth, interval_stamp};
}

const EdgeCertifier::Impl::SweptBall& EdgeCertifier::Impl::worldBall(const EdgeInterval& interval,
                                                                     const EdgePair& pair) {
  SweptBall& ball = world_balls[at(frames.piece(pair.a).moving)];
  if (ball.interval_stamp == interval_stamp) return ball;
  ball = sweptBall(interval, pair, frames.center(interval.slot0, pair.a),
                   frames.center(interval.slot1, pair.a));
  return ball;
}

double EdgeCertifier::Impl::coarseSweep(const EdgeInterval& interval, const EdgePair& pair,
                                        double& growth) {
  const Piece& b = frames.piece(pair.b);
  const auto centerAt = [&](int slot) {
    return frames.inFrameOf(slot, pair.b, frames.center(slot, pair.a));
  };
  const SweptBall ball =
      b.link < 0 ? worldBall(interval, pair)
                 : sweptBall(interval, pair, centerAt(interval.slot0), centerAt(interval.slot1));
  growth = ball.growth;
  const double lower = b.bounds->coarse.lower(ball.center) - ball.radius;
  return std::isnan(lower) ? -kInfinity : lower;
}

Interval EdgeCertifier::Impl::sweep(const EdgeInterval& interval, const EdgePair& pair,
                                    double growth, double threshold, int nodes) {
  collision::DistanceRequest request;
  request.threshold = threshold;
  request.depth = false;
  if (nodes > 0) request.node_limit = nodes;
  ++queries;
  ++statistics->distance_queries;
  const collision::Shape& a = frames.piece(pair.a).geometry->shape;
  const collision::Shape& b = frames.piece(pair.b).geometry->shape;
  Interval distance =
      collision::sweptDistance(a, frames.relative(interval.slot0, pair),
                               frames.relative(interval.slot1, pair), growth, b, request,
                               collision::SceneAccess::scratch(workspace),
                               &collision::SceneAccess::cache(workspace, pair.scene_pair))
          .distance;
  // A threshold below rounding allows depth. A body that is inside a mesh at the edge's end may
  // then come too deep without a meeting of surfaces, so containment is asked here. A bound below
  // zero is that of the hulls and holds as it is.
  if (threshold < pair.rounding && distance.lower > 0 && !frames.isConvex(pair)) {
    request.threshold = pair.rounding;
    if (!(distance.lower > pair.rounding &&
          stateDistance(interval.slot0, pair, request).distance.lower > pair.rounding))
      distance.lower = -kInfinity;
  }
  return distance;
}

int EdgeCertifier::Impl::slotAt(double t) {
  const double place = t * kSharedSlots;
  if (place != std::floor(place)) return frames.place(t);
  SharedSlot& shared = shared_slots[static_cast<std::size_t>(place)];
  if (shared.slot < 0 || shared.generation != frames.generation())
    shared = {frames.generation(), frames.place(t)};
  return shared.slot;
}

/// Where a pair's first piece is, seen from the second, along the edge.
class EdgeCertifier::Impl::PairPlacements final : public collision::Placements {
 public:
  PairPlacements(Impl& impl, const EdgePair& pair) : impl_(impl), pair_(pair) {}
  bool at(double t, Pose& X_BA) override {
    const int slot = impl_.slotAt(t);
    if (slot < 0) return false;
    X_BA = impl_.frames.relative(slot, pair_);
    return true;
  }

 private:
  Impl& impl_;
  const EdgePair& pair_;
};

collision::MeshSweepResult EdgeCertifier::Impl::sweepSurfaces(const EdgeInterval& interval,
                                                              const EdgePair& pair) {
  ++statistics->distance_queries;
  collision::MeshSweepRequest request;
  request.t0 = interval.t0;
  request.h = interval.h;
  request.bend = motionOf(interval, pair.motion).acceleration / 8;
  request.threshold = thresholdOf(pair);
  request.least_motion = kSmallestMotion;
  request.least_time = smallest;
  const int mark = frames.used();
  PairPlacements placements(*this, pair);
  const collision::MeshSweepResult result = collision::sweepMesh(
      frames.piece(pair.a).geometry->shape, placements, frames.piece(pair.b).geometry->shape,
      request, collision::SceneAccess::scratch(workspace));
  // An undecided sweep placed many short parts that nothing asks for again: a few such sweeps
  // would fill all slots.
  if (result.status == collision::MeshSweepStatus::kUndecided) frames.release(mark);
  return result;
}

}  // namespace leeway::planner
