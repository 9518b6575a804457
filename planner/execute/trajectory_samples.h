#pragma once

// Private to planner/: rows of a trajectory, as files have them.

#include <cstdint>
#include <string_view>
#include <vector>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// What follows a joint's name in the head of a CSV's column.
constexpr std::string_view kVelocityEnding = ".velocity";
constexpr std::string_view kAccelerationEnding = ".acceleration";

/// A trajectory at some times [s], one row each. Velocities and accelerations are the derivatives
/// of the numbers in `positions`, quaternions included.
struct Samples {
  std::vector<double> times;
  std::vector<std::vector<double>> positions, velocities, accelerations;
};

/// At the trajectory's knots, and every `period` seconds if that is above 0. Circles are unwrapped,
/// and successive quaternions are in one half of the sphere. O(rows).
Samples sample(const Trajectory& trajectory, double period);

/// The resolution of times in files.
std::int64_t nanoseconds(double seconds);

}  // namespace leeway::planner
