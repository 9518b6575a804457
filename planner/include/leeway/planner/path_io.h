#pragma once

#include <string>

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// Reads .json, .yaml, .csv or .path by its ending; columns are matched to the problem's planned variables by name (.path: by order). Throws robots::InputError.
Path readPath(const std::string& file, const Problem& problem);

/// Writes by ending, whole or not at all (temporary name, then rename). Throws robots::InputError when it cannot, leaving an existing file as it was.
void writePath(const std::string& file, const Problem& problem, const PlanResult& result);

}  // namespace leeway::planner
