#pragma once

// Private to planner/: limits on the velocity of planned variables. See also motionLimits() in
// trajectory.h.

#include <vector>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// Velocity limits of the planned variables in an execution [rad/s or m/s].
std::vector<double> velocityLimits(const Problem& problem);

/// A variable's own velocity limit; kDefaultVelocity if it has none [rad/s or m/s].
double velocityLimit(const robots::Variable& variable);

/// Throws std::invalid_argument unless there are `size` positive limits of each kind, all finite
/// but those of jerk, which may be left out.
void requireLimits(const MotionLimits& limits, std::size_t size);

}  // namespace leeway::planner
