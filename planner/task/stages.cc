#include "planner/task/stages.h"

#include <algorithm>
#include <numbers>

#include "leeway/robots/kinematics.h"
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
  stage.contacts.allowed.insert(stage.contacts.allowed.end(), step.allowed.begin(),
                                step.allowed.end());
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

LinePlace linePlace(const Problem& world, const LineStep& line,
                    std::span<const double> configuration) {
  const bool own_axes = line.relative_to.empty(), world_axes = line.relative_to == "world";
  FramePose pose;
  pose.frame = line.frame;
  pose.relative_to = own_axes || world_axes ? "" : line.relative_to;
  pose.position.fill({0, 0});
  pose.rpy.fill({0, 0});
  const robots::PoseRegion region = regionOf(world, pose);
  std::vector<robots::Pose> X_WL(world.robot.model->links.size());
  robots::forwardKinematics(*world.robot.model, configuration, X_WL);
  LinePlace place{region.link, region.X_LF,
                  X_WL[static_cast<std::size_t>(region.link)] * region.X_LF, line.by};
  if (own_axes) place.along_W = place.X_WF.rotation * line.by;
  if (!own_axes && !world_axes) place.along_W = region.X_WR.rotation * line.by;
  return place;
}

std::string stepText(const Problem& problem, std::size_t step) {
  return "step " + std::to_string(step + 1) + " (" + problem.steps[step].name + ")";
}

}  // namespace leeway::planner
