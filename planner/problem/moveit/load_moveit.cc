// MoveIt's planning scene and motion plan request as YAML, as MotionBenchMaker writes them.

#include <filesystem>

#include "planner/problem/moveit/fields.h"

namespace leeway::planner {

Problem loadMoveitUnpadded(std::shared_ptr<const robots::Model> model,
                           const std::string& scene_path, const std::string& request_path,
                           const ProblemOptions& options, LinkPadding& padding) {
  Problem problem;
  problem.robot.model = std::move(model);
  const std::filesystem::path path = scene_path;
  problem.name = path.stem().string();
  problem.start = problem.robot.model->defaultConfiguration();

  const YamlReader request = YamlReader::load(request_path, options.load.stop);
  readRequestGroup(request, problem);
  std::optional<YamlReader> scene;
  if (path.extension() == ".scene")
    readTextScene(scene_path, options.load, problem);
  else
    scene = YamlReader::load(scene_path, options.load.stop);
  if (scene) readSceneObjects(*scene, options.load, problem);
  // The start is the request's: the scene's robot_state is all zeros in every file of
  // MotionBenchMaker.
  readRequestStart(request, problem);
  readAttachedObjects(scene ? &*scene : nullptr, request, options.load, problem);
  if (scene) {
    readAllowedCollisions(*scene, problem);
    padding = readLinkPadding(*scene, *problem.robot.model);
  }
  readRequestGoals(request, problem);
  if (const auto time = request.find("allowed_planning_time"); time && time->number() > 0)
    problem.limits.time = time->number();
  return problem;
}

Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path, const ProblemOptions& options) {
  LinkPadding padding;
  Problem problem =
      loadMoveitUnpadded(std::move(model), scene_path, request_path, options, padding);
  applyLinkPadding(padding, problem);
  return problem;
}

}  // namespace leeway::planner
