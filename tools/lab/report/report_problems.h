#pragma once

#include <vector>

#include "tools/lab/planning/planning_report.h"

namespace leeway::tools {

/// The problems of a report. Tasks are left out, with a line on stderr. Throws robots::InputError.
std::vector<report::PlanningProblem> readProblems(const report::ProblemReportOptions& options);

}  // namespace leeway::tools
