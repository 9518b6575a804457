#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/lab/base/state_engine.h"
#include "tools/lab/planning/planning_report.h"

namespace leeway::tools::report {

struct ClearanceRow;

struct ClearanceReportOptions : ProblemReportOptions {
  std::vector<double> times = {0.01, 0.1, 1, 10, 30};  ///< limits of a run [s]
  double hinge = 0.1;                                  ///< of the integral [m]
  double resolution = 0.01;  ///< the rivals' step: a share of the space's extent
  int samples = 1000;        ///< of a path, for its dense clearance and integral
  /// Called with the rows of each run when they are complete.
  std::function<void(const std::vector<ClearanceRow>&)> on_rows;
};

/// One planner on one problem with one objective, seed and limit. Clearances are from the world.
struct ClearanceRow {
  std::string problem, set, planner;
  std::string objective;  ///< "least": the least clearance; "integral": the integral of a hinge
  std::uint64_t seed = 0;
  double time = 0;          ///< limit [s]
  std::string status = {};  ///< as in PlanningRow
  double took = 0;          ///< total wall clock [s]
  /// Computed by the distance engine at dense samples: least clearance [m] and integral of the
  /// hinge.
  double least = std::numeric_limits<double>::quiet_NaN();
  double integral = std::numeric_limits<double>::quiet_NaN();
  double length = 0;
  bool colliding = false;  ///< as in PlanningRow
  bool unsound = false;    ///< ours: the reported interval does not contain the dense value

  bool solved() const { return status == "solved"; }
};

/// Runs our planner, for the greatest least clearance and for the least integral, and OMPL's BIT*,
/// PRM* and RRT* with its own objectives (MaximizeMinClearanceObjective,
/// StateCostIntegralObjective), in steps, with each engine's distances. Every limit is a separate
/// run. Rivals use the goals that measurePlanning()'s rivals use.
std::vector<ClearanceRow> measureClearance(const std::vector<PlanningProblem>& problems,
                                           const std::vector<const StateEngine*>& rivals,
                                           const ClearanceReportOptions& options);

/// All members of the rows.
Table clearanceRows(const std::vector<ClearanceRow>& rows);
/// By objective, planner and limit: solved, colliding, medians of dense clearance and integral.
Table clearanceTable(const std::vector<ClearanceRow>& rows);

}  // namespace leeway::tools::report
