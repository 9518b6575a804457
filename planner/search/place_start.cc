#include "leeway/planner/plan.h"
#include "leeway/robots/input_error.h"
#include "planner/search/goal_sampler.h"

namespace leeway::planner {

Problem placeStart(const Problem& problem) {
  validate(problem);
  if (problem.start_poses.empty()) return problem;
  Problem placed = problem;
  placed.start_poses.clear();
  Problem task = placed;  // its goal is the start
  task.steps.clear();
  task.goals = {{"of the start", {}, problem.start_poses}};
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(task));
  GoalSampler sampler(certifier, task, problem.seed);
  const GoalPoints points = sampler.first([] { return false; });
  if (!points.reason.empty()) throw robots::InputError(problem.name, 0, points.reason);
  // If no start is valid, planning reports what is in the way of the nearest.
  const std::vector<double>& start =
      points.points.empty() ? sampler.found(0).front() : points.points.front();
  for (std::size_t i = 0; i < start.size(); ++i)
    placed.start[static_cast<std::size_t>(placed.robot.variables[i])] = start[i];
  return placed;
}

}  // namespace leeway::planner
