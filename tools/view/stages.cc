#include "tools/view/stages.h"

#include <algorithm>
#include <set>

#include "collision/base/numbers.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/task/stages.h"

namespace leeway::tools::view {
namespace {

using planner::CompiledScene;
using planner::Problem;

bool holds(const Problem& problem, const std::string& object) {
  const auto& held = problem.robot.attachments;
  return std::any_of(held.begin(), held.end(),
                     [&](const planner::Attachment& a) { return a.object.name == object; });
}

std::vector<double> configuration(const Problem& problem, const std::vector<double>& position) {
  std::vector<double> q = problem.start;
  for (std::size_t i = 0; i < position.size(); ++i) q[at(problem.robot.variables[i])] = position[i];
  return q;
}

void expectSteps(const Problem& problem, const planner::Path& path) {
  // The path of a partly planned task has only the first steps.
  bool fits = !path.steps.empty() && path.steps.size() <= problem.steps.size();
  int next = 0;
  for (const planner::PathStep& step : path.steps) {
    fits = fits && step.first == next && step.last >= step.first;
    next = step.last;
  }
  if (!fits || next + 1 != static_cast<int>(path.positions.size()))
    throw robots::InputError(problem.name, 0,
                             "the path does not have the problem's steps; one that `leeway plan` "
                             "wrote for it is expected");
}

}  // namespace

Problem shownProblem(const Problem& problem) {
  Problem shown = problem;
  shown.steps.clear();  // they refer to a world in which nothing is attached yet
  for (const planner::Step& step : problem.steps)
    if (const auto* attach = std::get_if<planner::AttachStep>(&step.action))
      if (!holds(shown, attach->object))
        shown = planner::attachObject(shown, attach->object, attach->link, attach->touch);
  return shown;
}

Problem firstProblem(const Problem& problem) {
  return problem.steps.empty() ? problem : planner::firstWorld(problem);
}

std::vector<Stage> stagesOf(const Problem& problem,
                            const std::shared_ptr<const CompiledScene>& scene,
                            const planner::Path& path) {
  if (problem.steps.empty())
    return {{{}, {}, 0, static_cast<int>(path.positions.size()) - 1, problem, scene}};
  Problem world = firstProblem(problem);
  if (path.positions.empty())
    return {{{}, {}, 0, 0, world, std::make_shared<const CompiledScene>(world)}};
  expectSteps(problem, path);
  static constexpr const char* kKinds[] = {"move", "line", "attach", "detach"};
  std::vector<Stage> stages;
  for (std::size_t s = 0; s < path.steps.size(); ++s) {
    const planner::Step& step = problem.steps[s];
    const planner::PathStep& stretch = path.steps[s];
    Stage stage{step.name, kKinds[step.action.index()], stretch.first, stretch.last, {}, {}};
    if (const auto* attach = std::get_if<planner::AttachStep>(&step.action))
      stage.object = attach->object;
    if (const auto* detach = std::get_if<planner::DetachStep>(&step.action))
      stage.object = detach->object;
    stage.problem = planner::stageOf(world, step);
    if (stage.last > stage.first)
      stage.scene = std::make_shared<const CompiledScene>(stage.problem);
    stages.push_back(std::move(stage));
    world =
        planner::worldAfter(world, step, configuration(world, path.positions[at(stretch.last)]));
  }
  return stages;
}

std::vector<std::shared_ptr<const CompiledScene>> movingScenes(
    const std::vector<Stage>& stages, const std::shared_ptr<const CompiledScene>& first) {
  std::vector<std::shared_ptr<const CompiledScene>> scenes;
  for (const Stage& stage : stages)
    if (stage.scene) scenes.push_back(stage.scene);
  if (scenes.empty()) scenes.push_back(first);
  return scenes;
}

std::vector<CompiledScene::Dropped> uncheckedIn(
    const std::vector<std::shared_ptr<const CompiledScene>>& scenes) {
  if (scenes.size() == 1) return scenes.front()->dropped();
  std::set<CompiledScene::Dropped> unchecked;
  for (const auto& scene : scenes)
    unchecked.insert(scene->dropped().begin(), scene->dropped().end());
  return {unchecked.begin(), unchecked.end()};
}

std::vector<std::pair<int, collision::Pose>> placedObjects(const Problem& problem,
                                                           const CompiledScene& shown,
                                                           const Problem& world,
                                                           const std::vector<double>& position) {
  std::vector<std::pair<int, collision::Pose>> placed;
  if (problem.steps.empty()) return placed;
  std::vector<collision::Pose> X_WL(shown.model().links.size());
  robots::forwardKinematics(shown.model(), configuration(world, position), X_WL);
  for (const planner::Attachment& held : shownProblem(problem).robot.attachments) {
    const int body = shown.scene().find(held.object.name);
    if (body < 0) continue;
    const collision::Pose X_OL = held.X_LO.inverse();
    for (const planner::Object& object : world.world.objects)
      if (object.name == held.object.name) placed.emplace_back(body, object.X_WO * X_OL);
    for (const planner::Attachment& now : world.robot.attachments)
      if (now.object.name == held.object.name)
        placed.emplace_back(body, X_WL[at(now.link)] * now.X_LO * X_OL);
  }
  return placed;
}

}  // namespace leeway::tools::view
