#include "planner/guard/brake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "planner/base/random.h"

namespace leeway::planner {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Follows a stop row by row. Between the last row and rest acceleration and jerk are kept, too.
/// The velocity before the first row changes in the time `first`.
void expectStop(const MotionLimits& limits, double period, const std::vector<double>& place,
                const std::vector<double>& velocity, const std::vector<double>& acceleration,
                double first) {
  const Brake brake(limits, period);
  const std::size_t n = place.size();
  std::vector<double> rows(static_cast<std::size_t>(brake.mostRows()) * n, 7);
  const int count = brake.stop(place, velocity, acceleration, rows, first);
  ASSERT_GE(count, 0);
  for (std::size_t i = 0; i < n; ++i) {
    double p = place[i], v = velocity[i], a = acceleration[i];
    for (int k = 0; k < count + 3; ++k) {
      const double next = k < count ? rows[static_cast<std::size_t>(k) * n + i] : p;
      const double time = k == 0 ? first : period;
      const double now = (next - p) / period, change = (now - v) / time;
      const double rounding = 1e-14 * (std::abs(p) + 1) / (period * time);
      const double jerk = limits.jerk.empty() ? kNoLimit : limits.jerk[i];
      EXPECT_LE(std::abs(change), limits.acceleration[i] * (1 + 1e-9) + rounding) << i << " " << k;
      EXPECT_LE(std::abs(change - a), jerk * time * (1 + 1e-9) + rounding)
          << i << " " << k << " of " << count;
      p = next;
      v = now;
      a = change;
    }
    EXPECT_NEAR(v, 0, 1e-9);
    EXPECT_NEAR(a, 0, 1e-6);
  }
}

TEST(Brake, IsOnTheLineOfTheMotionWithoutLimitsOnJerk) {
  const Brake brake({{1, 1}, {2, 4}, {}}, 0.1);
  std::vector<double> rows(100);
  // The first joint loses 0.2 in a period, a fifth of its velocity; the second goes along.
  const int count = brake.stop(std::vector<double>{1, 2}, std::vector<double>{1, -0.5},
                               std::vector<double>{0, 0}, rows);
  ASSERT_EQ(count, 4);
  for (int k = 0; k < count; ++k) {
    EXPECT_NEAR(rows[2 * static_cast<std::size_t>(k) + 1] - 2,
                -0.5 * (rows[2 * static_cast<std::size_t>(k)] - 1), 1e-12);
  }
  EXPECT_NEAR(rows[6], 1 + 0.1 * (0.8 + 0.6 + 0.4 + 0.2), 1e-12);
}

TEST(Brake, RestHasNoRowsAndSmallSpeedsEndAtOnce) {
  for (const double jerk : {kNoLimit, 1000.0}) {
    const Brake brake({{1}, {2}, {jerk}}, 0.1);
    std::vector<double> rows(100);
    EXPECT_EQ(
        brake.stop(std::vector<double>{1}, std::vector<double>{0}, std::vector<double>{0}, rows),
        0);
    EXPECT_EQ(brake.stop(std::vector<double>{1}, std::vector<double>{0.1}, std::vector<double>{0},
                         rows) == 0,
              jerk == kNoLimit);
  }
}

TEST(Brake, SaysWhereThereIsNoRoom) {
  for (const double jerk : {kNoLimit, 10.0}) {
    const Brake brake({{1}, {1}, {jerk}}, 0.01);
    std::vector<double> rows(10);
    EXPECT_EQ(
        brake.stop(std::vector<double>{1}, std::vector<double>{1}, std::vector<double>{0}, rows),
        -1);
  }
}

TEST(Brake, KeepsAllLimitsFromAnyMotionWithinThem) {
  Random random(4, 0);
  for (int round = 0; round < 3000; ++round) {
    const bool jerks = round % 3 != 0;
    const auto n = static_cast<std::size_t>(1 + round % 4);
    const double period = std::pow(10, random.uniform(-3, -1));
    MotionLimits limits;
    std::vector<double> place, velocity, acceleration;
    for (std::size_t i = 0; i < n; ++i) {
      const double v = random.uniform(0.1, 3), a = v * random.uniform(0.5, 20);
      limits.velocity.push_back(v);
      limits.acceleration.push_back(a);
      if (jerks) limits.jerk.push_back(a * std::pow(10, random.uniform(-0.5, 3)));
      place.push_back(random.uniform(-2, 2));
      velocity.push_back(round % 5 == 0 ? 0 : random.uniform(-v, v));
      acceleration.push_back(jerks ? random.uniform(-a, a) : 0);
    }
    expectStop(limits, period, place, velocity, acceleration,
               round % 2 == 0 ? period : period * random.uniform(0.01, 1));
    if (HasFailure()) FAIL() << "round " << round;
  }
}

}  // namespace
}  // namespace leeway::planner
