#include "planner/edge/pair_queries.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/scene/scene_access.h"
#include "planner/compiled/edge_model.h"

namespace leeway::planner {

PairQueries::PairQueries(EdgeFrames& frames, collision::Workspace& workspace,
                         const collision::Work& work, const Asked& asked, EdgeMemory& memory)
    : frames_(frames),
      workspace_(workspace),
      work_(work),
      asked_(asked),
      memory_(memory),
      motion_(frames.scene().edgeModel().motions.size()),
      world_balls_(frames.scene().edges().moving.size()) {}

PairState PairQueries::coarseState(int slot, const EdgePair& pair) const {
  const collision::GeometryBounds& a = frames_.piece(pair.a).bounds();
  const collision::GeometryBounds& b = frames_.piece(pair.b).bounds();
  const double lower =
      b.coarse.lower(frames_.inFrameOf(slot, pair.b, frames_.center(slot, pair.a)));
  const double threshold = asked_.thresholdOf(pair);
  if (lower - a.outer.radius > threshold) return PairState::kFree;
  const int link = frames_.piece(pair.a).link;
  for (const collision::Ball& ball : a.inner) {
    const Eigen::Vector3d center_W =
        link < 0 ? ball.center : frames_.links(slot)[at(link)] * ball.center;
    const double upper = b.coarse.upper(frames_.inFrameOf(slot, pair.b, center_W));
    if (upper - ball.radius <= threshold) return PairState::kNotFree;
  }
  return PairState::kOpen;
}

collision::DistanceResult PairQueries::distanceAt(int slot, const EdgePair& pair,
                                                  const collision::DistanceRequest& request) {
  ++count;
  ++statistics->distance_queries;
  collision::DistanceResult result = collision::distance(
      frames_.piece(pair.a).shape(), frames_.piecePose(slot, pair.a), frames_.piece(pair.b).shape(),
      frames_.piecePose(slot, pair.b), request, collision::SceneAccess::scratch(workspace_),
      &collision::SceneAccess::cache(workspace_, pair.scene_pair));
  if (pair.is_reversed) {
    std::swap(result.point_a, result.point_b);
    std::swap(result.triangle_a, result.triangle_b);
    result.normal = -result.normal;
  }
  return result;
}

PairState PairQueries::exactState(int slot, const EdgePair& pair, int nodes) {
  const double threshold = asked_.thresholdOf(pair);
  collision::DistanceRequest request;
  if (nodes > 0) request.node_limit = nodes;
  request.threshold = threshold;
  request.depth = threshold < 0;
  Interval distance = distanceAt(slot, pair, request).distance;
  const auto isOpen = [&] {
    return !(distance.lower > threshold) && !(distance.upper <= threshold);
  };
  if (request.depth && isOpen()) {
    // A full depth query of meshes may find a shorter way out than one that stops at the threshold.
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    distance = distanceAt(slot, pair, request).distance;
  }
  if (distance.lower > threshold) return PairState::kFree;
  return distance.upper <= threshold ? PairState::kNotFree : PairState::kOpen;
}

PairState PairQueries::sweep(const EdgeInterval& interval, int p, double& t) {
  if (work_.isSpent()) return PairState::kOpen;
  const EdgePair& pair = frames_.pair(p);
  double growth = 0;
  const double threshold = asked_.thresholdOf(pair);
  if (coarseSweep(interval, pair, growth) > threshold ||
      frames_.keepsGap(pair, threshold, interval.t0, interval.t0 + interval.h))
    return PairState::kFree;
  if (!pair.by_surfaces)
    return growth <= memory_.of(p).growth_limit ? sweepExactly(interval, p, growth, t)
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

PairState PairQueries::sweepExactly(const EdgeInterval& interval, int p, double growth, double& t) {
  const EdgePair& pair = frames_.pair(p);
  const double threshold = asked_.thresholdOf(pair);
  double& limit = memory_.of(p).growth_limit;
  const Interval distance =
      hullSweep(interval, pair, growth, threshold, growth > kDeepSweepGrowth ? kShallowNodes : 0);
  if (distance.lower > threshold) {
    limit = std::min(std::max(limit, growth) * kGrowthLimitRise, kSweepGrowth);
    return PairState::kFree;
  }
  // A sweep that ran out of work says nothing about its growth.
  if (!work_.isSpent()) limit = std::max({growth * kGrowthLimitFall, limit / 2, kLeastGrowthLimit});
  memory_.of(p).sweep_failed = interval_;
  if (!(distance.upper <= threshold)) return PairState::kOpen;
  // The proof concerns one end or the other.
  const bool at_begin = exactState(interval.slot0, pair) == PairState::kNotFree;
  t = at_begin ? interval.t0 : interval.t0 + interval.h;
  return PairState::kNotFree;
}

const robots::MotionBound& PairQueries::motionOf(const EdgeInterval& interval, int m) {
  MotionMemory& memory = motion_[at(m)];
  if (memory.interval == interval_) return memory.bound;
  // Each end bounds the half of the interval next to it. Intervals of a level are neighbours: the
  // right end of the last one is the left end of this one.
  const double half = interval.h / 2;
  const bool is_next = memory.generation == frames_.generation() && memory.slot == interval.slot0 &&
                       memory.half == half;
  const robots::MotionBound left =
      is_next ? memory.right : frames_.motionNear(m, interval.slot0, half);
  memory.right = frames_.motionNear(m, interval.slot1, half);
  memory.generation = frames_.generation();
  memory.slot = interval.slot1;
  memory.half = half;
  memory.interval = interval_;
  memory.bound = {std::max(left.speed, memory.right.speed),
                  std::max(left.acceleration, memory.right.acceleration)};
  return memory.bound;
}

PairQueries::SweptBall PairQueries::sweptBall(const EdgeInterval& interval, const EdgePair& pair,
                                              const Eigen::Vector3d& c0,
                                              const Eigen::Vector3d& c1) {
  // No point leaves the chord between its two positions by more than h^2 A / 8.
  const double growth = interval.h * interval.h * motionOf(interval, pair.motion).acceleration / 8;
  const double radius = (c1 - c0).norm() / 2 + growth + frames_.piece(pair.a).bounds().outer.radius;
  return {(c0 + c1) / 2, radius, growth, interval_};
}

const PairQueries::SweptBall& PairQueries::worldBall(const EdgeInterval& interval,
                                                     const EdgePair& pair) {
  SweptBall& ball = world_balls_[at(frames_.piece(pair.a).moving)];
  if (ball.interval == interval_) return ball;
  ball = sweptBall(interval, pair, frames_.center(interval.slot0, pair.a),
                   frames_.center(interval.slot1, pair.a));
  return ball;
}

double PairQueries::coarseSweep(const EdgeInterval& interval, const EdgePair& pair,
                                double& growth) {
  const Piece& b = frames_.piece(pair.b);
  const auto centerAt = [&](int slot) {
    return frames_.inFrameOf(slot, pair.b, frames_.center(slot, pair.a));
  };
  const SweptBall ball =
      b.link < 0 ? worldBall(interval, pair)
                 : sweptBall(interval, pair, centerAt(interval.slot0), centerAt(interval.slot1));
  growth = ball.growth;
  const double lower = b.bounds().coarse.lower(ball.center) - ball.radius;
  return std::isnan(lower) ? -kInfinity : lower;
}

Interval PairQueries::hullSweep(const EdgeInterval& interval, const EdgePair& pair, double growth,
                                double threshold, int nodes) {
  collision::DistanceRequest request;
  request.threshold = threshold;
  request.depth = false;
  if (nodes > 0) request.node_limit = nodes;
  ++count;
  ++statistics->distance_queries;
  const collision::Shape& a = frames_.piece(pair.a).shape();
  const collision::Shape& b = frames_.piece(pair.b).shape();
  Interval distance =
      collision::sweptDistance(a, frames_.relative(interval.slot0, pair),
                               frames_.relative(interval.slot1, pair), growth, b, request,
                               collision::SceneAccess::scratch(workspace_),
                               &collision::SceneAccess::cache(workspace_, pair.scene_pair))
          .distance;
  // A threshold below rounding allows depth. A body that is inside a mesh at the edge's end may
  // then come too deep although surfaces do not meet, so containment is checked here. A bound below
  // zero comes from the hulls and remains valid.
  if (threshold < pair.rounding && distance.lower > 0 && !frames_.isConvex(pair)) {
    request.threshold = pair.rounding;
    if (!(distance.lower > pair.rounding &&
          distanceAt(interval.slot0, pair, request).distance.lower > pair.rounding))
      distance.lower = -kInfinity;
  }
  return distance;
}

namespace {

/// The pose of a pair's first piece relative to the second, along the edge.
class PairPlacements final : public collision::Placements {
 public:
  PairPlacements(EdgeFrames& frames, const EdgePair& pair) : frames_(frames), pair_(pair) {}
  bool at(double t, Pose& X_BA) override {
    const int slot = frames_.slotAt(t);
    if (slot < 0) return false;
    X_BA = frames_.relative(slot, pair_);
    return true;
  }

 private:
  EdgeFrames& frames_;
  const EdgePair& pair_;
};

}  // namespace

collision::MeshSweepResult PairQueries::sweepSurfaces(const EdgeInterval& interval,
                                                      const EdgePair& pair) {
  ++statistics->distance_queries;
  collision::MeshSweepRequest request;
  request.t0 = interval.t0;
  request.h = interval.h;
  request.bend = motionOf(interval, pair.motion).acceleration / 8;
  request.threshold = asked_.thresholdOf(pair);
  request.least_motion = kSmallestMotion;
  request.least_time = least_interval;
  const int mark = frames_.used();
  PairPlacements placements(frames_, pair);
  const collision::MeshSweepResult result =
      collision::sweepMesh(frames_.piece(pair.a).shape(), placements, frames_.piece(pair.b).shape(),
                           request, collision::SceneAccess::scratch(workspace_));
  // An undecided sweep placed many short parts that are not used again. A few such sweeps would
  // fill all slots.
  if (result.status == collision::MeshSweepStatus::kUndecided) frames_.release(mark);
  return result;
}

}  // namespace leeway::planner
