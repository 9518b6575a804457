#pragma once

// Private to planner/: limits on the velocity of planned variables. See also motionLimits() in
// trajectory.h.

#include <span>
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

/// The largest ratio of a variable's difference to its limit. A rotation uses the limit of its
/// first variable. For velocity limits, this is the least time [s] of the difference at constant
/// speed.
double timeAtLimits(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> difference);

}  // namespace leeway::planner
