#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/replanner.h"
#include "planner/base/clock.h"

namespace leeway::planner {
namespace {

/// Adds a step that took `seconds` of computing to the sums of an execution.
void add(const ReplanStep& step, double seconds, ReplanResult& result) {
  ++result.steps;
  result.compute_s += seconds;
  result.longest_step_s = std::max(result.longest_step_s, seconds);
  (step.decision == Decision::kPlan     ? result.plans
   : step.decision == Decision::kFollow ? result.follows
   : step.decision == Decision::kEvade  ? result.evasions
                                        : result.waits) += 1;
  result.certified = result.certified && step.certified;
  result.clearance.lower = std::min(result.clearance.lower, step.clearance.lower);
  result.clearance.upper = std::min(result.clearance.upper, step.clearance.upper);
  // A step begins where the one before ended.
  result.trajectory.insert(result.trajectory.end(),
                           step.motion.begin() + (result.trajectory.empty() ? 0 : 1),
                           step.motion.end());
}

}  // namespace

const char* toString(ReplanStatus status) {
  switch (status) {
    case ReplanStatus::kReached:
      return "reached";
    case ReplanStatus::kUnsafe:
      return "unsafe";
    case ReplanStatus::kTimeout:
      return "timeout";
    case ReplanStatus::kNothingChecked:
      return "nothing_checked";
    case ReplanStatus::kStopped:
      break;
  }
  return "stopped";
}

ReplanResult replan(const Problem& problem, const ReplanOptions& options,
                    const std::function<void(const ReplanStep&)>& on_step, int steps) {
  Replanner replanner(problem, options);
  ReplanResult result;
  result.seed = problem.seed;
  result.clearance = {kInfinity, kInfinity};
  result.certified = true;
  for (const int v : problem.robot.variables)
    result.names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
  if (!replanner.scene()->nothingChecked().empty()) {
    result.status = ReplanStatus::kNothingChecked;
    result.certified = false;
    return result;
  }
  const double end = problem.execution.start + problem.execution.duration;
  while (true) {
    if ((options.stop && options.stop()) || (steps > 0 && result.steps >= steps)) {
      result.status = ReplanStatus::kStopped;
      break;
    }
    if (!(replanner.time() < end - problem.execution.step / 2)) {
      result.status = ReplanStatus::kTimeout;
      break;
    }
    const Clock::time_point begin = Clock::now();
    const ReplanStep step = replanner.step();
    add(step, secondsSince(begin), result);
    if (on_step) on_step(step);
    if (step.decision == Decision::kUnsafe) {
      result.status = ReplanStatus::kUnsafe;
      break;
    }
    if (step.reached) {
      result.status = ReplanStatus::kReached;
      break;
    }
  }
  result.replans = replanner.replans();
  return result;
}

void writeTrajectory(const std::string& file, const Problem& problem,
                     std::span<const TimedPoint> trajectory) {
  validate(problem);
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  std::string text = "time";
  for (const int v : problem.robot.variables)
    text += "," + problem.robot.model->variables[static_cast<std::size_t>(v)].name;
  text += "\n";
  std::vector<double> row, previous;
  for (const TimedPoint& point : trajectory) {
    row = point.position;
    if (!previous.empty()) space.unwrap(previous, row);
    text += fmt::format("{:.17g}", point.time);
    for (const double x : row) text += fmt::format(",{:.17g}", x);
    text += "\n";
    previous = row;
  }
  writeFileWhole(file, text);
}

}  // namespace leeway::planner
