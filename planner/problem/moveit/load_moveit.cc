// Reads MoveIt's planning scene and motion plan request as YAML, as MotionBenchMaker writes them.

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <string>

#include "planner/problem/fail_at.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/moveit/header_frames.h"
#include "planner/problem/read_meshes.h"
#include "robots/base/read_file.h"
#include "robots/base/read_on.h"

namespace leeway::planner {
namespace {

void warnAt(const YamlReader& place, const std::string& what, Problem& problem) {
  problem.warnings.push_back(
      fmt::format("{}:{}: {} {}", place.file(), place.line(), place.where(), what));
}

/// Warns of a scene that is a change of another one, which is not known.
void warnOfChange(const YamlReader& scene, Problem& problem) {
  if (const auto diff = scene.find("is_diff"); hasContent(diff) && readMoveitBoolean(*diff))
    warnAt(*diff, "is true: objects and contacts of the scene that it changes are not known here",
           problem);
}

/// Warns of settings of the request that other keys give here.
void warnOfSettings(const YamlReader& request, Problem& problem) {
  for (const auto& [key, setting] :
       {std::pair("max_velocity_scaling_factor", "execution.speed"),
        std::pair("max_acceleration_scaling_factor", "execution.accelerations")})
    if (const auto factor = request.find(key);
        hasContent(factor) && factor->number() != 0 && factor->number() != 1)
      warnAt(*factor, fmt::format("is left out; {} says it", setting), problem);
  if (const auto speed = request.find("max_cartesian_speed");
      hasContent(speed) && speed->number() > 0)
    warnAt(*speed, "is left out: only speeds of joints are limited", problem);
}

}  // namespace

Problem loadMoveitUnpadded(std::shared_ptr<const robots::Model> model,
                           const std::string& scene_path, const std::string& request_path,
                           const ProblemOptions& options, LinkPadding& padding) {
  Problem problem;
  problem.robot.model = std::move(model);
  problem.name = std::filesystem::path(scene_path).stem().string();
  problem.start = problem.robot.model->defaultConfiguration();

  robots::InputErrors* errors = options.load.errors;
  const YamlReader request = YamlReader::load(request_path, options.load.stop, errors);
  robots::readOn(errors, [&] { expectMessage(request, "MotionPlanRequest"); });
  readRequestGroup(request, problem);
  std::optional<YamlReader> scene;
  if (robots::endingOf(scene_path) == ".scene")
    readTextScene(scene_path, options.load, problem);
  else
    scene = YamlReader::load(scene_path, options.load.stop, errors);
  robots::readOn(errors, [&] {
    if (scene) expectMessage(*scene, "PlanningScene");
  });
  HeaderFrames frames(problem, options.load.stop);
  const YamlReader* const messages = scene ? &*scene : nullptr;
  robots::readOn(errors, [&] { readRequestStart(messages, request, frames, problem); });
  if (!scene && !problem.world.objects.empty()) frames.warnOfPlacedBase(scene_path, 1, "the scene");
  robots::readOn(errors, [&] {
    if (scene) warnOfChange(*scene, problem);
  });
  robots::readOn(errors, [&] {
    if (scene) frames.readTransforms(*scene);
  });
  robots::readOn(errors, [&] {
    if (scene) readSceneObjects(*scene, options.load, frames, problem);
  });
  robots::readOn(errors,
                 [&] { readAttachedObjects(messages, request, options.load, frames, problem); });
  robots::readOn(errors, [&] {
    if (scene) readAllowedCollisions(*scene, problem);
  });
  robots::readOn(errors, [&] {
    if (scene) padding = readLinkPadding(*scene, *problem.robot.model);
  });
  robots::readOn(errors, [&] { readRequestGoals(request, frames, problem); });
  robots::readOn(errors, [&] {
    if (const auto time = request.find("allowed_planning_time"); time && time->sizeNumber() > 0)
      problem.limits.time = time->number();
  });
  robots::readOn(errors, [&] { warnOfSettings(request, problem); });
  return problem;
}

Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path, const ProblemOptions& options) {
  if (!model) throw robots::InputError("", 0, "a model is missing; one of loadModel() is expected");
  LinkPadding padding;
  const robots::ErrorsSince wrong(options.load.errors);
  std::set<std::string> found;
  ProblemOptions noting = options;
  if (noting.load.meshes_found == nullptr) noting.load.meshes_found = &found;
  Problem problem = loadMoveitUnpadded(std::move(model), scene_path, request_path, noting, padding);
  wrong.throwFirst();
  if (options.load.meshes_found == nullptr)
    expectMeshesFound(options.load, found, scene_path, problem);
  applyLinkPadding(padding, problem);
  warnOfOpenMeshes(scene_path, problem);
  return validated(std::move(problem), request_path);
}

World loadMoveitWorld(const std::string& scene_path, const ProblemOptions& options,
                      std::vector<std::string>& warnings) {
  Problem problem;
  problem.robot.model = std::make_shared<const robots::Model>(robots::RobotDescription());
  readTextScene(scene_path, options.load, problem);
  warnOfOpenMeshes(scene_path, problem);
  warnings.insert(warnings.end(), problem.warnings.begin(), problem.warnings.end());
  return std::move(problem.world);
}

}  // namespace leeway::planner
