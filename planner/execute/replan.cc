#include <fmt/format.h>

#include <utility>

#include "leeway/planner/path_io.h"
#include "leeway/planner/replanner.h"

namespace leeway::planner {

const char* toString(ReplanStatus status) {
  switch (status) {
    case ReplanStatus::kReached:
      return "reached";
    case ReplanStatus::kExposed:
      return "exposed";
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
  ReplanResult result = replanner.executed();
  if (result.status == ReplanStatus::kNothingChecked) return result;
  std::vector<TimedPoint> trajectory;
  ReplanStatus status = result.status;
  const double end = problem.execution.start + problem.execution.duration;
  for (int taken = 0; status == ReplanStatus::kStopped; ++taken) {
    if ((options.stop && options.stop()) || (steps > 0 && taken >= steps)) break;
    if (!(replanner.time() < end - problem.execution.step / 2)) {
      status = ReplanStatus::kTimeout;
      break;
    }
    const ReplanStep step = replanner.step();
    // A step begins where the one before ended.
    trajectory.insert(trajectory.end(), step.motion.begin() + (trajectory.empty() ? 0 : 1),
                      step.motion.end());
    if (on_step) on_step(step);
    status = replanner.executed().status;
  }
  result = replanner.executed();
  result.status = status;
  result.trajectory = std::move(trajectory);
  return result;
}

void writeTrajectory(const std::string& file, const Problem& problem,
                     std::span<const TimedPoint> trajectory) {
  validate(problem);
  std::string text = "time";
  for (const int v : problem.robot.variables)
    text += "," + problem.robot.model->variables[static_cast<std::size_t>(v)].name;
  text += "\n";
  for (const TimedPoint& point : trajectory) {
    text += fmt::format("{:.17g}", point.time);
    for (const double x : point.position) text += fmt::format(",{:.17g}", x);
    text += "\n";
  }
  writeFileWhole(file, text);
}

}  // namespace leeway::planner
