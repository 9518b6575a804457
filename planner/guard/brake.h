#pragma once

// Private to planner/: stops from any motion, as setpoints.

#include <span>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// Brings joints to rest within limits on acceleration and jerk, in setpoints that are one period
/// apart. Between two of them a joint has constant velocity; acceleration is the change of that
/// velocity over a period, jerk that of acceleration. Does not allocate but when it is copied.
class Brake {
 public:
  /// `limits` have one number a joint; without jerks, or where one is infinite, jerk is not
  /// limited.
  Brake(MotionLimits limits, double period);

  /// The setpoints of any stop from within the limits, and of most from outside them [count].
  int mostRows() const { return most_rows_; }

  /// Writes the setpoints after `place`, row by row, until the robot is at rest; returns how many,
  /// or -1 where they are more than `rows` has room for. Without limits on jerk all are on the line
  /// along `velocity`; with them each joint brakes for itself, which is as fast as it can. `first`:
  /// in how much time the velocity changes before the first row, no more than a period; 0: in a
  /// period.
  int stop(std::span<const double> place, std::span<const double> velocity,
           std::span<const double> acceleration, std::span<double> rows, double first = 0) const;

 private:
  int stopOnLine(std::span<const double> place, std::span<const double> velocity,
                 std::span<double> rows, double first) const;
  int stopEach(std::span<const double> place, std::span<const double> velocity,
               std::span<const double> acceleration, std::span<double> rows, double first) const;

  MotionLimits limits_;
  double period_;
  bool limits_jerk_ = false;
  int most_rows_ = 0;
};

}  // namespace leeway::planner
