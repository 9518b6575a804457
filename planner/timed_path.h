#pragma once

// Private to planner/: paths at the velocity limits of the joints, and motions over a time.

#include <span>
#include <vector>

#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// Velocity limits of the planned variables as an execution has them [rad/s or m/s].
std::vector<double> velocityLimits(const Problem& problem);

/// The least time in which the edge from a to b keeps the limits [s]; a rotation turns at the limit
/// of its first variable.
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
