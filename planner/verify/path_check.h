#pragma once

// Private to planner/: the verifier's checks of a path that need no geometry.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/verify.h"

namespace leeway::planner::verification {

struct PathFault {
  std::size_t waypoint;
  std::string reason;
};

/// The motion of one variable between two rows of a path: a cubic polynomial in t in [0, 1].
class Cubic {
 public:
  /// Positions, and velocities times the duration, at both ends.
  Cubic(double q0, double q1, double v0, double v1);
  double at(double t) const;
  double least() const { return least_; }
  double most() const { return most_; }
  /// Bounds the derivative's absolute value.
  double speed() const { return speed_; }
  /// The first and second derivatives at t, and the third, which is constant.
  double velocity(double t) const { return c1_ + t * (2 * c2_ + t * 3 * c3_); }
  double acceleration(double t) const { return 2 * c2_ + 6 * c3_ * t; }
  double jerk() const { return 6 * c3_; }
  /// Whether at() rounds by no more than interpolation along lines does.
  bool isShort() const;

 private:
  double q0_, q1_, c1_, c2_, c3_;
  double least_, most_, speed_;
};

/// A variable's limits in an execution, as the robot and the problem state them; infinite where
/// neither does, except that velocity then is kDefaultVelocity.
struct StatedLimits {
  double velocity, acceleration, jerk;  ///< [rad/s, rad/s^2, rad/s^3, or m]
};
StatedLimits statedLimits(const Problem& problem, const robots::Variable& variable);

/// The cubics between two rows of a path with times.
std::vector<Cubic> cubicsOf(const Path& path, std::size_t segment);

/// Returns the first fault of a path: wrong columns, a waypoint that is not finite or is outside
/// the limits, times or velocities that are none, a cubic that leaves the limits or exceeds those
/// of statedLimits(), a motion with times that does not begin and end at rest, a first waypoint
/// that is not the start, and, with `ends_in_goal`, a last waypoint that is in no goal. Returns
/// nothing if the path has no fault.
std::optional<PathFault> findFault(const Problem& problem, const ConfigurationSpace& space,
                                   const Path& path, bool ends_in_goal = true);

/// Whether a waypoint is in one of the problem's goals.
bool isInGoal(const Problem& problem, const ConfigurationSpace& space,
              const std::vector<double>& q);

/// The first state of a path that the problem's condition does not accept, of those that
/// Condition::resolution has it look at; nothing when there is none.
std::optional<VerifyResult> findUnaccepted(const Problem& problem, const ConfigurationSpace& space,
                                           const Path& path);

/// A number with 17 digits, for messages.
std::string numberText(double x);

}  // namespace leeway::planner::verification
