#pragma once

#include <vector>

#include "tools/leeway/report/report.h"
#include "tools/report/planning/planning_report.h"

namespace leeway::tools {

/// The problems that a report is asked for, without tasks, of which it tells. Throws
/// robots::InputError.
std::vector<report::PlanningProblem> readProblems(const ReportPlanningArguments& arguments);

}  // namespace leeway::tools
