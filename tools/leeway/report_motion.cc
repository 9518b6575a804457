#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/exit_status.h"
#include "tools/leeway/report.h"
#include "tools/leeway/report_common.h"
#include "tools/leeway/terminal.h"
#include "tools/report/edges.h"
#include "tools/report/machine.h"
#include "tools/report/motion.h"
#include "tools/report/motion_cases.h"
#include "tools/report/own_motion_engine.h"

namespace leeway::tools {
namespace {

using report::MotionRow;

std::vector<report::NamedProblem> readProblems(const ReportMotionArguments& arguments) {
  std::shared_ptr<const robots::Model> model;
  if (!arguments.robot.empty()) model = robots::loadModel(arguments.robot, arguments.srdf);
  std::vector<report::NamedProblem> problems;
  for (const std::string& file : arguments.problems) {
    std::string request = std::filesystem::path(file).filename();
    if (model && request.rfind("scene", 0) != 0)
      throw robots::InputError(file, 0, "a file named sceneNNNN.yaml is expected");
    if (model) request.replace(0, 5, "request");
    report::NamedProblem named{
        std::filesystem::path(file).parent_path().filename().string() + "/" +
            std::filesystem::path(file).stem().string(),
        model ? planner::loadMoveit(model, file,
                                    std::filesystem::path(file).replace_filename(request))
              : planner::loadProblem(file)};
    named.problem.seed = arguments.seed;
    problems.push_back(std::move(named));
  }
  return problems;
}

/// Wrong, unsafe or open answers of ours, and failures: what the exit status is about.
int ownErrors(const std::vector<MotionRow>& rows, const std::vector<report::EdgeRow>& edges) {
  int errors = 0;
  for (const report::EdgeRow& r : edges) errors += r.method == "certified" ? r.missed : 0;
  for (const MotionRow& r : rows)
    if (r.claims_bounds) errors += r.wrong() + r.undecided + r.failures();
  return errors;
}

}  // namespace

int runReportMotion(const ReportMotionArguments& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<report::NamedProblem> problems = readProblems(arguments);
  const auto own = report::makeOwnMotionEngines();
  std::vector<const report::ContactEngine*> engines;
  for (const auto& engine : own) engines.push_back(engine.get());
  std::vector<std::string> missing;
  const auto modules = loadRivals(arguments.no_rivals, missing);
  for (const report::RivalModule& module : modules)
    if (module.rivals)
      for (const auto& engine : module.rivals->motions) engines.push_back(engine.get());

  report::MotionReportOptions options;
  options.families = arguments.families.empty() ? report::contactFamilies() : arguments.families;
  options.cases = arguments.cases;
  options.passes = arguments.passes;
  options.seed = arguments.seed;
  options.progress = showProgress;
  const int processor = report::pinToOneProcessor();
  const std::vector<MotionRow> rows = report::measureMotion(engines, options);
  report::EdgeReportOptions edge_options;
  edge_options.edges = arguments.edges;
  edge_options.progress = showProgress;
  const std::vector<report::EdgeRow> edges = report::measureEdges(problems, edge_options);
  endProgress();
  const std::string note = fmt::format(
      "{}; seed {}; {} cases a family; one pinned core, of each case the median of {} passes",
      report::machineName(), arguments.seed, arguments.cases, arguments.passes);
  std::vector<std::string> files = {
      writeReportFile(arguments.output, "motion.csv", report::motionCsv(rows)),
      writeReportFile(arguments.output, "motion.svg",
                      report::toSvg(report::motionFigure(rows, note)))};
  if (!problems.empty()) {
    files.push_back(writeReportFile(arguments.output, "edges.csv", report::edgesCsv(edges)));
    files.push_back(writeReportFile(arguments.output, "edges.svg",
                                    report::toSvg(report::edgesFigure(edges, note))));
  }
  const int errors = ownErrors(rows, edges);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (arguments.json) {
    fmt::print("{}\n", nlohmann::json{{"seed", arguments.seed},
                                      {"rows", rows.size()},
                                      {"missing", missing},
                                      {"own_errors", errors},
                                      {"processor", processor},
                                      {"time_s", seconds},
                                      {"files", files}}
                           .dump());
  } else {
    fmt::print("{}\n{}{}\nseed {}, {:.0f} s; in {}: motion.csv, motion.svg{}\n", note,
               report::motionTable(rows), problems.empty() ? "" : report::edgesTable(edges),
               arguments.seed, seconds, arguments.output,
               problems.empty() ? "" : ", edges.csv, edges.svg");
  }
  return errors == 0 ? kYes : kNo;
}

}  // namespace leeway::tools
