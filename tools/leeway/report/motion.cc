#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/report/report.h"
#include "tools/leeway/report/rival_report.h"
#include "tools/leeway/support/terminal.h"
#include "tools/report/base/machine.h"
#include "tools/report/motion/edge_report.h"
#include "tools/report/motion/motion_cases.h"
#include "tools/report/motion/motion_report.h"
#include "tools/report/motion/own_motion_engine.h"

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
  RivalReport out(arguments.output);
  const std::vector<report::NamedProblem> problems = readProblems(arguments);
  if (!arguments.no_rivals) out.loadRivals();
  const auto own = report::makeOwnMotionEngines();
  const auto engines = out.engines(own, &report::Rivals::motions);

  report::MotionReportOptions options;
  options.families = arguments.families.empty() ? report::contactFamilies() : arguments.families;
  options.cases = arguments.cases;
  options.passes = arguments.passes;
  options.seed = arguments.seed;
  UnitProgress progress(options.families.size() + problems.size());
  options.progress = [&](const std::string& unit) { progress.next(unit); };
  options.on_rows = [&](const std::vector<MotionRow>& added) {
    out.addRows("motion.csv", report::motionCsv(added));
  };
  const int processor = report::pinToOneProcessor();
  const std::vector<MotionRow> rows = report::measureMotion(engines, options);
  report::EdgeReportOptions edge_options;
  edge_options.edges = arguments.edges;
  edge_options.progress = options.progress;
  edge_options.on_rows = [&](const std::vector<report::EdgeRow>& added) {
    out.addRows("edges.csv", report::edgesCsv(added));
  };
  const std::vector<report::EdgeRow> edges = report::measureEdges(problems, edge_options);
  endProgress();
  const std::string note = fmt::format(
      "{}; seed {}; {} cases a family; one pinned core, of each case the median of {} passes",
      report::machineName(), arguments.seed, arguments.cases, arguments.passes);
  out.write("motion.csv", report::motionCsv(rows));
  out.write("motion.svg", report::toSvg(report::motionFigure(rows, note)));
  if (!problems.empty()) {
    out.write("edges.csv", report::edgesCsv(edges));
    out.write("edges.svg", report::toSvg(report::edgesFigure(edges, note)));
  }
  RivalReport::End end{arguments.seed};
  end.text = fmt::format("{}\n{}{}\n", note, report::motionTable(rows),
                         problems.empty() ? "" : report::edgesTable(edges));
  end.count = rows.size();
  end.own_errors = ownErrors(rows, edges);
  end.processor = processor;
  return out.end(arguments.json, end);
}

}  // namespace leeway::tools
