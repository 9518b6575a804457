#include "leeway/planner/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/path_io.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/path_ends.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"

namespace leeway::tools {
namespace {

struct VerifyArguments {
  ProblemSource source;
  std::vector<std::string> files;
  PlanOverrides limits;
  std::string ends = "near";
  bool shortest = false;
  bool json = false;
};

std::string resultText(const planner::Path& path, const planner::VerifyResult& result) {
  if (result.status == planner::VerifyStatus::kCertified) {
    const std::string clearance = std::isfinite(result.clearance_lower)
                                      ? fmt::format("every point keeps at least {} mm",
                                                    formatLower(result.clearance_lower * 1e3, 3))
                                      : "there is nothing else that it could touch";
    return fmt::format("certified: {} edges, {}\n{}\n",
                       path.positions.empty() ? 0 : path.positions.size() - 1, clearance,
                       planner::toString(result.unchecked));
  }
  std::string text = toString(result.status);
  if (result.status == planner::VerifyStatus::kNothingChecked)
    return fmt::format("nothing checked: {}\n", result.reason);
  if (result.segment >= 0) {
    text += fmt::format(": edge {} between t = {:.6f} and {:.6f}", result.segment, result.t0,
                        result.t1);
  }
  if (!result.a.empty()) {
    text += fmt::format(", {} and {}", result.a, result.b);
  }
  if (!result.reason.empty()) {
    text += fmt::format(": {}", result.reason);
  }
  return text + "\n";
}

int runVerify(VerifyArguments& arguments) {
  const std::string path_file = takePathFile(arguments.source, arguments.files);
  // A proof takes nothing over that an earlier run made.
  arguments.source.no_cache = true;
  planner::Problem problem = loadProblem(arguments.source, arguments.limits.timeLimit());
  apply(arguments.limits, problem);
  const planner::Path path =
      planner::readPath(path_file, problem, {.shortest = arguments.shortest});
  std::vector<std::string> warnings;
  if (arguments.ends == "near") {
    warnings = takeNearEnds(path, problem);
    for (std::string& warning : warnings) warning.insert(0, path_file + ": ");
    printWarnings(warnings);
  }
  // The proof takes nothing from this scene.
  printWarnings(planner::CompiledScene(problem).warnings());
  planner::PlanOptions options = interactivePlanOptions(arguments.limits.timeLimit());
  UnitProgress progress(std::max<std::size_t>(2, path.positions.size()) - 1);
  options.progress = [&](const std::string& phase, double) { progress.next(phase); };
  const planner::VerifyResult result = planner::verify(problem, path, options);
  endProgress();
  if (arguments.json) {
    Json document = toJson(result);
    document["clouds"] = cloudsJson(problem);
    document["seed"] = problem.seed;
    document["warnings"] = warnings;
    document["interrupted"] = interrupted();
    printJson(document);
  } else {
    fmt::print("{}", resultText(path, result));
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
  app->add_option("--ends", arguments->ends,
                  "near: ends within 1e-6 of start and goal are theirs, with a warning; exact: "
                  "within 1e-9, as rounding leaves them")
      ->check(CLI::IsMember({"near", "exact"}))
      ->capture_default_str();
  addShortest(*app, arguments->shortest);
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Example:\n"
      "  leeway plan problems/shelf/reach.yaml --output path.json && leeway verify "
      "problems/shelf/reach.yaml path.json");
  return {app, [arguments] { return runVerify(*arguments); }};
}

}  // namespace leeway::tools
