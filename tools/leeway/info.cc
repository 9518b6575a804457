#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/info/description.h"
#include "tools/leeway/info/input.h"
#include "tools/leeway/info/tables.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/verb.h"

namespace leeway::tools {
namespace {

struct InfoArguments {
  ProblemSource source;
  std::string file;
  int samples = 500;
  std::uint64_t seed = 1;
  bool all = false;
  bool json = false;
};

int runInfo(const InfoArguments& arguments) {
  const info::FileKind kind = info::kindOf(arguments.file);
  const planner::Problem problem = info::loadFile(arguments.file, kind, arguments.source);
  // Only a robot with a joint that moves can be compiled.
  std::optional<planner::CompiledScene> scene;
  if (!problem.robot.variables.empty()) {
    scene.emplace(problem);
    printWarnings(scene->warnings());
  }
  Json document = {{"file", arguments.file}, {"robot", info::robotJson(*problem.robot.model)}};
  if (kind == info::FileKind::kProblem) {
    document["problem"] = info::problemJson(problem);
  }
  document["geometries"] = info::geometriesJson(problem);
  document["compiled"] =
      scene ? info::compiledJson(*scene, arguments.samples, arguments.seed) : Json();
  if (arguments.json) {
    printJson(document);
    return kYes;
  }
  if (kind == info::FileKind::kProblem) {
    info::printProblem(document["problem"]);
  }
  info::printRobot(document["robot"], arguments.all);
  // Both tables are on one screen of 24 lines if they have few rows together.
  constexpr std::size_t kRows = 10;
  const std::size_t rows = document["geometries"].size() + document["robot"]["variables"].size();
  info::printGeometries(document["geometries"], arguments.all, !arguments.all && rows > kRows);
  if (scene) {
    info::printCompiled(document["compiled"], arguments.all);
  } else {
    fmt::print("no joint can move: there is nothing to plan\n");
  }
  return kYes;
}

}  // namespace

Verb addInfo(CLI::App& command) {
  auto arguments = std::make_shared<InfoArguments>();
  arguments->source.needs_goal = false;  // a guard's file has none
  CLI::App* app = command.add_subcommand(
      "info", "list what a URDF, SRDF or problem contains, and which pairs are checked");
  app->add_option("file", arguments->file, "URDF (or MJCF, SDF), SRDF or problem file")
      ->type_name("FILE")
      ->required();
  addRobotArguments(*app, arguments->source);
  addSamples(*app,
             "number of random configurations in which contacts of links are counted; 0: none",
             arguments->samples, arguments->seed);
  app->add_flag("--all", arguments->all, "print all rows, not only the first or the sums");
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer("Example:\n  leeway info problems/shelf/reach.yaml");
  return {app, [arguments] { return runInfo(*arguments); }};
}

}  // namespace leeway::tools
