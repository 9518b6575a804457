#pragma once

#include <functional>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Returns the problem with its planned joints at values for these poses, as placeStart() finds
/// them for a start. `what`: "goal 'reach'", with which the message of an error begins. Throws as
/// placeStart() does, and compiles the problem.
Problem placedAt(const Problem& problem, const std::vector<robots::PoseRegion>& poses,
                 const std::string& what, const std::function<bool()>& stop = {});

}  // namespace leeway::planner
