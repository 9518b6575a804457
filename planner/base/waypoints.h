#pragma once

#include <vector>

namespace leeway::planner {

/// The points of a path, one row each, of a configuration's numbers.
using Waypoints = std::vector<std::vector<double>>;

}  // namespace leeway::planner
