#pragma once

// Private to planner/: paths at the velocity limits of the joints, and motions over a time.

#include <span>
#include <vector>

#include "leeway/planner/replanner.h"

namespace leeway::planner {

/// timeAtLimits() of the edge from a to b [s].
double edgeDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> a, std::span<const double> b);

/// The duration of a path at its velocity limits [s].
double pathDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    const std::vector<std::vector<double>>& path);

/// The part of a motion from t0 to t1, which must lie within the motion: at least two rows. Two
/// parts that meet have the same bytes there.
std::vector<TimedPoint> partOf(const ConfigurationSpace& space, std::span<const TimedPoint> motion,
                               double t0, double t1);

}  // namespace leeway::planner
