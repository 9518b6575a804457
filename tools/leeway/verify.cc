#include "leeway/planner/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/path_io.h"
#include "planner/validate/checks.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/path_ends.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {
namespace {

struct VerifyArguments {
  ProblemSource source;
  std::vector<std::string> files;
  std::string log;
  PlanOverrides limits;
  std::string ends = "near";
  bool shortest = false;
  bool json = false;
};

/// The proven parts, for people: "3 edges", and the obstacles that move.
struct Proven {
  std::string parts, obstacles;
};

/// The result for people. The first line has the verdict.
std::string resultText(const planner::Problem& problem, const Proven& proven,
                       const planner::VerifyResult& result) {
  const bool certified = result.status == planner::VerifyStatus::kCertified;
  std::string text =
      problem.name + ": " +
      verdictText(result.status == planner::VerifyStatus::kNothingChecked ? "nothing checked"
                                                                          : toString(result.status),
                  certified);
  if (certified) {
    const planner::Interval clearance{result.clearance_lower, result.clearance_upper};
    text +=
        fmt::format(", {}, {}{}\n", proven.parts,
                    std::isfinite(clearance.lower) ? "least clearance " + clearanceText(clearance)
                                                   : "there is nothing else that it could touch",
                    proven.obstacles);
    if (!result.closest_a.empty())
      text += fmt::format("Nearest: {} and {}.\n", result.closest_a, result.closest_b);
    text += planner::toString(result.unchecked) + ".\n";
    for (const planner::Constraint& constraint : problem.constraints)
      text += fmt::format("Constraint '{}' holds everywhere, proven.\n", constraint.name);
    return text;
  }
  if (result.status == planner::VerifyStatus::kNothingChecked)
    return fmt::format("{}: {}\n", text, result.reason);
  if (result.segment >= 0) {
    const std::string from = fmt::format("{:.6g}", result.t0),
                      to = fmt::format("{:.6g}", result.t1);
    text += from == to ? fmt::format(": edge {} at t = {}", result.segment, from)
                       : fmt::format(": edge {} between t = {} and {}", result.segment, from, to);
  }
  if (result.line > 0) {
    const std::string from = fmt::format("{:.6g}", result.t0),
                      to = fmt::format("{:.6g}", result.t1);
    text += fmt::format(": line {}", result.line);
    if (result.t0 != 0 || result.t1 != 0)
      text += from == to ? fmt::format(" at {} s", from)
                         : fmt::format(" between {} s and {} s", from, to);
  }
  if (!result.a.empty()) text += fmt::format(", {} and {}", result.a, result.b);
  if (!result.reason.empty()) text += fmt::format(": {}", result.reason);
  return text + "\n";
}

/// Reads the path, and proves it.
planner::VerifyResult verifyPath(const std::string& file, const VerifyArguments& arguments,
                                 planner::Problem& problem, planner::PlanOptions& options,
                                 const std::function<bool(const planner::Interval&)>& is_enough,
                                 std::vector<std::string>& warnings, Proven& proven) {
  const planner::Path path = planner::readPath(
      file, problem, {.shortest = arguments.shortest, .cubics = true, .warnings = &warnings});
  if (arguments.ends == "near")
    for (const std::string& warning : takeNearEnds(path, problem))
      warnings.push_back(file + ": " + warning);
  if (path.times.empty() &&
      std::any_of(problem.steps.begin(), problem.steps.end(), [](const planner::Step& step) {
        const auto* line = std::get_if<planner::LineStep>(&step.action);
        return line != nullptr && std::isfinite(line->speed);
      }))
    warnings.push_back(file +
                       ": is proven without times, so that the speed of lines is not; trajectories "
                       "with velocities of joints are proven with it");
  printWarnings(warnings);
  UnitProgress progress(std::max<std::size_t>(2, path.positions.size()) - 1);
  options.progress = [&](const std::string& phase, double) {
    phase == "edge" ? progress.next(phase) : progress.after(phase);
  };
  proven = {counted(path.positions.empty() ? 0 : path.positions.size() - 1, "edge"),
            obstaclesText(problem)};
  return planner::verify(problem, path, options, is_enough);
}

int runVerify(VerifyArguments& arguments) {
  const bool is_log = !arguments.log.empty();
  std::string path_file;
  if (!is_log) {
    path_file = takePathFile(arguments.source, arguments.files);
  } else {
    if (arguments.files.size() > 1 || arguments.files.empty() != !arguments.source.robot.empty())
      badUsage("with --log, a problem file alone, or --robot alone, is expected");
    if (!arguments.files.empty()) arguments.source.problem = arguments.files.front();
  }
  // A proof uses no results of earlier runs.
  arguments.source.no_cache = true;
  arguments.source.places_start = is_log;
  planner::Problem problem = loadProblem(arguments.source, arguments.limits);
  if (is_log) refuseSteps(problem, "verify --log");
  planner::PlanOptions options = interactivePlanOptions(arguments.limits.timeLimit());
  // People see the clearance with two decimals. JSON has the bound that proving the margins gives.
  std::function<bool(const planner::Interval&)> is_enough;
  if (!arguments.json)
    is_enough = [](const planner::Interval& clearance) { return figureOf(clearance).has_value(); };
  std::vector<std::string> warnings = planner::problemWarnings(problem);
  // The proof does not use this scene.
  const std::vector<std::string> of_scene = planner::CompiledScene(problem).warnings();
  warnings.insert(warnings.end(), of_scene.begin(), of_scene.end());
  Proven proven{"all steps of " + arguments.log,
                "; the obstacles moved within what is known of them"};
  if (is_log) {
    printWarnings(warnings);
    if (obstaclesText(problem).empty()) proven.obstacles.clear();
  }
  const planner::VerifyResult result =
      is_log ? planner::verifyLog(problem, arguments.log, options, is_enough)
             : verifyPath(path_file, arguments, problem, options, is_enough, warnings, proven);
  endProgress();
  if (arguments.json) {
    Json document = toJson(result);
    document["clouds"] = planner::cloudsJson(problem);
    document["seed"] = problem.seed;
    document["warnings"] = warnings;
    document["interrupted"] = interrupted();
    printJson(document);
  } else {
    fmt::print("{}", wrapped(resultText(problem, proven, result)));
  }
  return result.status == planner::VerifyStatus::kCertified ? kYes : kNo;
}

}  // namespace

Verb addVerify(CLI::App& command) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* app =
      command.add_subcommand("verify", "prove or refute a path, independently of what planned it");
  addProblemAndPathArguments(*app, arguments->source, arguments->files);
  addRunLimits(*app, arguments->limits);
  addTerms(*app, arguments->limits);
  app->add_option("--ends", arguments->ends,
                  "near: the path may begin and end within 1e-6 of start and goal, with a warning; "
                  "exact: within 1e-9")
      ->check(CLI::IsMember({"near", "exact"}))
      ->capture_default_str();
  addShortest(*app, arguments->shortest);
  app->add_option(
         "--log", arguments->log,
         "prove the log of an execution, which `replan --output` writes, instead of a path")
      ->type_name("FILE")
      ->excludes(app->get_option("--ends"), app->get_option("--shortest"));
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Examples:\n"
      "  leeway plan problems/shelf/reach.yaml --output path.json && leeway verify "
      "problems/shelf/reach.yaml path.json\n"
      "  leeway replan problems/moving/conveyor.yaml --output run.jsonl && leeway verify "
      "problems/moving/conveyor.yaml --log run.jsonl");
  return {app, [arguments] { return runVerify(*arguments); }};
}

}  // namespace leeway::tools
