// MoveIt's planning scene and motion plan request as YAML, as MotionBenchMaker writes them.

#include <filesystem>

#include "planner/problem/moveit/fields.h"

namespace leeway::planner {

Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path) {
  Problem problem;
  problem.robot.model = std::move(model);
  problem.name = std::filesystem::path(scene_path).stem().string();
  problem.start = problem.robot.model->defaultConfiguration();

  const YamlReader scene = YamlReader::load(scene_path);
  const YamlReader request = YamlReader::load(request_path);
  readRequestGroup(request, problem);
  readSceneObjects(scene, problem);
  readAllowedCollisions(scene, problem);

  // The start is the request's: the scene's robot_state is all zeros in every file of
  // MotionBenchMaker. Things held there would be lost.
  if (const auto state = scene.find("robot_state"); state && state->isMap())
    refuseContent(*state, "attached_collision_objects", "a scene without attached objects");
  readRequestStates(request, problem);
  if (const auto time = request.find("allowed_planning_time"); time && time->number() > 0)
    problem.limits.time = time->number();
  return problem;
}

}  // namespace leeway::planner
