#include "planner/timing/choose_cuts.h"

// Waypoints near the line between those beside them are left out. Blends are the result of a local
// search over the speeds before and after each, which determine its length. What it finds is
// proven, and made shorter where it is not.

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"
#include "planner/timing/blend.h"
#include "planner/timing/leg.h"
#include "planner/timing/motion_limits.h"

namespace leeway::planner {
namespace {

/// The motion at the end of a leg: by default it stops.
struct Turn {
  double from = 0, to = 0;  ///< speeds on both legs
  double time = 0;          ///< [s]
  double before = 0, after = 0, ramp = 0;
  bool isStop() const { return !(time > 0); }
};

class Choice {
 public:
  Choice(std::span<const Leg> legs, const MotionLimits& limits, const CutRules& rules)
      : legs_(legs), limits_(limits), most_(legs.size() - 1, kInfinity), turns_(legs.size() - 1) {
    for (const Leg& leg : legs) {
      speeds_.push_back(rules.speed ? std::min(leg.limits.speed, rules.speed(leg.direction))
                                    : leg.limits.speed);
      scales_.push_back(std::min(speeds_.back(), mostSpeedAfter(leg.limits, 0, leg.length)));
    }
  }

  /// The turn at the end of leg k.
  const Turn& turn(std::size_t k) const { return turns_[k]; }
  /// How much of the two legs turn k may cut off, at most.
  double& most(std::size_t k) { return most_[k]; }
  void stopAt(std::size_t k) { turns_[k] = {}; }
  /// Whether the legs beside turn k are long enough for it.
  bool fits(std::size_t k) const { return timeWith(k, turns_[k]).has_value(); }

  bool isFasterThanStops() const {
    double time = 0, stopping = 0;
    for (std::size_t e = 0; e < legs_.size(); ++e) {
      const auto takes =
          legTime(e, e > 0 ? turns_[e - 1] : Turn(), e < turns_.size() ? turns_[e] : Turn());
      time += takes ? *takes : kInfinity;
      if (e < turns_.size()) time += turns_[e].time;
      if (const auto stops = legTime(e, {}, {})) stopping += *stops;
    }
    return time < stopping;
  }

  /// Turns in short time; stops at first.
  void search() {
    for (int round = 0; round < kBlendRounds; ++round) {
      bool changes = false;
      for (std::size_t k = 0; k < turns_.size(); ++k) changes = improve(k) || changes;
      for (std::size_t k = 0; k + 1 < turns_.size(); ++k) changes = improveTwo(k) || changes;
      if (!changes) break;
    }
  }

 private:
  /// The time of a leg between turns; nothing if it is too short for them.
  std::optional<double> legTime(std::size_t leg, const Turn& first, const Turn& last) const {
    const LineLimits& limits = legs_[leg].limits;
    const double length = legs_[leg].length - first.after - last.before;
    const auto [low, high] = std::minmax(first.to, last.from);
    if (!(length >= 0)) return std::nullopt;
    const bool meet = length <= kInLine * legs_[leg].length;
    if (SpeedChange(low, high, limits).withLongPhases().way() > (meet ? 0 : length))
      return std::nullopt;
    if (meet) return 0;
    const double time = SpeedProfile(limits, length, first.to, last.from).duration();
    return time >= kLeastPhase ? std::optional(time) : std::nullopt;
  }

  /// The time of turn k and the legs beside it.
  std::optional<double> timeWith(std::size_t k, const Turn& turn) const {
    if (turn.before + turn.after > most_[k]) return std::nullopt;
    const auto before = legTime(k, k > 0 ? turns_[k - 1] : Turn(), turn);
    if (!before) return std::nullopt;
    const auto after = legTime(k + 1, turn, k + 1 < turns_.size() ? turns_[k + 1] : Turn());
    if (!after) return std::nullopt;
    return *before + turn.time + *after;
  }

  /// The time of turns k and k + 1, and of the legs beside them.
  std::optional<double> timeWith(std::size_t k, const Turn& first, const Turn& second) const {
    if (first.before + first.after > most_[k] || second.before + second.after > most_[k + 1])
      return std::nullopt;
    const auto before = legTime(k, k > 0 ? turns_[k - 1] : Turn(), first);
    const auto between = before ? legTime(k + 1, first, second) : std::nullopt;
    if (!between) return std::nullopt;
    const auto after = legTime(k + 2, second, k + 2 < turns_.size() ? turns_[k + 2] : Turn());
    if (!after) return std::nullopt;
    return *before + first.time + *between + second.time + *after;
  }

  Turn turnAt(std::size_t k, double from, double to) const {
    Turn turn;
    turn.from = std::min(from, speeds_[k]);
    turn.to = std::min(to, speeds_[k + 1]);
    const SpeedChange change = fastestTurn(legs_[k], legs_[k + 1], limits_, turn.from, turn.to);
    turn.time = change.time;
    turn.before = turn.from * turn.time / 2;
    turn.after = turn.to * turn.time / 2;
    turn.ramp = turn.time > 0 ? std::min(change.ramp / turn.time, 0.5) : 0;
    return turn;
  }

  /// Whether a better turn k was found.
  bool improve(std::size_t k) {
    if (most_[k] == 0) return false;
    std::optional<double> now = timeWith(k, turns_[k]);
    bool found = !now;
    if (!now) {  // a turn beside it has changed
      turns_[k] = {};
      now = timeWith(k, turns_[k]);
    }
    if (const auto stopping = timeWith(k, Turn()); stopping && now && *stopping < *now) {
      turns_[k] = {};
      now = stopping;
      found = true;
    }
    Turn best = turns_[k];
    double time = now ? *now : kInfinity;
    const auto attempt = [&](double from, double to) {
      const Turn turn = turnAt(k, from, to);
      const std::optional<double> takes = timeWith(k, turn);
      if (turn.isStop() || !takes || !(*takes < time * (1 - kBlendGain))) return false;
      best = turn;
      time = *takes;
      return true;
    };
    if (best.isStop())
      for (int i = 0; i < kBlendSpeeds; ++i) {
        const double share = 1 / std::pow(2.0, i / 2) / (i % 2 == 0 ? 1 : std::sqrt(2.0));
        found = attempt(share * scales_[k], share * scales_[k + 1]) || found;
      }
    if (best.isStop()) return found;
    for (const double f : {1.5, 1.2, 1.07})
      for (int step = 0; step < kBlendSpeeds; ++step) {
        bool better = attempt(best.from * f, best.to * f) || attempt(best.from / f, best.to / f);
        better = attempt(best.from * f, best.to) || attempt(best.from / f, best.to) || better;
        better = attempt(best.from, best.to * f) || attempt(best.from, best.to / f) || better;
        if (!better) break;
        found = true;
      }
    turns_[k] = best;
    return found;
  }

  /// Whether better turns k and k + 1 were found: of a short leg, both must become faster at once.
  bool improveTwo(std::size_t k) {
    if (most_[k] == 0 || most_[k + 1] == 0) return false;
    const auto now = timeWith(k, turns_[k], turns_[k + 1]);
    double time = now ? *now : kInfinity;
    Turn best[2] = {turns_[k], turns_[k + 1]};
    bool found = false;
    for (const double f : {2.0, 1.4, 1.15, 0.87, 0.7}) {
      Turn turns[2];
      for (std::size_t i = 0; i < 2; ++i) {
        const Turn& old = turns_[k + i];
        const double from = old.isStop() ? kBlendStart * scales_[k + i] : old.from;
        const double to = old.isStop() ? kBlendStart * scales_[k + i + 1] : old.to;
        turns[i] = turnAt(k + i, from * f, to * f);
      }
      const std::optional<double> takes = timeWith(k, turns[0], turns[1]);
      if (turns[0].isStop() || turns[1].isStop() || !takes || !(*takes < time * (1 - kBlendGain)))
        continue;
      time = *takes;
      best[0] = turns[0];
      best[1] = turns[1];
      found = true;
    }
    turns_[k] = best[0];
    turns_[k + 1] = best[1];
    return found;
  }

  std::span<const Leg> legs_;
  const MotionLimits& limits_;
  std::vector<double> speeds_;  // of legs beside blends, at most
  std::vector<double> scales_;  // and those that the search begins with, at most
  std::vector<double> most_;
  std::vector<Turn> turns_;
};

/// How far q is from the line from a to b.
double distanceFromLine(const ConfigurationSpace& space, std::span<const double> a,
                        std::span<const double> q, std::span<const double> b) {
  std::vector<double> along(a.size()), to(a.size());
  space.difference(a, b, along);
  space.difference(a, q, to);
  double product = 0, squared = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    product += along[i] * to[i];
    squared += along[i] * along[i];
  }
  for (std::size_t i = 0; i < a.size() && squared > 0; ++i) to[i] -= product / squared * along[i];
  return norm(to);
}

/// Whether circles go the same way over q as without it.
bool goSameWay(const ConfigurationSpace& space, std::span<const double> a,
               std::span<const double> q, std::span<const double> b) {
  std::vector<double> first(a.size()), second(a.size()), whole(a.size());
  space.difference(a, q, first);
  space.difference(q, b, second);
  space.difference(a, b, whole);
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(first[i] + second[i] - whole[i]) > 1) return false;
  return true;
}

/// The waypoints that edges proven free in the scene of `certifier` can do without.
std::vector<int> unneeded(EdgeCertifier& certifier,
                          std::span<const std::vector<double>> waypoints) {
  const ConfigurationSpace& space = certifier.scene().space();
  std::vector<int> left_out;
  int last = 0;  // the last one that is kept
  for (int k = 1; k + 1 < static_cast<int>(waypoints.size()); ++k) {
    const std::vector<double>&a = waypoints[at(last)], &b = waypoints[at(k) + 1];
    bool near = true;
    for (int i = last + 1; i <= k; ++i)
      near = near && distanceFromLine(space, a, waypoints[at(i)], b) <= kStraightening &&
             goSameWay(space, a, waypoints[at(i)], b);
    if (near && certifier.certify(a, b).verdict == Verdict::kFree)
      left_out.push_back(k);
    else
      last = k;
  }
  return left_out;
}

double leastMargin(const CompiledScene& scene) {
  const collision::ScenePairs& pairs = scene.scene().pairs();
  const int robot = scene.bodiesOfRobot();
  return std::min(pairs.leastMargin(robot, true), pairs.leastMargin(robot, false));
}

/// The least clearance of a path [m], or less.
double clearanceOf(EdgeCertifier& certifier, std::span<const std::vector<double>> waypoints) {
  double least = kInfinity;
  for (std::size_t e = 0; e + 1 < waypoints.size(); ++e) {
    const double cutoff = least;
    const EdgeClearance edge = certifier.edgeClearance(
        waypoints[e], waypoints[e + 1], {.tolerance = kCutClearance, .wanted = cutoff});
    least = std::min(least, std::min(edge.clearance.lower, cutoff));
  }
  return least;
}

}  // namespace

Cuts certifiedCuts(const std::shared_ptr<const CompiledScene>& scene,
                   std::span<const std::vector<double>> waypoints, const MotionLimits& limits) {
  return chooseCuts(scene, waypoints, limits, {});
}

Cuts chooseCuts(const std::shared_ptr<const CompiledScene>& scene,
                std::span<const std::vector<double>> waypoints, const MotionLimits& limits,
                const CutRules& rules) {
  if (!scene) throw std::invalid_argument("certifiedCuts(): a compiled scene is expected");
  const ConfigurationSpace& space = scene->space();
  space.requirePath(waypoints, "certifiedCuts()");
  requireLimits(limits, at(space.size()));
  Cuts cuts;
  if (hasRotation(space) || waypoints.size() < 3) return cuts;
  EdgeCertifier certifier(scene);
  const double least = leastMargin(*scene), clearance = clearanceOf(certifier, waypoints);
  const double kept = least + kCutShare * (clearance - least);
  std::shared_ptr<const CompiledScene> roomy = scene;
  if (kept > least && kept < kInfinity) {
    roomy = scene->withMarginAtLeast(kept);
    cuts.clearance = kept;
    certifier.rebind(roomy);
  }
  if (rules.leaves_out) cuts.left_out = unneeded(certifier, waypoints);
  std::vector<int> corners;  // waypoints that are not left out
  for (int i = 0; i < static_cast<int>(waypoints.size()); ++i)
    if (!std::binary_search(cuts.left_out.begin(), cuts.left_out.end(), i)) corners.push_back(i);
  std::vector<std::vector<double>> edges(corners.size() - 1, std::vector<double>(at(space.size())));
  for (std::size_t e = 0; e < edges.size(); ++e)
    space.difference(waypoints[at(corners[e])], waypoints[at(corners[e + 1])], edges[e]);
  const std::vector<Leg> legs = legsOf(space, edges, {}, limits, rules.least_times);
  if (legs.size() < 2) return cuts;
  BlendProof proof(roomy);
  Choice choice(legs, limits, rules);
  const auto blendOf = [&](std::size_t k) {
    const Turn& turn = choice.turn(k);
    return Blend{corners[at(legs[k].last)], turn.before, turn.after, turn.ramp};
  };
  const auto holds = [&](std::size_t k, const Blend& blend) {
    const auto corner = at(legs[k].last);
    const std::vector<double>&before = edges[corner - 1], &after = edges[corner];
    return blend.before <= norm(before) && blend.after <= norm(after) &&
           (!rules.allows || rules.allows(blend.corner, blendDeparture(before, after, blend))) &&
           proof.holds(waypoints[at(blend.corner)], before, after, blend);
  };
  std::vector<std::optional<Blend>> proven(legs.size() - 1);
  std::vector<int> failures(proven.size(), 0);
  for (bool all = false; !all;) {
    choice.search();
    all = true;
    for (std::size_t k = 0; k < proven.size(); ++k) {
      if (choice.turn(k).isStop()) continue;
      const Blend blend = blendOf(k);
      const bool is_proven = proven[k] && proven[k]->before == blend.before &&
                             proven[k]->after == blend.after && proven[k]->ramp == blend.ramp;
      if (choice.fits(k) && (is_proven || holds(k, blend))) {
        proven[k] = blend;
        continue;
      }
      all = false;  // a failure more, so the loop ends
      choice.most(k) =
          ++failures[k] < kBlendTries ? kBlendShrink * (blend.before + blend.after) : 0;
      choice.stopAt(k);
    }
  }
  if (!choice.isFasterThanStops()) return cuts;
  for (std::size_t k = 0; k < proven.size(); ++k)
    if (!choice.turn(k).isStop()) cuts.blends.push_back(blendOf(k));
  return cuts;
}

}  // namespace leeway::planner
