#include "leeway/planner/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "leeway/planner/problem.h"
#include "tests/build_paths.h"

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(RestToRest, KeepsItsLimitsAndIsTheirOwnIntegral) {
  int cruising = 0, short_ways = 0, ramped = 0;
  std::uint64_t state = 1;
  const auto power = [&](double low, double high) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return std::pow(10.0, low + (high - low) * static_cast<double>(state >> 40U) * 0x1p-24);
  };
  for (int i = 0; i < 300; ++i) {
    const double v = power(-2, 2), a = power(-2, 2), j = i % 3 == 0 ? kInfinity : power(-2, 3);
    const RestToRest profile(v, a, j);
    const double end = profile.duration();
    ASSERT_TRUE(std::isfinite(end) && end > 0);
    double way = 0;
    const int steps = 4000;
    const double h = end / steps;
    RestToRest::State before = profile.at(0);
    double peak = 0, acceleration = 0;
    for (int k = 1; k <= steps; ++k) {
      const RestToRest::State now = profile.at(k * h);
      EXPECT_GE(now.way, before.way - 1e-12);
      EXPECT_LE(now.speed, v * (1 + 1e-9));
      EXPECT_LE(std::abs(now.acceleration), a * (1 + 1e-9));
      if (j < kInfinity && k < steps) {
        EXPECT_LE(std::abs(now.acceleration - before.acceleration), j * h * (1 + 1e-6) + 1e-12);
      }
      way += h * (now.speed + before.speed) / 2;
      peak = std::max(peak, now.speed);
      acceleration = std::max(acceleration, now.acceleration);
      before = now;
    }
    EXPECT_NEAR(way, 1, 1e-5 + h * peak);  // kinks within a step
    EXPECT_NEAR(profile.at(end * (1 - 1e-12)).way, 1, 1e-9);
    EXPECT_EQ(profile.at(end).way, 1);
    // Something is at its limit at any time: else it could be faster.
    EXPECT_TRUE(peak > v * 0.999 || acceleration > a * 0.998 || j < kInfinity);
    cruising += peak > v * 0.999;
    short_ways += peak < v * 0.9;
    ramped += j < kInfinity && acceleration < a * 0.9;
  }
  EXPECT_GT(cruising, 30);
  EXPECT_GT(short_ways, 30);
  EXPECT_GT(ramped, 10);
  // The textbook's numbers.
  EXPECT_NEAR(RestToRest(1, 1, kInfinity).duration(), 2, 1e-12);
  EXPECT_NEAR(RestToRest(0.5, 1, kInfinity).duration(), 2.5, 1e-12);
  EXPECT_NEAR(RestToRest(1e9, 1e9, 32).duration(), 4 * std::cbrt(1.0 / 64), 1e-12);
}

class TrajectoryTest : public ::testing::Test {
 protected:
  TrajectoryTest()
      : problem(loadProblem(leeway::sourceFolder() + "/problems/shelf/reach.yaml")),
        space(std::make_shared<ConfigurationSpace>(problem.model, problem.variables)) {}

  std::vector<double> start() const {
    std::vector<double> q;
    for (const int v : problem.variables)
      q.push_back(problem.configuration[static_cast<std::size_t>(v)]);
    return q;
  }

  Problem problem;
  std::shared_ptr<ConfigurationSpace> space;
};

TEST_F(TrajectoryTest, StaysOnThePathWithinTheLimitsAndRestsAtCorners) {
  const std::size_t n = static_cast<std::size_t>(space->size());
  std::vector<std::vector<double>> path{start()};
  for (int i = 1; i < 6; ++i) {
    path.push_back(path.back());
    for (std::size_t k = 0; k < n; ++k)
      path.back()[k] += 0.2 * std::sin(1.7 * i + 2.3 * static_cast<double>(k));
  }
  // An edge cut in its middle is run through; one of no length takes no time.
  std::vector<double> middle(n);
  space->interpolate(path[2], path[3], 0.5, middle);
  path.insert(path.begin() + 3, middle);
  path.insert(path.begin() + 1, path.front());
  path.push_back(path.back());
  path.push_back(start());  // turns round after an edge of no length
  for (const bool jerk : {false, true}) {
    MotionLimits limits = defaultMotionLimits(*space);
    if (jerk) limits.jerk.assign(n, 20);
    const Trajectory trajectory(space, path, limits);
    ASSERT_EQ(trajectory.times().size(), path.size());
    EXPECT_NEAR(trajectory.times()[1], 0, 1e-12);
    std::vector<double> q(n), rate(n), second(n), before(n), on_path(n);
    bool saturated = false;
    const double h = trajectory.duration() / 5000;
    trajectory.configuration(0, before);
    EXPECT_EQ(before, path.front());
    for (int k = 1; k < 5000; ++k) {
      const double t = k * h;
      trajectory.configuration(t, q);
      trajectory.velocity(t, rate);
      trajectory.acceleration(t, second);
      const Trajectory::Place p = trajectory.place(t);
      space->interpolate(path[static_cast<std::size_t>(p.edge)],
                         path[static_cast<std::size_t>(p.edge) + 1], p.t, on_path);
      EXPECT_EQ(q, on_path);  // the certified edge itself
      for (std::size_t i = 0; i < n; ++i) {
        EXPECT_LE(std::abs(rate[i]), limits.velocity[i] * (1 + 1e-9));
        EXPECT_LE(std::abs(second[i]), limits.acceleration[i] * (1 + 1e-9));
        EXPECT_LE(std::abs(q[i] - before[i]), limits.velocity[i] * h * (1 + 1e-6));
        saturated = saturated || std::abs(second[i]) > limits.acceleration[i] * 0.99;
      }
      before = q;
    }
    EXPECT_TRUE(saturated || jerk);
    trajectory.configuration(trajectory.duration(), q);
    EXPECT_EQ(q, path.back());
    for (const std::size_t corner : {2U, 3U, 5U, 7U, 8U}) {
      trajectory.velocity(trajectory.times()[corner], rate);
      for (const double r : rate) EXPECT_NEAR(r, 0, 1e-7);  // the root of a rounding
    }
    trajectory.velocity(trajectory.times()[4], rate);  // the cut edge's middle
    double fastest = 0;
    for (const double r : rate) fastest = std::max(fastest, std::abs(r));
    EXPECT_GT(fastest, 0.05);
  }
}

TEST_F(TrajectoryTest, RefusesSenselessLimits) {
  MotionLimits limits = defaultMotionLimits(*space);
  limits.velocity[0] = 0;
  EXPECT_THROW(Trajectory(space, {start()}, limits), std::invalid_argument);
  limits = defaultMotionLimits(*space);
  limits.acceleration.pop_back();
  EXPECT_THROW(Trajectory(space, {start()}, limits), std::invalid_argument);
  limits = defaultMotionLimits(*space);
  EXPECT_THROW(Trajectory(space, {}, limits), std::invalid_argument);
  EXPECT_EQ(Trajectory(space, {start()}, limits).duration(), 0);
}

}  // namespace
}  // namespace leeway::planner
