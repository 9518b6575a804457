#include <fmt/format.h>

#include <filesystem>

#include "leeway/planner/plan.h"
#include "leeway/robots/input_error.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/report_problems.h"
#include "tools/lab/report/rival_report.h"
#include "tools/leeway/batch/batch_list.h"

namespace leeway::tools {

std::vector<report::PlanningProblem> readProblems(const report::ProblemReportOptions& options) {
  std::shared_ptr<const robots::Model> model;
  if (!options.robot.empty()) model = robots::loadModel(options.robot, options.srdf);
  std::vector<report::PlanningProblem> problems;
  for (const BatchItem& item :
       model ? listMoveitProblems(options.inputs) : listProblems(options.inputs)) {
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

int runReportPlanning(report::PlanningReportOptions options) {
  RivalReport out(options);
  const std::vector<report::PlanningProblem> problems = readProblems(options);
  const auto rivals = out.rivals(&report::Rivals::states);
  options.progress = out.begin(problems.size() * static_cast<std::size_t>(options.seeds));
  options.on_rows = out.keep("planning", report::planningRows);
  const std::vector<report::PlanningRow> rows = report::measurePlanning(problems, rivals, options);
  out.note(
      fmt::format("{} seeds; at most {:g} s a run; one pinned core; lengths are relative to ours",
                  options.seeds, options.time));
  out.write("planning", report::planningRows(rows));
  RivalReport::End end{{report::planningTable(rows), report::slowestRuns(rows)}};
  for (const report::PlanningRow& row : rows)
    if (row.planner == "Leeway") end.own_errors += row.colliding ? 1 : 0;
  end.count = rows.size();
  return out.end(end);
}

}  // namespace leeway::tools
