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

  /// Moves on by the time `first`, after which all steps take a period. The joint brakes as hard as
  /// it can while its acceleration can still fall to 0 in time, by a jerk_step = jerk * period a
  /// period. With x now, the velocity that is lost until then is x * first, and (x - jerk_step) +
  /// (x - 2 jerk_step) + ..., the positive ones alone, times the period.
  void advance(double first, double period, double most, double jerk) {
    const double sign = velocity < 0 || (velocity == 0 && acceleration < 0) ? -1 : 1;
    const double v = sign * velocity, a = sign * acceleration;
    const double jerk_now = jerk * first, jerk_step = jerk * period;
    double steps = 0, x = v / first;  // steps: periods after this one until acceleration is 0
    if (jerk < kInfinity) {
      const double half = period / 2 - first;
      steps = std::floor((half + std::sqrt(half * half + 2 * period * v / jerk_step)) / period);
      x = (v + jerk_step * period * steps * (steps + 1) / 2) / (first + steps * period);
    }
    const double low = std::max(a - jerk_now, -most);
    const double next = std::max(std::min(-x, std::max(a + jerk_now, low)), low);
    velocity = next == -x && steps == 0 ? 0 : sign * (v + next * first);
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
  const double time = first > 0 ? first : period_;
  return limits_jerk_ ? stopEach(place, velocity, acceleration, rows, time)
                      : stopOnLine(place, velocity, rows, time);
}

int Brake::stopOnLine(std::span<const double> place, std::span<const double> velocity,
                      std::span<double> rows, double first) const {
  const std::size_t n = place.size();
  if (n == 0) return 0;
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
                    std::span<const double> acceleration, std::span<double> rows,
                    double first) const {
  const std::size_t n = place.size();
  if (n == 0) return 0;
  const std::size_t most = rows.size() / n;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    Braking joint{velocity[i], acceleration[i]};
    double position = place[i];
    std::size_t row = 0;
    for (double time = first; !joint.isDone(limits_.jerk[i] * time); ++row, time = period_) {
      if (row == most) return -1;
      joint.advance(time, period_, limits_.acceleration[i], limits_.jerk[i]);
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
