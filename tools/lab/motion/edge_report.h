#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {

struct EdgeRow;

/// Second part of `report motion`: whole edges of a planner. Methods: certified with second-order
/// bounds, proven with first-order ones (verify()), and checked in steps.
struct EdgeReportOptions {
  int edges = 200;  ///< for each problem, evenly spaced among the edges that planning and
                    ///< simplifying request
  unsigned long long iterations = 2000;  ///< of the planner
  std::function<void(const std::string&)> progress;
  /// Called with the rows of each problem when they are complete.
  std::function<void(const std::vector<EdgeRow>&)> on_rows;
};

/// Free edges whose clearance beyond the margin is below this form a separate kind [m].
inline constexpr double kNear = 0.01;

/// One method on one kind of edges of one problem.
struct EdgeRow {
  std::string problem;
  std::string kind;    ///< "free", "near" or "colliding", as proven by verify()
  std::string method;  ///< "certified", "first order", "1/32", "0.5 %", "1 %"
  int edges = 0;
  int missed = 0;     ///< judged free, but collides
  int cautious = 0;   ///< judged not free, but is free
  int undecided = 0;  ///< neither verdict
  /// Mean CPU time for each edge [us], median of five rounds. verify(): one round, minus the time
  /// for an edge of zero length.
  double us = std::numeric_limits<double>::quiet_NaN();
};

struct NamedProblem {
  std::string name;
  planner::Problem problem;
};

/// Steps: 1/32 in the space's distance, and 0.5 % and 1 % of its extent (1 % is OMPL's default).
/// Pin the process first.
std::vector<EdgeRow> measureEdges(const std::vector<NamedProblem>& problems,
                                  const EdgeReportOptions& options);

/// The rows as they are.
Table edgeRows(const std::vector<EdgeRow>& rows);
/// For people: sums over all problems.
Table edgesTable(const std::vector<EdgeRow>& rows);

}  // namespace leeway::tools::report
