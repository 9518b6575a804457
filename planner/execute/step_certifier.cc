#include "planner/execute/step_certifier.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/execute/timed_path.h"

namespace leeway::planner {

StepCertifier::StepCertifier(std::shared_ptr<const CompiledScene> scene, Obstacles& obstacles,
                             const Execution& execution)
    : scene_(std::move(scene)),
      obstacles_(obstacles),
      start_(execution.start),
      step_(execution.step),
      longest_(
          kStepTicks << static_cast<int>(std::log2(std::clamp(kLongestPart / step_, 1.0, 1e6)))),
      still_(obstacles.still()),
      rows_(*scene_),
      movers_(obstacles.groups()) {
  begin(0);
}

void StepCertifier::begin(Tick now) {
  now_ = now;
  // Once known to the end, a motion is known so until the program observes it, which is for good.
  const bool hold = obstacles_.arePredicted();
  for (std::size_t g = 0; g < movers_.size(); ++g) {
    Mover& mover = movers_[g];
    std::erase_if(mover.placements,
                  [&](const auto& entry) { return !hold || entry.first.first < now; });
    mover.proven.clear();
    const std::shared_ptr<const CompiledScene> scene = obstacles_.sceneOf(g);
    if (mover.certifier && scene->hasPairsOf(mover.certifier->scene())) continue;
    if (mover.certifier) before_ += mover.certifier->statistics;
    mover.certifier = std::make_unique<EdgeCertifier>(scene);
  }
}

EdgeCertifier::Statistics StepCertifier::statistics() const {
  EdgeCertifier::Statistics sum = before_;
  sum += still_.statistics;
  for (const Mover& mover : movers_) sum += mover.certifier->statistics;
  return sum;
}

StepCertifier::Bodies StepCertifier::names(const CompiledScene& scene, int pair) {
  if (pair < 0) return {};
  const collision::ScenePair& p = scene.scene().pairs()[static_cast<std::size_t>(pair)];
  return {scene.scene().bodies()[static_cast<std::size_t>(p.body_a)].name,
          scene.scene().bodies()[static_cast<std::size_t>(p.body_b)].name};
}

template <class Row>
bool StepCertifier::allFree(EdgeCertifier& certifier, const Row& row, int last, Bodies& broken) {
  if (rows_.until(certifier, row, 0, last, true) == last) return true;
  broken = names(certifier.scene(), rows_.failed().pair);
  return false;
}

bool StepCertifier::holds(const std::vector<std::vector<double>>& path, bool first_edge_known,
                          Bodies& broken) {
  if (!first_edge_known && path.size() > 1) {
    const EdgeCheck check = still_.certify(path[0], path[1], EdgeRequest::persistent());
    if (check.verdict != Verdict::kFree) {
      broken = names(still_.scene(), check.pair);
      return false;
    }
  }
  const auto row = [&](int k) { return std::span<const double>(path[at(k)]); };
  const int last = static_cast<int>(path.size()) - 1;
  rows_.lengthen();
  for (std::size_t g = 0; g < movers_.size() && last > 0; ++g) {
    movers_[g].certifier->rebind(obstacles_.seenIn(g));
    if (!allFree(*movers_[g].certifier, row, last, broken)) return false;
  }
  return true;
}

const Obstacles::Placement& StepCertifier::placement(std::size_t group, Tick t0, Tick t1) {
  const auto [entry, is_new] = movers_[group].placements.try_emplace({t0, t1});
  if (is_new) {
    ++looks;
    entry->second = obstacles_.place(group, timeOf(t0), timeOf(t1), true);
  }
  return entry->second;
}

double StepCertifier::departure(std::span<const TimedPoint> rows) {
  const auto row = [&](int k) { return std::span<const double>(rows[at(k)].position); };
  return rows_.displacement().fromChord(row, 0, static_cast<int>(rows.size()) - 1);
}

bool StepCertifier::rowsFree(EdgeCertifier& certifier, std::span<const TimedPoint> rows,
                             Bodies& broken) {
  const auto rests = [&](std::size_t i) { return rows[i].position == rows[i + 1].position; };
  while (rows.size() > 2 && rests(0)) rows = rows.subspan(1);
  while (rows.size() > 2 && rests(rows.size() - 2)) rows = rows.first(rows.size() - 1);
  const auto row = [&](int k) { return std::span<const double>(rows[at(k)].position); };
  return allFree(certifier, row, static_cast<int>(rows.size()) - 1, broken);
}

bool StepCertifier::isFree(std::span<const TimedPoint> motion) {
  Bodies ignored;
  if (!rowsFree(still_, motion, ignored)) return false;
  for (std::size_t g = 0; g < movers_.size(); ++g) {
    movers_[g].certifier->rebind(obstacles_.seenIn(g));
    if (!rowsFree(*movers_[g].certifier, motion, ignored)) return false;
  }
  return true;
}

bool StepCertifier::certifyPart(std::size_t group, std::span<const TimedPoint> motion, Tick t0,
                                Tick t1, int depth, Bodies& broken) {
  const Obstacles::Placement& known = placement(group, t0, t1);
  const ConfigurationSpace& space = scene_->space();
  EdgeCertifier& moving = *movers_[group].certifier;
  moving.rebind(known.grown);
  if (rowsFree(moving, partOf(space, motion, timeOf(t0), timeOf(t1)), broken)) {
    movers_[group].proven.emplace_back(t0, t1);
    return true;
  }
  const Tick middle = t0 + (t1 - t0) / 2;
  if (depth == 0 || rows_.isSpent() || known.growth <= kLeastGrowth || middle == t0) return false;
  // If the robot is not free at the middle, neither half is free.
  moving.rebind(known.middle);
  const std::vector<TimedPoint> half = partOf(space, motion, timeOf(t0), timeOf(middle));
  if (moving.decide(half.back().position) != Verdict::kFree) return false;
  return certifyPart(group, motion, t0, middle, depth - 1, broken) &&
         certifyPart(group, motion, middle, t1, depth - 1, broken);
}

double StepCertifier::certify(std::span<const TimedPoint> motion, std::span<const Tick> marks,
                              std::size_t must, Bodies& broken, double known) {
  Tick until = now_;
  rows_.lengthen();
  for (Mover& mover : movers_) mover.proven.clear();
  // Not split where it fails: a shorter proof is useless.
  if (!rowsFree(still_, motion, broken)) return -kInfinity;
  if (obstacles_.empty()) return timeOf(marks.back());
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const int halvings = k < must ? kMustHalvings : kAheadHalvings;
    // Parts whose length is a power of two that divides their beginning: other candidates, and
    // later steps, have the same.
    for (Tick length = 0, t0 = until; t0 < marks[k]; t0 += length) {
      length = longest_;
      while (t0 % length != 0 || t0 + length > marks[k]) length /= 2;
      for (std::size_t g = 0; g < movers_.size() && timeOf(t0 + length) > known; ++g)
        if (!certifyPart(g, motion, t0, t0 + length, halvings, broken)) return timeOf(until);
    }
    until = marks[k];
  }
  return timeOf(until);
}

Interval StepCertifier::clearance(std::span<const TimedPoint> motion, double end, double tolerance,
                                  Bodies& closest) {
  const ConfigurationSpace& space = scene_->space();
  Interval least{scene_->completeWithin(), kInfinity};
  double kept = kInfinity;  // by the closest pair, whatever obstacles do within their bounds
  const auto name = [&](const CompiledScene& scene, int pair, double keeps) {
    if (!(keeps < kept)) return;
    kept = keeps;
    closest = names(scene, pair);
  };
  const auto take = [&](const CompiledScene& scene, const EdgeClearance& edge, double growth,
                        double proven) {
    if (edge.pair < 0) return;
    least.lower = std::min(least.lower, std::max(edge.clearance.lower - growth, proven));
    least.upper = std::min(least.upper, edge.clearance.upper + growth);
    // The growth over a whole part is too wide; the search below looks at its middle.
    if (growth <= tolerance) name(scene, edge.pair, edge.clearance.upper);
  };
  const auto ask = [&](EdgeCertifier& certifier, std::span<const TimedPoint> part, double growth,
                       double proven) {
    // A chord that departs too far is halved, and the next one is at most twice as long: so all
    // departures together cost O(rows).
    for (std::size_t i = 0, most = part.size(); i + 1 < part.size();) {
      std::size_t last = std::min(part.size() - 1, i + most);
      double off = 0;
      for (; last > i + 1; last = i + (last - i) / 2)
        if (off = departure(part.subspan(i, last - i + 1)); off <= kDepartureShare * tolerance)
          break;
      if (last == i + 1) off = 0;
      take(certifier.scene(),
           certifier.edgeClearance(part[i].position, part[last].position, tolerance, -kInfinity),
           growth + off, proven);
      most = 2 * (last - i);
      i = last;
    }
  };
  ask(still_, partOf(space, motion, motion.front().time, end), 0,
      still_.scene().scene().pairs().leastMargin());
  for (std::size_t g = 0; g < movers_.size(); ++g) {
    const double margin = obstacles_.sceneOf(g)->scene().pairs().leastMargin();
    for (const auto& [t0, t1] : movers_[g].proven) {
      if (timeOf(t0) >= end) continue;
      const Obstacles::Placement& known = placement(g, t0, t1);
      EdgeCertifier& moving = *movers_[g].certifier;
      moving.rebind(known.grown);
      ask(moving, partOf(space, motion, timeOf(t0), timeOf(t1)), known.growth, margin);
      moving.rebind(known.middle);
      const std::vector<TimedPoint> half =
          partOf(space, motion, timeOf(t0), timeOf(t0) + (timeOf(t1) - timeOf(t0)) / 2);
      const StateCheck state = moving.clearance(half.back().position, tolerance);
      if (state.pair < 0) continue;
      least.upper = std::min(least.upper, state.clearance.upper + known.growth_at_middle);
      name(moving.scene(), state.pair, state.clearance.upper - known.growth_at_middle);
    }
  }
  return least;
}

double StepCertifier::roomAt(std::span<const double> point, Tick time) {
  double room = kInfinity;
  for (std::size_t g = 0; g < movers_.size(); ++g) {
    movers_[g].certifier->rebind(placement(g, time, time).middle);
    const StateCheck check = movers_[g].certifier->clearance(point, kClearanceTolerance);
    room = std::min(room, check.clearance.lower);
  }
  return room;
}

}  // namespace leeway::planner
