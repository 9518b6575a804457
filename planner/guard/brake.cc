#include "planner/guard/brake.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

/// One joint that comes to rest.
struct Braking {
  double velocity, acceleration;

  /// At rest, and acceleration may end.
  bool isDone(double jerk_step) const {
    return velocity == 0 && std::abs(acceleration) <= jerk_step;
  }

  /// Moves one period on. The joint brakes as hard as it can while its acceleration can still fall
  /// to 0 in time, by a `jerk_step` a period. With x now, the velocity that is lost until then is
  /// x + (x - jerk_step) + (x - 2 jerk_step) + ..., the positive ones alone, times the period.
  void advance(double period, double most, double jerk_step) {
    const double sign = velocity < 0 || (velocity == 0 && acceleration < 0) ? -1 : 1;
    const double v = sign * velocity, a = sign * acceleration, wanted = v / period;
    double steps = 0, x = wanted;  // steps: periods after this one until acceleration is 0
    if (jerk_step < kInfinity) {
      steps = std::floor((std::sqrt(1 + 8 * wanted / jerk_step) - 1) / 2);
      x = (wanted + jerk_step * steps * (steps + 1) / 2) / (steps + 1);
    }
    const double low = std::max(a - jerk_step, -most);
    const double next = std::max(std::min(-x, std::max(a + jerk_step, low)), low);
    velocity = next == -x && steps == 0 ? 0 : sign * (v + next * period);
    acceleration = sign * next;
  }
};

}  // namespace

Brake::Brake(MotionLimits limits, double period) : limits_(std::move(limits)), period_(period) {
  double longest = 0;  // [s]
  for (std::size_t i = 0; i < limits_.velocity.size(); ++i) {
    const double v = limits_.velocity[i], a = limits_.acceleration[i];
    const double j = limits_.jerk.empty() ? kInfinity : limits_.jerk[i];
    limits_jerk_ = limits_jerk_ || j < kInfinity;
    const double ramps = j < kInfinity ? 3 * a / j + 2 * std::sqrt(v / j) : 0;
    longest = std::max(longest, v / a + ramps);
  }
  most_rows_ = static_cast<int>(std::min(2 * longest / period, kMostStopRows)) + kSpareStopRows;
}

int Brake::stop(std::span<const double> place, std::span<const double> velocity,
                std::span<const double> acceleration, std::span<double> rows, double first) const {
  return limits_jerk_ ? stopEach(place, velocity, acceleration, rows)
                      : stopOnLine(place, velocity, rows, first > 0 ? first : period_);
}

int Brake::stopOnLine(std::span<const double> place, std::span<const double> velocity,
                      std::span<double> rows, double first) const {
  const std::size_t n = place.size();
  double rate = kInfinity;  // the share of its velocity that the robot loses in a second
  for (std::size_t i = 0; i < n; ++i)
    if (velocity[i] != 0) rate = std::min(rate, limits_.acceleration[i] / std::abs(velocity[i]));
  const auto most = static_cast<int>(rows.size() / n);
  double way = 0;  // [s at full velocity]
  int count = 0;
  for (double share = 1 - rate * first; share > 0; share = 1 - rate * (first + count * period_)) {
    if (count == most) return -1;
    way += share * period_;
    for (std::size_t i = 0; i < n; ++i)
      rows[static_cast<std::size_t>(count) * n + i] = place[i] + way * velocity[i];
    ++count;
  }
  return count;
}

int Brake::stopEach(std::span<const double> place, std::span<const double> velocity,
                    std::span<const double> acceleration, std::span<double> rows) const {
  const std::size_t n = place.size(), most = rows.size() / n;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double jerk_step = limits_.jerk[i] * period_;
    Braking joint{velocity[i], acceleration[i]};
    double position = place[i];
    std::size_t row = 0;
    for (; !joint.isDone(jerk_step); ++row) {
      if (row == most) return -1;
      joint.advance(period_, limits_.acceleration[i], jerk_step);
      position += joint.velocity * period_;
      // Joints before this one may rest already.
      if (row >= count)
        for (std::size_t k = 0; k < i; ++k)
          rows[row * n + k] = row == 0 ? place[k] : rows[(row - 1) * n + k];
      rows[row * n + i] = position;
    }
    for (; row < count; ++row) rows[row * n + i] = position;
    count = std::max(count, row);
  }
  // The last rows may not move: acceleration only falls to 0 in them.
  return static_cast<int>(count);
}

}  // namespace leeway::planner
