#include "planner/task/stages.h"

#include <algorithm>

#include "planner/validate/checks.h"

namespace leeway::planner {

Problem firstWorld(const Problem& problem) {
  Problem world = problem;
  world.steps.clear();
  world.goals.clear();
  return world;
}

Problem stageOf(const Problem& world, const Step& step) {
  Problem stage = world;
  allowPairs(step.allowed, stage.contacts);
  const auto* move = std::get_if<MoveStep>(&step.action);
  if (move == nullptr) return stage;
  Goal goal = move->goal;
  if (!move->poses.empty()) goal = {step.name, {}, {}};
  for (const FramePose& pose : move->poses) goal.poses.push_back(regionOf(world, pose));
  stage.goals = {goal};
  return stage;
}

Problem worldAfter(const Problem& world, const Step& step, std::span<const double> configuration) {
  Problem after = world;
  after.start.assign(configuration.begin(), configuration.end());
  if (const auto* attach = std::get_if<AttachStep>(&step.action))
    return attached(after, attach->object, attach->link, attach->touch, {});
  if (const auto* detach = std::get_if<DetachStep>(&step.action))
    return detached(after, detach->object, {});
  return after;
}

std::string stepText(const Problem& problem, std::size_t step) {
  return "step " + std::to_string(step + 1) + " (" + problem.steps[step].name + ")";
}

}  // namespace leeway::planner
