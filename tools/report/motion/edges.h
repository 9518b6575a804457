#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "tools/report/base/plot.h"

namespace leeway::tools::report {

/// The second part of `report motion`: whole edges of a planner, certified with second-order
/// bounds, proven with first-order ones (verify()), and looked at in steps.
struct EdgeReportOptions {
  int edges = 200;  ///< of each problem, evenly out of those that planning and simplifying ask for
  unsigned long long iterations = 2000;  ///< of the planner
  std::function<void(const std::string&)> progress;
};

/// Free edges that come nearer to something than this, their margin apart, are told by themselves
/// [m].
inline constexpr double kNear = 0.01;

/// One way to look at one kind of edges of one problem.
struct EdgeRow {
  std::string problem;
  std::string kind;    ///< "free", "near" or "colliding", by what verify() proves
  std::string method;  ///< "certified", "first order", "1/32", "0.5 %", "1 %"
  int edges = 0;
  int missed = 0;     ///< said free, collides
  int cautious = 0;   ///< said not free, is
  int undecided = 0;  ///< neither
  /// CPU time an edge, the mean: the median of five rounds [us]. Of verify() one round, and what it
  /// takes for an edge of no length is taken off.
  double us = std::numeric_limits<double>::quiet_NaN();
};

struct NamedProblem {
  std::string name;
  planner::Problem problem;
};

/// Steps are 1/32 in the space's distance, and 0.5 % and 1 % of its extent, which OMPL takes by
/// default. Pin the process first.
std::vector<EdgeRow> measureEdges(const std::vector<NamedProblem>& problems,
                                  const EdgeReportOptions& options);

/// One line a row, with a header.
std::string edgesCsv(const std::vector<EdgeRow>& rows);
/// For people: sums over all problems.
std::string edgesTable(const std::vector<EdgeRow>& rows);
/// Microseconds an edge by problem, a panel a kind.
Figure edgesFigure(const std::vector<EdgeRow>& rows, const std::string& note);

}  // namespace leeway::tools::report
