#pragma once

// Private to planner/: paths at the velocity limits of the joints, and motions over a time.

#include <span>
#include <vector>

#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// Velocity limits of the planned variables as an execution has them [rad/s or m/s].
std::vector<double> velocityLimits(const Problem& problem);

/// A variable's own velocity limit, kDefaultVelocity where it has none [rad/s or m/s].
double velocityLimit(const robots::Variable& variable);

/// The least time in which a difference of points is gone through at constant speed within limits
/// on velocity; with limits on a higher derivative that derivative's largest share of them. A
/// rotation's limit is that of its first variable.
double timeAtLimits(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> difference);

/// timeAtLimits() of the edge from a to b [s].
double edgeDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> a, std::span<const double> b);

/// Time that a path takes [s].
double pathDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    const std::vector<std::vector<double>>& path);

/// The motion along a path from `time` to `end`; where the path ends before, the rest is standing
/// at its end. `rest` (may be null): the path from there on, one waypoint at its end. The
/// path has at least one waypoint.
std::vector<TimedPoint> travel(const ConfigurationSpace& space, std::span<const double> limits,
                               const std::vector<std::vector<double>>& path, double time,
                               double end, std::vector<std::vector<double>>* rest = nullptr);

/// The part of a motion from t0 to t1, at least two rows; the motion covers that time. The same
/// bytes for an end that two parts share.
std::vector<TimedPoint> partOf(const ConfigurationSpace& space, std::span<const TimedPoint> motion,
                               double t0, double t1);

}  // namespace leeway::planner
