#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "tools/lab/base/report_options.h"
#include "tools/lab/base/state_engine.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {

struct PlanningProblem {
  std::string name;  ///< the file
  std::string set;   ///< its folder's name: problems of one set share a row of the table
  planner::Problem problem;
};
struct PlanningRow;

/// Options of reports on problems.
struct ProblemReportOptions : ReportOptions {
  std::vector<std::string> inputs;  ///< as those of `batch`
  std::string robot, srdf;          ///< inputs then are MoveIt scenes, requests beside them
  int seeds = 1;                    ///< runs of each problem, each with its own seed
};

struct PlanningReportOptions : ProblemReportOptions {
  double time = 10;          ///< limit of one run [s]
  double resolution = 0.01;  ///< the rival's step: a share of the space's extent
  /// Called with the rows of each run when they are complete.
  std::function<void(const std::vector<PlanningRow>&)> on_rows;
};

/// One planner on one problem with one seed.
struct PlanningRow {
  std::string problem, set, planner;
  std::uint64_t seed = 0;
  /// As toString(PlanStatus); "left out": the rival lacks a shape or the goal.
  std::string status = {};
  /// Wall clock [s]. The rival's compile_s makes its shapes; its only later stage is its
  /// simplifier.
  double compile_s = 0, plan_s = 0, simplify_s = 0, improve_s = 0, push_s = 0, certify_s = 0;
  std::uint64_t iterations = 0;
  double length = 0;
  /// Some edge of the path is in contact, as our certifier proves. Margins count as 0 for the
  /// rival, which has none.
  bool colliding = false;

  bool solved() const { return status == "solved"; }
  double whole() const { return compile_s + plan_s + simplify_s + improve_s + push_s + certify_s; }
};

/// Runs our planner as the problems specify it, and OMPL's RRTConnect in steps, with its
/// simplifier, over each of the engines. The rival plans to the goals that are single
/// configurations; if there are none, to the end of our path.
std::vector<PlanningRow> measurePlanning(const std::vector<PlanningProblem>& problems,
                                         const std::vector<const StateEngine*>& rivals,
                                         const PlanningReportOptions& options);

/// All members of the rows.
Table planningRows(const std::vector<PlanningRow>& rows);
/// By set and planner: solved, median and 95 % of times and lengths, shares of the stages.
Table planningTable(const std::vector<PlanningRow>& rows);
/// Our slowest runs; those that are not solved come first.
Table slowestRuns(const std::vector<PlanningRow>& rows);

}  // namespace leeway::tools::report
