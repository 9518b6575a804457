#pragma once

// Private to planner/: paths at the velocity limits of the joints, and motions over a time.

#include <span>
#include <vector>

#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// The largest ratio of a variable's difference to its limit; a rotation's limit is that of its
/// first variable. For limits on velocity: the least time [s] that the difference takes at constant
/// speed.
double timeAtLimits(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> difference);

/// timeAtLimits() of the edge from a to b [s].
double edgeDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> a, std::span<const double> b);

/// Time of a path at its velocity limits [s].
double pathDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    const std::vector<std::vector<double>>& path);

/// The motion along a path (at least one waypoint) from `time` to `end`; a path that ends before
/// stands at its end. `rest`, unless null, is set to the path that is left: at least one waypoint.
std::vector<TimedPoint> travel(const ConfigurationSpace& space, std::span<const double> limits,
                               const std::vector<std::vector<double>>& path, double time,
                               double end, std::vector<std::vector<double>>* rest = nullptr);

/// The part of a motion from t0 to t1, which the motion covers: at least two rows. Two parts that
/// meet have the same bytes there.
std::vector<TimedPoint> partOf(const ConfigurationSpace& space, std::span<const TimedPoint> motion,
                               double t0, double t1);

}  // namespace leeway::planner
