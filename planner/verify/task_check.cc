#include "planner/verify/task_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/task/line_way.h"
#include "planner/task/stages.h"
#include "planner/validate/checks.h"
#include "planner/verify/frame_check.h"
#include "planner/verify/pairs.h"
#include "planner/verify/path_check.h"

namespace leeway::planner::verification {
namespace {

using robots::Pose;

bool moves(const Step& step) {
  return std::holds_alternative<MoveStep>(step.action) ||
         std::holds_alternative<LineStep>(step.action);
}

/// Returns an empty text if the path's steps are the problem's steps, or the first of them, and
/// each step begins at the last waypoint of the step before.
std::string wrongSteps(const Problem& problem, const Path& path) {
  if (path.steps.empty())
    return "the path has no steps; the file of a path (--output) or a trajectory (--trajectory) as "
           ".json or .yaml has them, .csv and .path files do not";
  if ((!path.times.empty() && path.times.size() != path.positions.size()) ||
      path.velocities.size() != path.times.size())
    return "the path has not one time and one row of velocities for each of its rows";
  if (path.steps.size() > problem.steps.size())
    return "the path has " + std::to_string(path.steps.size()) + " steps, the problem " +
           std::to_string(problem.steps.size());
  int now = 0;
  for (std::size_t s = 0; s < path.steps.size(); ++s) {
    const PathStep& step = path.steps[s];
    if (step.first != now || step.last < step.first ||
        (!moves(problem.steps[s]) && step.last != step.first))
      return stepText(problem, s) + " has waypoints " + std::to_string(step.first) + " to " +
             std::to_string(step.last) + "; they do not follow those before";
    now = step.last;
  }
  if (now + 1 != static_cast<int>(path.positions.size()))
    return "the path has waypoints behind its last step";
  return {};
}

/// Returns an empty text if the places begin at 0 and never decrease, and no edge skips a pose. The
/// rows of a motion with times may: places between them are looked at.
std::string wrongPlaces(const PathStep& step, double size, bool is_timed) {
  const std::vector<double>& places = step.places;
  if (places.size() != at(step.last - step.first) + 1)
    return " has " + std::to_string(places.size()) +
           " places on its line; one for each of its waypoints is expected";
  bool fits = places.front() == 0;
  for (std::size_t i = 0; i + 1 < places.size(); ++i)  // false for NaN
    fits = fits && places[i] <= places[i + 1] &&
           (is_timed || places[i + 1] <= std::floor(places[i]) + 1);
  if (!fits || !(places.back() <= size))
    return " has places that do not go along its line; they are expected to begin at 0, to rise, "
           "and to hold the number of each pose between";
  return {};
}

/// Places of a frame on its line, along one edge: they change at a constant rate, or, between rows
/// with times, by the share of the joints' way that is done.
class EdgePlaces {
 public:
  EdgePlaces(const Path& path, std::size_t segment, double place, double next)
      : place_(place), next_(next), share_(0, 1, 1, 1) {
    if (path.times.size() < 2) return;
    const std::size_t size = path.names.size();
    const double duration = path.times[segment + 1] - path.times[segment];
    double way = 0, first = 0, last = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double moved = path.positions[segment + 1][i] - path.positions[segment][i];
      way += moved * moved;
      first += moved * path.velocities[segment][i] * duration;
      last += moved * path.velocities[segment + 1][i] * duration;
    }
    if (!(way > 0)) return;
    const Cubic share(0, 1, first / way, last / way);
    // Where the joints turn back, no share of their way is done twice.
    if (share.least() >= -kVerifyShare && share.most() <= 1 + kVerifyShare) share_ = share;
  }

  double at(double t) const {
    return place_ + std::clamp(share_.at(t), 0.0, 1.0) * (next_ - place_);
  }
  /// How far places are from that at t at most, if t changes by `half`.
  double reach(double half) const { return half * share_.speed() * (next_ - place_); }

 private:
  double place_, next_;
  Cubic share_;
};

/// Compares a look at a line's frame with the line.
VerifyStatus judgeLine(const LineStep& line, const LineWay& way, const EdgePlaces& places,
                       const FrameLook& look) {
  const double place = places.at(look.t), part = places.reach(look.half);
  const auto most = way.stretches.size() - 1;
  const auto stretchAt = [&](double p) {
    return std::min(static_cast<std::size_t>(std::max(p, 0.0)), most);
  };
  double length = 0, turn = 0;
  for (std::size_t k = stretchAt(place - part); k <= stretchAt(place + part); ++k) {
    length = std::max(length, way.stretches[k].length());
    turn = std::max(turn, way.stretches[k].turn);
  }
  const Pose X_WP = way.at(place);
  const double moves = look.moves + part * length;
  const double tips = look.tips + part * turn;
  const double off = (look.X_BF.translation - X_WP.translation).norm();
  // The longest chord between ends of a unit vector turned by either rotation.
  const double chord = (look.X_BF.rotation - X_WP.rotation).norm() / std::sqrt(2.0);
  const double most_chord = 2 * std::sin(std::min(line.angle_tolerance, 3.0) / 2);
  const double slack = look.slack + kVerifyPose * (1 + X_WP.translation.norm());
  if (off - slack > line.position_tolerance || chord - slack > most_chord)
    return VerifyStatus::kRefuted;
  return off + slack + moves <= line.position_tolerance && chord + 2 * slack + tips <= most_chord
             ? VerifyStatus::kCertified
             : VerifyStatus::kUndecided;
}

class TaskCheck {
 public:
  TaskCheck(const Problem& problem, const Path& path, const PlanOptions& options,
            const ClearanceWish& wish)
      : problem_(problem), path_(path), options_(options), wish_(wish) {}

  VerifyResult run() {
    VerifyResult result = verifySteps();
    result.unchecked = countUnchecked(std::vector(unchecked_.begin(), unchecked_.end()));
    return result;
  }

 private:
  VerifyResult verifySteps() {
    result_.clearance_lower = std::numeric_limits<double>::infinity();
    if (std::string reason = wrongSteps(problem_, path_); !reason.empty())
      return refuted(0, std::move(reason));
    Problem world = firstWorld(problem_);
    if (!path_.positions.empty() && !problem_.steps.empty() && !movesRobot(problem_.steps[0])) {
      // Where the first step takes hold of something, the robot is at the start, too.
      const ConfigurationSpace space(problem_.robot.model, problem_.robot.variables);
      const Path begin{path_.names, {path_.positions.front()}, {}};
      if (auto fault = findFault(world, space, begin, false))
        return refuted(0, stepText(problem_, 0) + ": " + fault->reason);
    }
    for (std::size_t s = 0; s < path_.steps.size(); ++s) try {
        const int last = path_.steps[s].last;
        if (const auto fault = checkStep(s, stageOf(world, problem_.steps[s]))) return *fault;
        std::vector<double> configuration = world.start;
        const std::vector<double>& end = path_.positions[at(last)];
        if (end.size() != problem_.robot.variables.size())
          return refuted(last, "a waypoint has not one value for each planned variable");
        for (std::size_t i = 0; i < end.size(); ++i)
          configuration[at(problem_.robot.variables[i])] = end[i];
        world = worldAfter(world, problem_.steps[s], configuration);
      } catch (const std::invalid_argument& error) {
        return refuted(path_.steps[s].first, stepText(problem_, s) + ": " + error.what());
      }
    // This check comes last, so that the existing part of the path is known to be good.
    if (std::string reason = missing(); !reason.empty())
      return refuted(std::max(0, static_cast<int>(path_.positions.size()) - 2), std::move(reason));
    if (std::none_of(problem_.steps.begin(), problem_.steps.end(), movesRobot)) {
      result_.status = VerifyStatus::kNothingChecked;
      result_.reason = kNoMove;
      return result_;
    }
    result_.status = VerifyStatus::kCertified;
    return result_;
  }

  /// Returns the part of the task that the path lacks. The existing part is certified.
  std::string missing() const {
    for (std::size_t s = 0; s < path_.steps.size(); ++s) {
      const std::vector<double>& places = path_.steps[s].places;
      const auto* line = std::get_if<LineStep>(&problem_.steps[s].action);
      if (line == nullptr) continue;
      const auto size = static_cast<double>(std::max<std::size_t>(1, line->poses.size()));
      if (places.back() < size)
        return fmt::format("{} ends early, at {:.6g} of {}; what there is of it is certified",
                           stepText(problem_, s), places.back(), size);
    }
    if (path_.steps.size() < problem_.steps.size())
      return fmt::format("the path has {} steps, the problem {}; these are certified",
                         path_.steps.size(), problem_.steps.size());
    return {};
  }

  VerifyResult refuted(int waypoint, std::string reason) const {
    VerifyResult result;
    result.status = VerifyStatus::kRefuted;
    result.segment = std::min(waypoint, std::max(0, static_cast<int>(path_.positions.size()) - 2));
    result.reason = std::move(reason);
    return result;
  }

  /// Returns the fault of a step; nothing if the step is certified.
  std::optional<VerifyResult> checkStep(std::size_t s, Problem stage) {
    const PathStep& step = path_.steps[s];
    const Step& asked = problem_.steps[s];
    if (std::holds_alternative<AttachStep>(asked.action) ||
        std::holds_alternative<DetachStep>(asked.action))
      return std::nullopt;
    Path stretch{path_.names, {}, {}};
    stretch.positions.assign(path_.positions.begin() + step.first,
                             path_.positions.begin() + step.last + 1);
    if (!path_.times.empty()) {
      stretch.times.assign(path_.times.begin() + step.first, path_.times.begin() + step.last + 1);
      stretch.velocities.assign(path_.velocities.begin() + step.first,
                                path_.velocities.begin() + step.last + 1);
    }
    if (const auto* line = std::get_if<LineStep>(&asked.action)) {
      const LineWay way = lineWay(stage, *line, placeLinks(*stage.robot.model, stage.start));
      if (const std::string wrong = wrongPlaces(step, way.size(), !path_.times.empty());
          !wrong.empty())
        return refuted(step.first, stepText(problem_, s) + wrong);
      robots::PoseRegion goal =
          robots::PoseRegion::exact(way.link, way.X_LF, way.at(step.places.back()), Pose());
      goal.position_tolerance = line->position_tolerance;
      goal.angle_tolerance = line->angle_tolerance;
      stage.goals = {{asked.name, {}, {goal}}};
      if (auto fault = checkStretch(s, stage, stretch)) return fault;
      if (auto fault = checkLine(s, stage, stretch, way)) return fault;
      return std::nullopt;
    }
    return checkStretch(s, stage, stretch);
  }

  /// Returns where a stretch departs from its line, or its frame is faster than asked.
  std::optional<VerifyResult> checkLine(std::size_t s, const Problem& stage, const Path& stretch,
                                        const LineWay& way) const {
    const PathStep& step = path_.steps[s];
    const auto& line = std::get<LineStep>(problem_.steps[s].action);
    FrameCheck check(stage, way.link, way.X_LF);
    check.limit(kVerifyPairWork, options_.stop);
    std::size_t i = 0;
    const auto fails = [&](const FrameCheck::Judge& judge, const char* refuted,
                           const char* undecided) -> std::optional<VerifyResult> {
      double t = 0;
      const VerifyStatus status =
          check.check(stretch, i, kShortestLinePiece * kShortestLinePiece, judge, t);
      if (status == VerifyStatus::kCertified) return std::nullopt;
      VerifyResult result;
      result.status = status;
      result.segment = step.first + static_cast<int>(i);
      result.t0 = result.t1 = t;
      result.reason =
          stepText(problem_, s) + (status == VerifyStatus::kRefuted ? refuted : undecided);
      return result;
    };
    for (; i + 1 < stretch.positions.size(); ++i) {
      const EdgePlaces places(stretch, i, step.places[i], step.places[i + 1]);
      if (auto fault =
              fails([&](const FrameLook& look) { return judgeLine(line, way, places, look); },
                    " departs too far from its line", " is not proven to follow its line"))
        return fault;
    }
    if (stretch.times.size() < 2 || !std::isfinite(line.speed)) return std::nullopt;
    check.measureSpeed();
    for (i = 0; i + 1 < stretch.positions.size(); ++i) {
      const double most =
          line.speed * (1 + kVerifyLimit) * (stretch.times[i + 1] - stretch.times[i]);
      const auto judge = [&](const FrameLook& look) {
        if (look.speed > most) return VerifyStatus::kRefuted;
        return look.most_speed <= most ? VerifyStatus::kCertified : VerifyStatus::kUndecided;
      };
      if (auto fault = fails(judge, " moves its frame faster than its speed",
                             " is not proven to keep its speed"))
        return fault;
    }
    return std::nullopt;
  }

  std::optional<VerifyResult> checkStretch(std::size_t s, const Problem& stage,
                                           const Path& stretch) {
    wish_.others = {result_.clearance_lower, result_.clearance_upper};
    VerifyResult result = verifyValid(stage, stretch, options_, wish_);
    const Pairs pairs = collectPairs(stage, collectBodies(stage));
    unchecked_.insert(pairs.unchecked.begin(), pairs.unchecked.end());
    if (result.status == VerifyStatus::kCertified) {
      result_.clearance_lower = std::min(result_.clearance_lower, result.clearance_lower);
      if (result.clearance_upper < result_.clearance_upper) {
        result_.clearance_upper = result.clearance_upper;
        result_.closest_a = std::move(result.closest_a);
        result_.closest_b = std::move(result.closest_b);
      }
      return std::nullopt;
    }
    if (result.segment >= 0) result.segment += path_.steps[s].first;
    result.reason = stepText(problem_, s) + ": " + result.reason;
    return result;
  }

  const Problem& problem_;
  const Path& path_;
  const PlanOptions& options_;
  ClearanceWish wish_;
  VerifyResult result_;
  std::set<CompiledScene::Dropped> unchecked_;  // in some step
};

}  // namespace

VerifyResult verifyTask(const Problem& problem, const Path& path, const PlanOptions& options,
                        const ClearanceWish& wish) {
  return TaskCheck(problem, path, options, wish).run();
}

}  // namespace leeway::planner::verification
