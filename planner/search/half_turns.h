#pragma once

#include <vector>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// Cuts edges in their middles on which a circle makes half a turn so exactly that rounding could
/// send it the other way when the path is unwrapped, as files have it. O(points).
void splitHalfTurns(const ConfigurationSpace& space, std::vector<std::vector<double>>& path);

}  // namespace leeway::planner
