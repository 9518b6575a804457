#include <fmt/format.h>

#include <filesystem>

#include "leeway/planner/plan.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/batch/batch_list.h"
#include "tools/leeway/report/report_problems.h"
#include "tools/leeway/report/rival_report.h"
#include "tools/leeway/support/terminal.h"
#include "tools/report/base/machine.h"
#include "tools/report/planning/planning_report.h"

namespace leeway::tools {

std::vector<report::PlanningProblem> readProblems(const ReportPlanningArguments& arguments) {
  std::shared_ptr<const robots::Model> model;
  if (!arguments.robot.empty()) model = robots::loadModel(arguments.robot, arguments.srdf);
  std::vector<report::PlanningProblem> problems;
  for (const BatchItem& item :
       model ? listMoveitProblems(arguments.inputs) : listProblems(arguments.inputs)) {
    if (!item.error.empty()) throw robots::InputError(item.problem, 0, item.error);
    planner::Problem problem = model ? planner::loadMoveit(model, item.problem, item.request)
                                     : planner::loadProblem(item.problem);
    if (!problem.steps.empty()) {
      fmt::print(stderr, "without {}: a task has no single path\n", item.problem);
      continue;
    }
    problems.push_back({item.problem,
                        std::filesystem::absolute(item.problem).parent_path().filename().string(),
                        planner::placeStart(problem)});
  }
  return problems;
}

int runReportPlanning(const ReportPlanningArguments& arguments) {
  RivalReport out(arguments.output);
  const std::vector<report::PlanningProblem> problems = readProblems(arguments);
  if (!arguments.no_rivals) out.loadRivals();
  const auto rivals =
      out.engines(std::vector<std::unique_ptr<report::StateEngine>>{}, &report::Rivals::states);
  report::PlanningReportOptions options;
  options.seed = arguments.seed;
  options.seeds = arguments.seeds;
  options.time = arguments.time;
  UnitProgress progress(problems.size() * static_cast<std::size_t>(arguments.seeds));
  options.progress = [&](const std::string& run) { progress.next(run); };
  options.on_rows = [&](const std::vector<report::PlanningRow>& added) {
    out.addRows("planning.csv", report::planningCsv(added));
  };
  RivalReport::End end{arguments.seed};
  end.processor = report::pinToOneProcessor();
  const std::vector<report::PlanningRow> rows = report::measurePlanning(problems, rivals, options);
  endProgress();
  out.write("planning.csv", report::planningCsv(rows));
  for (const report::PlanningRow& row : rows)
    if (row.planner == "Leeway") end.own_errors += row.colliding ? 1 : 0;
  end.text = fmt::format(
      "{}; seeds {} to {}; at most {:g} s a run; one pinned core; lengths are relative to ours\n{}",
      report::machineName(), arguments.seed,
      arguments.seed + static_cast<std::uint64_t>(arguments.seeds) - 1, arguments.time,
      report::planningTable(rows));
  end.count = rows.size();
  return out.end(arguments.json, end);
}

}  // namespace leeway::tools
