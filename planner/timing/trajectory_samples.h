#pragma once

// Private to planner/: the rows of a trajectory in files.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// Endings of a joint's name in the header of a CSV file.
constexpr std::string_view kVelocityEnding = ".velocity";
constexpr std::string_view kAccelerationEnding = ".acceleration";

/// The interpolation of motions with blends: each variable moves on cubics through positions and
/// velocities of rows.
constexpr std::string_view kCubic = "cubic";

/// A trajectory at a number of times [s], one row each. Velocities and accelerations are the
/// derivatives of the numbers in `positions`, also for quaternions.
struct Samples {
  std::vector<double> times;
  std::vector<std::vector<double>> positions, velocities, accelerations;
  std::vector<PathStep> steps;  ///< of a task, in numbers of the rows
};

/// Samples the trajectory at its knots, and every `period` seconds if that is above 0. Unwraps
/// circles, and keeps successive quaternions in one half of the sphere. O(rows).
Samples sample(const Trajectory& trajectory, double period);

/// A variable at the time of a row.
struct RowMotion {
  double position, velocity, acceleration;
};

/// How far the quintic through two rows that are `time` [s] apart may be from the cubic through
/// their positions and velocities, at most: with the differences of accelerations at the ends times
/// s^2 (1 - s)^3 / 2, whose greatest value is 0.01728.
double quinticDeparture(double time, const RowMotion& begin, const RowMotion& end);

/// Whether quintics through the rows are the cubics, to kQuinticSlack. False where accelerations
/// jump, as they do without limits on jerk. O(rows).
bool areQuinticsCubic(const Samples& samples);

/// Adds those of some ascending times that are at least kLeastRow from all others in `times`, which
/// stay ascending. O(times).
void addSpaced(std::span<const double> added, std::vector<double>& times);

/// Rounds a time to the resolution of times in files.
std::int64_t nanoseconds(double seconds);

}  // namespace leeway::planner
