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
    return "the path has no steps; the file of a path (--output) as .json or .yaml has them, those "
           "of "
           "trajectories and .csv and .path files do not";
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

/// Returns an empty text if the places begin at 0 and never decrease, and no edge skips a pose.
std::string wrongPlaces(const PathStep& step, double size) {
  const std::vector<double>& places = step.places;
  if (places.size() != at(step.last - step.first) + 1)
    return " has " + std::to_string(places.size()) +
           " places on its line; one for each of its waypoints is expected";
  bool fits = places.front() == 0;
  for (std::size_t i = 0; i + 1 < places.size(); ++i)  // false for NaN
    fits = fits && places[i] <= places[i + 1] && places[i + 1] <= std::floor(places[i]) + 1;
  if (!fits || !(places.back() <= size))
    return " has places that do not go along its line; they are expected to begin at 0, to rise, "
           "and to hold the number of each pose between";
  return {};
}

/// Compares a look at a line's frame with the line. The frame's place on the line goes from `place`
/// to `next` along the edge.
VerifyStatus judgeLine(const LineStep& line, const LineWay& way, double place, double next,
                       const FrameLook& look) {
  const WayStretch& stretch =
      way.stretches[std::min(static_cast<std::size_t>(place), way.stretches.size() - 1)];
  const Pose X_WP = way.at(place + look.t * (next - place));
  const double part = look.half * (next - place);
  const double moves = look.moves + part * stretch.length();
  const double tips = look.tips + part * stretch.turn;
  const double off = (look.X_BF.translation - X_WP.translation).norm();
  // The longest chord between ends of a unit vector turned by either rotation.
  const double chord = (look.X_BF.rotation - X_WP.rotation).norm() / std::sqrt(2.0);
  const double most = 2 * std::sin(std::min(line.angle_tolerance, 3.0) / 2);
  const double slack = look.slack + kVerifyPose * (1 + X_WP.translation.norm());
  if (off - slack > line.position_tolerance || chord - slack > most) return VerifyStatus::kRefuted;
  return off + slack + moves <= line.position_tolerance && chord + 2 * slack + tips <= most
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
    if (const auto* line = std::get_if<LineStep>(&asked.action)) {
      const LineWay way = lineWay(stage, *line, placeLinks(*stage.robot.model, stage.start));
      if (const std::string wrong = wrongPlaces(step, way.size()); !wrong.empty())
        return refuted(step.first, stepText(problem_, s) + wrong);
      robots::PoseRegion goal =
          robots::PoseRegion::exact(way.link, way.X_LF, way.at(step.places.back()), Pose());
      goal.position_tolerance = line->position_tolerance;
      goal.angle_tolerance = line->angle_tolerance;
      stage.goals = {{asked.name, {}, {goal}}};
      if (auto fault = checkStretch(s, stage, stretch)) return fault;
      FrameCheck check(stage, way.link, way.X_LF);
      check.limit(kVerifyPairWork, options_.stop);
      for (std::size_t i = 0; i + 1 < stretch.positions.size(); ++i) {
        double t = 0;
        const VerifyStatus status = check.check(
            stretch, i, kShortestLinePiece * kShortestLinePiece,
            [&](const FrameLook& look) {
              return judgeLine(*line, way, step.places[i], step.places[i + 1], look);
            },
            t);
        if (status == VerifyStatus::kCertified) continue;
        VerifyResult result;
        result.status = status;
        result.segment = step.first + static_cast<int>(i);
        result.t0 = result.t1 = t;
        result.reason = stepText(problem_, s) + (status == VerifyStatus::kRefuted
                                                     ? " departs too far from its line"
                                                     : " is not proven to follow its line");
        return result;
      }
      return std::nullopt;
    }
    return checkStretch(s, stage, stretch);
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
