#pragma once

// Private to planner/: joints that are not planned.

#include <optional>
#include <string>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Returns a warning if a joint that is not planned stands outside the robot's own limits.
std::optional<std::string> passiveWarning(const Problem& problem, int variable);

}  // namespace leeway::planner
