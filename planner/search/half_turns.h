#pragma once

#include <vector>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// Splits edges on which a circle makes almost exactly half a turn at their middles, because
/// rounding could reverse its direction when the path is unwrapped, as in files. O(points).
void splitHalfTurns(const ConfigurationSpace& space, std::vector<std::vector<double>>& path);

}  // namespace leeway::planner
