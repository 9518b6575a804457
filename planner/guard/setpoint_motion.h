#pragma once

// Private to planner/: a robot's motion as setpoints.

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/guard/polynomials.h"

namespace leeway::planner {

/// How far apart doubles are near a time [s].
inline double timeSpacing(double time) {
  const double size = std::abs(time);
  return std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
}

/// Two times this near are one [s]. Rounding of a time and of the sum of periods before it is below
/// four spacings.
inline double sameTime(double time, double period) {
  return std::max(kGuardSameTime * period, 4 * timeSpacing(time));
}

/// A start and the setpoints after it, one row a period. From row to row joints go in straight
/// lines at constant speed, but to the first ones on polynomials; after the last one the robot
/// rests. Allocates in the constructor only.
struct SetpointMotion {
  /// `most`: setpoints that there is room for [count]; `terms`: coefficients of a polynomial.
  SetpointMotion(std::size_t variables, std::size_t most, std::size_t terms)
      : size(variables),
        values((most + 1) * size),
        velocity(size),
        acceleration(size),
        curve(variables, terms),
        bend(size) {}

  /// Rest at a place from `when` on [s].
  void reset(std::span<const double> place, double when) {
    std::copy(place.begin(), place.end(), values.begin());
    std::fill(velocity.begin(), velocity.end(), 0);
    std::fill(acceleration.begin(), acceleration.end(), 0);
    time = when;
    since = 0;
    rows = passed = curved = 0;
  }

  /// Row 0 is the start.
  std::span<double> row(int i) { return {&values[at(i) * size], size}; }
  std::span<const double> row(int i) const { return {&values[at(i) * size], size}; }
  /// Room for rows from `i` on.
  std::span<double> from(int i) { return std::span<double>(values).subspan(at(i) * size); }
  std::span<const double> setpoints() const { return {values.data() + size, at(rows) * size}; }

  /// Velocity and acceleration on the way to row k, on a polynomial at that row; at the start,
  /// where k is 0.
  double velocityTo(int k, std::size_t i, double period) const {
    if (k == 0) return velocity[i];
    if (k <= curved) return curve.at(i, 1, curveTime(k, period));
    return (row(k)[i] - row(k - 1)[i]) / period;
  }
  double accelerationTo(int k, std::size_t i, double period) const {
    if (k == 0) return acceleration[i];
    if (k <= curved) return curve.at(i, 2, curveTime(k, period));
    return (velocityTo(k, i, period) - velocityTo(k - 1, i, period)) / timeTo(k, period);
  }
  /// The time of the polynomials [s] after a number of periods from the start.
  double curveTime(double periods, double period) const { return curve_begin + periods * period; }
  /// The time in which the velocity before row k - 1 becomes that after it.
  double timeTo(int k, double period) const { return k == 1 && since > 0 ? since : period; }

  std::size_t size;
  std::vector<double> values;
  std::vector<double> velocity, acceleration;  ///< at the start
  double time = 0;                             ///< of the start [s]
  /// How long the joints had their velocity at the start, where that is less than a period [s]; 0:
  /// a period at least.
  double since = 0;
  int rows = 0;    ///< setpoints
  int passed = 0;  ///< those before the stop

  int curved = 0;            ///< the first ones, between which the robot follows `curve`
  Polynomials curve;         ///< of use where `curved` is not 0
  double curve_begin = 0;    ///< its time at the start [s]
  std::vector<double> bend;  ///< how far it is from the straight lines at most [rad or m]
};

}  // namespace leeway::planner
