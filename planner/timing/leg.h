#pragma once

// Private to planner/: the legs of a path, and how fast they and their blends are passed.

#include <span>
#include <vector>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// Consecutive edges in one line, which are passed without stopping.
struct Leg {
  int first, last;                ///< waypoints
  double length;                  ///< Euclidean norm of the sum of differences; 0: nothing moves
  std::vector<double> direction;  ///< of unit length
  LineLimits limits;              ///< along it
};

/// Euclidean norm.
double norm(std::span<const double> v);

/// Whether the second edge continues the first in its direction, within kInLine.
bool inLine(std::span<const double> first, std::span<const double> second);

/// Whether the space has orientations of floating joints.
bool hasRotation(const ConfigurationSpace& space);

/// The legs of a path with these differences of its edges. Also ends a leg at each corner of a
/// blend, and at the waypoints in `rests`, ascending. `least_times` as for Trajectory. O(edges).
std::vector<Leg> legsOf(const ConfigurationSpace& space,
                        std::span<const std::vector<double>> differences,
                        std::span<const Blend> blends, const MotionLimits& limits,
                        std::span<const double> least_times, std::span<const int> rests = {});

/// The fastest change from speed `from` on one leg to speed `to` on the next within the limits:
/// its time and ramp.
SpeedChange fastestTurn(const Leg& before, const Leg& after, const MotionLimits& limits,
                        double from, double to);

/// The time of each blend, so that the legs beside it reach its speeds [s]. `leg_of`: the leg
/// before each blend. Blends as Trajectory has checked them.
std::vector<double> blendTimes(std::span<const Leg> legs, std::span<const Blend> blends,
                               std::span<const int> leg_of, const MotionLimits& limits);

}  // namespace leeway::planner
