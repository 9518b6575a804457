#include "planner/execute/step_certifier.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/execute/timed_path.h"

namespace leeway::planner {
namespace {

double largestGrowth(const Obstacles::Replacements& shapes) {
  double largest = 0;
  for (const CompiledScene::Replacement& r : shapes) largest = std::max(largest, r.growth);
  return largest;
}

}  // namespace

StepCertifier::StepCertifier(std::shared_ptr<const CompiledScene> scene, Obstacles& obstacles)
    : scene_(std::move(scene)),
      still_scene_(obstacles.pairsOfOthers(*scene_)),
      moving_scene_(obstacles.pairsOfThese(*scene_)),
      obstacles_(obstacles),
      still_(still_scene_),
      moving_(moving_scene_) {}

void StepCertifier::begin() {
  placements_.clear();
  proven_.clear();
}

EdgeCertifier::Statistics StepCertifier::statistics() const {
  EdgeCertifier::Statistics sum = still_.statistics;
  sum += moving_.statistics;
  return sum;
}

StepCertifier::Bodies StepCertifier::names(const CompiledScene& scene, int pair) const {
  if (pair < 0) return {};
  const collision::ScenePair& p = scene.scene().pairs()[static_cast<std::size_t>(pair)];
  return {scene.scene().bodies()[static_cast<std::size_t>(p.body_a)].name,
          scene.scene().bodies()[static_cast<std::size_t>(p.body_b)].name};
}

bool StepCertifier::holds(const std::vector<std::vector<double>>& path, bool first_edge_known,
                          Bodies& broken) {
  if (!first_edge_known && path.size() > 1) {
    const EdgeCheck check = still_.certify(path[0], path[1], EdgeRequest::persistent());
    if (check.verdict != Verdict::kFree) {
      broken = names(*still_scene_, check.pair);
      return false;
    }
  }
  moving_.rebind(moving_scene_->withShapes(obstacles_.seen()));
  for (std::size_t i = 1; i < path.size(); ++i) {
    const EdgeCheck check = moving_.certify(path[i - 1], path[i], EdgeRequest::persistent());
    if (check.verdict == Verdict::kFree) continue;
    broken = names(*moving_scene_, check.pair);
    return false;
  }
  return true;
}

const StepCertifier::Placement& StepCertifier::placement(double t0, double t1) {
  const auto [entry, is_new] = placements_.try_emplace({t0, t1});
  if (is_new) {
    ++looks;
    Obstacles::Replacements shapes = obstacles_.during(t0, t1);
    entry->second.growth = largestGrowth(shapes);
    entry->second.grown = moving_scene_->withShapes(shapes);
    entry->second.middle =
        moving_scene_->withShapes(obstacles_.atMiddle(std::move(shapes), t0, t1));
  }
  return entry->second;
}

bool StepCertifier::edgesFree(std::span<const TimedPoint> part, Bodies& broken) {
  for (std::size_t i = 1; i < part.size(); ++i) {
    const EdgeCheck check =
        moving_.certify(part[i - 1].position, part[i].position, EdgeRequest::persistent());
    if (check.verdict == Verdict::kFree) continue;
    broken = names(*moving_scene_, check.pair);
    return false;
  }
  return true;
}

bool StepCertifier::certifyPart(std::span<const TimedPoint> motion, double t0, double t1, int depth,
                                Bodies& broken) {
  const Placement& known = placement(t0, t1);
  const ConfigurationSpace& space = scene_->space();
  moving_.rebind(known.grown);
  if (edgesFree(partOf(space, motion, t0, t1), broken)) {
    proven_.emplace_back(t0, t1);
    return true;
  }
  const double middle = t0 + (t1 - t0) / 2;
  if (depth == 0 || known.growth <= kLeastGrowth || !(middle > t0 && middle < t1)) return false;
  // If the robot is not free at the middle, neither half is free.
  moving_.rebind(known.middle);
  if (moving_.decide(partOf(space, motion, t0, middle).back().position) != Verdict::kFree)
    return false;
  return certifyPart(motion, t0, middle, depth - 1, broken) &&
         certifyPart(motion, middle, t1, depth - 1, broken);
}

double StepCertifier::certify(std::span<const TimedPoint> motion, std::span<const double> marks,
                              Bodies& broken) {
  double until = motion.front().time;
  proven_.clear();
  for (std::size_t i = 1; i < motion.size(); ++i) {
    const EdgeCheck check =
        still_.certify(motion[i - 1].position, motion[i].position, EdgeRequest::persistent());
    if (check.verdict == Verdict::kFree) continue;
    broken = names(*still_scene_, check.pair);
    return until;  // not split at the failing edge: a shorter proof is useless
  }
  for (std::size_t k = 0; k < marks.size(); ++k) {
    if (!certifyPart(motion, until, marks[k], k == 0 ? kMustHalvings : kAheadHalvings, broken))
      break;
    until = marks[k];
  }
  return until;
}

Interval StepCertifier::clearance(std::span<const TimedPoint> motion, double end, double tolerance,
                                  Bodies& closest) {
  const ConfigurationSpace& space = scene_->space();
  Interval least{kInfinity, kInfinity};
  const auto take = [&](const CompiledScene& scene, const EdgeClearance& edge, double growth,
                        double proven) {
    if (edge.pair < 0) return;
    least.lower = std::min(least.lower, std::max(edge.clearance.lower - growth, proven));
    if (edge.clearance.upper + growth < least.upper) {
      least.upper = edge.clearance.upper + growth;
      closest = names(scene, edge.pair);
    }
  };
  const double still = still_scene_->scene().pairs().leastMargin();
  const double moving = moving_scene_->scene().pairs().leastMargin();
  const auto ask = [&](EdgeCertifier& certifier, const std::vector<TimedPoint>& part, double growth,
                       double proven) {
    for (std::size_t i = 1; i < part.size(); ++i)
      take(certifier.scene(),
           certifier.edgeClearance(part[i - 1].position, part[i].position, tolerance, -kInfinity),
           growth, proven);
  };
  ask(still_, partOf(space, motion, motion.front().time, end), 0, still);
  for (const auto& [t0, t1] : proven_) {
    if (t0 >= end) continue;
    const Placement& known = placement(t0, t1);
    moving_.rebind(known.grown);
    ask(moving_, partOf(space, motion, t0, t1), known.growth, moving);
  }
  return least;
}

double StepCertifier::roomAt(std::span<const double> point, double time) {
  const Placement& known = placement(time, time);
  moving_.rebind(known.middle);
  return moving_.clearance(point, kClearanceTolerance).clearance.lower;
}

}  // namespace leeway::planner
