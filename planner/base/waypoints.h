#pragma once

#include <vector>

namespace leeway::planner {

/// The points of a path: one configuration per row.
using Waypoints = std::vector<std::vector<double>>;

}  // namespace leeway::planner
