#include "leeway/planner/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/verify.h"
#include "planner/base/tolerances.h"
#include "tests/support/allocations.h"
#include "tests/support/build_paths.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

TEST(SpeedProfile, KeepsItsLimitsAndIsTheirOwnIntegral) {
  int cruising = 0, short_ways = 0, ramped = 0;
  std::uint64_t state = 1;
  const auto power = [&](double low, double high) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return std::pow(10.0, low + (high - low) * static_cast<double>(state >> 40U) * 0x1p-24);
  };
  for (int i = 0; i < 300; ++i) {
    const double v = power(-2, 2), a = power(-2, 2), j = i % 3 == 0 ? kInfinity : power(-2, 3);
    const SpeedProfile profile({v, a, j}, 1);
    const double end = profile.duration();
    ASSERT_TRUE(std::isfinite(end) && end > 0);
    double way = 0;
    const int steps = 4000;
    const double h = end / steps;
    SpeedProfile::State before = profile.at(0);
    double peak = 0, acceleration = 0;
    for (int k = 1; k <= steps; ++k) {
      const SpeedProfile::State now = profile.at(k * h);
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
    EXPECT_NEAR(way, 1, 1e-5 + h * peak);  // corners within a step
    EXPECT_NEAR(profile.at(end * (1 - 1e-12)).way, 1, 1e-9);
    EXPECT_EQ(profile.at(end).way, 1);
    // Some limit is active at any time; otherwise a faster motion exists.
    EXPECT_TRUE(peak > v * 0.999 || acceleration > a * 0.998 || j < kInfinity);
    cruising += peak > v * 0.999;
    short_ways += peak < v * 0.9;
    ramped += j < kInfinity && acceleration < a * 0.9;
  }
  EXPECT_GT(cruising, 30);
  EXPECT_GT(short_ways, 30);
  EXPECT_GT(ramped, 10);
  // Textbook values.
  EXPECT_NEAR(SpeedProfile({1, 1, kInfinity}, 1).duration(), 2, 1e-12);
  EXPECT_NEAR(SpeedProfile({0.5, 1, kInfinity}, 1).duration(), 2.5, 1e-12);
  EXPECT_NEAR(SpeedProfile({1e9, 1e9, 32}, 1).duration(), 4 * std::cbrt(1.0 / 64), 1e-12);
  // Regression: the square of a / j overflows; it moved for 4e100 s, far beyond the end.
  EXPECT_NEAR(SpeedProfile({1, 1, 1e-200}, 1).duration() / (4 * std::cbrt(0.5e200)), 1, 1e-12);
}

TEST(SpeedProfile, WhereAccelerationJumpsItIsAsAfterwards) {
  EXPECT_EQ(SpeedProfile({1, 1, kInfinity}, 1).at(0).acceleration, 1);
  EXPECT_EQ(SpeedProfile({1, 1, kInfinity}, 1).at(1).acceleration, -1);  // regression: 0
  EXPECT_EQ(SpeedProfile({0.5, 1, kInfinity}, 1).at(0.5).acceleration, 0);
  EXPECT_EQ(SpeedProfile({0.5, 1, kInfinity}, 1).at(2).acceleration, -1);  // regression: 0
  EXPECT_EQ(SpeedProfile({0.5, 1, kInfinity}, 1).at(2.5).acceleration, 0);
  // Rounding may put the start of the last phase farther from the end than its length.
  std::uint64_t state = 7;
  for (int i = 0; i < 200; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    const double v = 0.1 + static_cast<double>(state >> 40U) * 0x1p-24;
    const SpeedProfile profile({v, 3, kInfinity}, 1);
    const std::vector<double> knots = profile.knots();
    EXPECT_EQ(profile.at(knots[knots.size() - 2]).acceleration, -3) << v;
  }
}

/// Between any speeds, and over lengths that just suffice.
TEST(SpeedProfile, GoesFromSpeedToSpeed) {
  std::uint64_t state = 3;
  const auto random = [&] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state >> 40U) * 0x1p-24;
  };
  int just = 0;
  for (int i = 0; i < 400; ++i) {
    const LineLimits limits{std::pow(10, 2 * random() - 1), std::pow(10, 2 * random() - 1),
                            i % 3 == 0 ? kInfinity : std::pow(10, 3 * random() - 1)};
    double first = i % 5 == 0 ? 0 : limits.speed * random();
    double last = i % 7 == 0 ? 0 : limits.speed * random();
    const double length = std::pow(10, 3 * random() - 2);
    const double most = mostSpeedAfter(limits, std::min(first, last), length);
    EXPECT_LE(most, limits.speed);
    if (std::max(first, last) > most || i % 11 == 0) {
      (first > last ? first : last) = most;
      ++just;
    }
    const SpeedProfile profile(limits, length, first, last);
    ASSERT_TRUE(std::isfinite(profile.duration()) && profile.duration() > 0);
    EXPECT_EQ(profile.at(-1).speed, first);
    EXPECT_EQ(profile.at(profile.duration()).speed, last);
    EXPECT_EQ(profile.at(profile.duration()).way, length);
    const int steps = 3000;
    const double h = profile.duration() / steps;
    SpeedProfile::State before = profile.at(0);
    EXPECT_NEAR(before.speed, first, 1e-12 * limits.speed);
    for (int k = 1; k <= steps; ++k) {
      const SpeedProfile::State now = profile.at(k * h);
      ASSERT_LE(now.speed, limits.speed * (1 + 1e-9));
      ASSERT_GE(now.speed, -1e-12);
      ASSERT_LE(std::abs(now.acceleration), limits.acceleration * (1 + 1e-9));
      ASSERT_NEAR(now.way - before.way, h * (now.speed + before.speed) / 2,
                  limits.acceleration * h * h + 1e-12 * length);
      ASSERT_LE(std::abs(now.speed - before.speed), limits.acceleration * h * (1 + 1e-6) + 1e-12);
      if (limits.jerk < kInfinity) {
        ASSERT_LE(std::abs(now.acceleration - before.acceleration),
                  limits.jerk * h * (1 + 1e-6) + 1e-12 * limits.acceleration);
      }
      before = now;
    }
    EXPECT_NEAR(profile.timeAt(length / 3),
                profile.timeAt(profile.at(profile.timeAt(length / 3)).way),
                1e-6 * profile.duration());
    EXPECT_NEAR(profile.at(profile.timeAt(length / 3)).way, length / 3, 1e-9 * length);
  }
  EXPECT_GT(just, 30);
  EXPECT_THROW(SpeedProfile({1, 1, 1}, 0), std::invalid_argument);
  EXPECT_THROW(SpeedProfile({1, 0, 1}, 1), std::invalid_argument);
  EXPECT_THROW(SpeedProfile({1, 1, 1}, 1, 1.5, 0), std::invalid_argument);
  EXPECT_THROW(SpeedProfile({1, 1, 1}, 1, 0, -1), std::invalid_argument);
}

class TrajectoryTest : public ::testing::Test {
 protected:
  TrajectoryTest()
      : problem(loadProblem(leeway::sourceFolder() + "/problems/shelf/reach.yaml")),
        space(std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables)) {}

  std::vector<double> start() const {
    std::vector<double> q;
    for (const int v : problem.robot.variables)
      q.push_back(problem.start[static_cast<std::size_t>(v)]);
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
  // An edge cut in its middle is passed without stopping; a zero-length one takes no time.
  std::vector<double> middle(n);
  space->interpolate(path[2], path[3], 0.5, middle);
  path.insert(path.begin() + 3, middle);
  path.insert(path.begin() + 1, path.front());
  path.push_back(path.back());
  path.push_back(start());  // reverses after a zero-length edge
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
      EXPECT_EQ(q, on_path);  // exactly the certified edge
      for (std::size_t i = 0; i < n; ++i) {
        EXPECT_LE(std::abs(rate[i]), limits.velocity[i] * (1 + 1e-9));
        EXPECT_LE(std::abs(second[i]), limits.acceleration[i] * (1 + 1e-9));
        EXPECT_LE(std::abs(q[i] - before[i]), limits.velocity[i] * h * (1 + 1e-6));
        saturated = saturated || std::abs(second[i]) > limits.acceleration[i] * 0.99;
      }
      before = q;
    }
    EXPECT_TRUE(saturated || jerk);
    // At a knot the acceleration is the later one.
    const std::vector<double> knots = trajectory.knots();
    for (std::size_t k = 1; k < knots.size() && !jerk; ++k) {
      if (knots[k] - knots[k - 1] < 1e-9) continue;
      trajectory.acceleration(knots[k - 1], q);
      trajectory.acceleration(knots[k - 1] + (knots[k] - knots[k - 1]) / 2, second);
      for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(q[i], second[i], 1e-9) << k;
    }
    trajectory.configuration(trajectory.duration(), q);
    EXPECT_EQ(q, path.back());
    for (const std::size_t corner : {2U, 3U, 5U, 7U, 8U}) {
      trajectory.velocity(trajectory.times()[corner], rate);
      for (const double r : rate) EXPECT_NEAR(r, 0, 1e-7);  // square root of a rounding error
    }
    EXPECT_NEAR(*trajectory.passes(3, 1), trajectory.times()[4], 1e-9);
    EXPECT_NEAR(*trajectory.passes(0, 0.5), 0, 1e-9);
    trajectory.velocity(trajectory.times()[4], rate);  // middle of the cut edge
    double fastest = 0;
    for (const double r : rate) fastest = std::max(fastest, std::abs(r));
    EXPECT_GT(fastest, 0.05);
  }
}

/// Arbitrary blends: the curve's shape, and limits at every time.
TEST_F(TrajectoryTest, BlendsKeepTheLimitsAndDoNotJump) {
  const std::size_t n = static_cast<std::size_t>(space->size());
  std::vector<std::vector<double>> path{start()};
  for (int i = 1; i < 8; ++i) {
    path.push_back(path.back());
    for (std::size_t k = 0; k < n; ++k)
      path.back()[k] += 0.25 * std::sin(2.9 * i + 1.3 * static_cast<double>(k) * i);
  }
  std::vector<double> middle(n), dq(n);
  space->interpolate(path[5], path[6], 0.5, middle);  // passed without stopping
  path.insert(path.begin() + 6, middle);
  const auto length = [&](int edge) {
    space->difference(path[static_cast<std::size_t>(edge)],
                      path[static_cast<std::size_t>(edge) + 1], dq);
    double sum = 0;
    for (const double x : dq) sum += x * x;
    return std::sqrt(sum);
  };
  for (const bool smooth : {false, true}) {
    MotionLimits limits = defaultMotionLimits(*space);
    limits.velocity[2] = 0.3;
    limits.acceleration[4] = 0.2;
    if (smooth) limits.jerk.assign(n, 15);
    // Edges fully used, one corner without blend (4), one with a small and crooked one.
    std::vector<Blend> blends;
    for (const int corner : {1, 2, 3, 5, 7}) {
      const double cut = 0.5 * std::min(length(corner - 1), length(corner));
      const double ramp = smooth ? 0.1 * corner - (corner > 5 ? 0.2 : 0) : corner == 3 ? 0.2 : 0;
      blends.push_back({corner, cut, cut, ramp});
    }
    blends[3].before *= 0.02;
    blends[3].after *= 0.05;
    const Trajectory trajectory(space, path, limits, {blends});
    std::vector<double> q(n), rate(n), second(n), before(n), before_rate(n), before_second(n),
        expected(n);
    const int steps = 20000;
    const double h = trajectory.duration() / steps;
    trajectory.configuration(0, before);
    trajectory.velocity(0, before_rate);
    trajectory.acceleration(0, before_second);
    const std::size_t allocated = collision::testing::allocationCount();
    for (int k = 0; k <= 1000; ++k) {
      const double time = trajectory.duration() * k / 1000;
      trajectory.configuration(time, q);
      trajectory.velocity(time, rate);
      trajectory.acceleration(time, second);
    }
    EXPECT_EQ(collision::testing::allocationCount(), allocated) << "a controller samples them";
    int on_blends = 0;
    for (int k = 1; k <= steps; ++k) {
      const double time = k * h;
      trajectory.configuration(time, q);
      trajectory.velocity(time, rate);
      trajectory.acceleration(time, second);
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_LE(std::abs(rate[i]), limits.velocity[i] * (1 + 1e-9)) << time;
        ASSERT_LE(std::abs(second[i]), limits.acceleration[i] * (1 + 1e-9)) << time;
        // Each is the integral of the next.
        ASSERT_NEAR(q[i] - before[i], h * (rate[i] + before_rate[i]) / 2,
                    limits.acceleration[i] * h * h);
        ASSERT_LE(std::abs(rate[i] - before_rate[i]),
                  limits.acceleration[i] * h * (1 + 1e-6) + 1e-9);
        if (smooth) {
          ASSERT_LE(std::abs(second[i] - before_second[i]), limits.jerk[i] * h * (1 + 1e-6) + 1e-9)
              << time;
        }
      }
      const Trajectory::Place p = trajectory.place(time);
      if (p.blend >= 0) {
        ++on_blends;
        // In the plane of both edges, within the triangle of the corner and the ends.
        const Blend& blend = blends[static_cast<std::size_t>(p.blend)];
        const auto corner = static_cast<std::size_t>(blend.corner);
        std::vector<double> from(n), to(n);
        space->interpolate(path[corner - 1], path[corner], 1 - blend.before / length(p.edge), from);
        space->interpolate(path[corner], path[corner + 1], blend.after / length(p.edge + 1), to);
        // The integral of the speed's share by the rectangle rule.
        const auto passed = [&](double until) {
          const double most = 1 / (1 - blend.ramp);
          const int parts = 4000;
          double sum = 0;
          for (int j = 0; j < parts; ++j) {
            const double x = until * (j + 0.5) / parts;
            const auto rising = [&](double y) {
              return y < blend.ramp ? most * y * y / (2 * blend.ramp) : most * (y - blend.ramp / 2);
            };
            sum += (x > 0.5 ? 1 - rising(1 - x) : rising(x)) * until / parts;
          }
          return 2 * sum;
        };
        if (k % 50 == 0) {
          const double a = passed(1 - p.t), b = passed(p.t);
          for (std::size_t i = 0; i < n; ++i)
            ASSERT_NEAR(
                q[i],
                path[corner][i] + a * (from[i] - path[corner][i]) + b * (to[i] - path[corner][i]),
                1e-6);
        }
      } else {
        space->interpolate(path[static_cast<std::size_t>(p.edge)],
                           path[static_cast<std::size_t>(p.edge) + 1], p.t, expected);
        ASSERT_EQ(q, expected);
      }
      std::swap(before, q);
      std::swap(before_rate, rate);
      std::swap(before_second, second);
    }
    EXPECT_GT(on_blends, steps / 10);
    trajectory.velocity(trajectory.times()[4], rate);
    for (const double r : rate) EXPECT_NEAR(r, 0, 1e-7);
    trajectory.configuration(trajectory.times()[6], q);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(q[i], middle[i], 1e-9);
    trajectory.configuration(trajectory.duration(), q);
    EXPECT_EQ(q, path.back());

    int passed = 0;
    for (int edge = 0; edge + 1 < static_cast<int>(path.size()); ++edge)
      for (const double t : {0.0, 0.2, 0.5, 0.9, 1.0}) {
        const std::optional<double> time = trajectory.passes(edge, t);
        if (!time) continue;
        ++passed;
        space->interpolate(path[static_cast<std::size_t>(edge)],
                           path[static_cast<std::size_t>(edge) + 1], t, expected);
        trajectory.configuration(*time, q);
        for (std::size_t i = 0; i < n; ++i)
          ASSERT_NEAR(q[i], expected[i], 1e-7) << edge << " " << t;
      }
    EXPECT_GT(passed, 10);
    EXPECT_FALSE(trajectory.passes(1, 0.1).has_value());  // the corner is cut

    // Between knots, also on blends, the cubic through both ends is the motion.
    const std::vector<double> knots = trajectory.knots();
    EXPECT_EQ(knots.front(), 0);
    EXPECT_EQ(knots.back(), trajectory.duration());
    int cubics = 0;
    std::vector<double> q0(n), q1(n), v0(n), v1(n);
    for (std::size_t k = 1; k < knots.size(); ++k) {
      const double a = knots[k - 1], b = knots[k], middle_time = a + (b - a) / 2, step = b - a;
      ASSERT_GT(step, 0);
      if (step < 1e-9) continue;
      ++cubics;
      trajectory.configuration(a, q0);
      trajectory.configuration(b, q1);
      trajectory.velocity(a, v0);
      trajectory.velocity(b, v1);
      trajectory.configuration(middle_time, q);
      for (std::size_t i = 0; i < n; ++i)
        EXPECT_NEAR(q[i], (q0[i] + q1[i]) / 2 + step * (v0[i] - v1[i]) / 8, 1e-9) << k;
    }
    EXPECT_GT(cubics, 15);
  }
}

/// Regression: accelerations reached twice their limits for blends and edges of picometres after a
/// long edge, because their lengths were summed with its.
TEST_F(TrajectoryTest, TinyBlendsKeepTheLimits) {
  std::vector<std::vector<double>> path(4, std::vector<double>(7));
  path[1][0] = -0.36361073573801637;
  path[1][1] = 0.64302107862712421;
  path[2][0] = path[1][0] - 8.2422957348e-13;
  path[2][1] = path[1][1] - 3.0051516861e-12;
  path[3][0] = path[1][0];
  path[3][1] = path[1][1] + 1e-12;
  MotionLimits limits = defaultMotionLimits(*space);
  limits.velocity[0] = 0.0004716;
  limits.acceleration[0] = 0.0005845;
  limits.velocity[1] = 1920;
  limits.acceleration[1] = 50780;
  const std::vector<Blend> blends = {{1, 7.07173e-20, 7.07173e-20}, {2, 1.5e-12, 2e-13}};
  const Trajectory trajectory(space, path, limits, {blends});
  const std::vector<double> knots = trajectory.knots();
  std::vector<double> rate(7), second(7);
  for (std::size_t k = 1; k < knots.size(); ++k)
    for (const double share : {0.0, 0.01, 0.5, 0.99}) {
      const double time = knots[k - 1] + share * (knots[k] - knots[k - 1]);
      trajectory.velocity(time, rate);
      trajectory.acceleration(time, second);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_LE(std::abs(rate[i]), limits.velocity[i] * (1 + 1e-6)) << time;
        EXPECT_LE(std::abs(second[i]), limits.acceleration[i] * (1 + 1e-6)) << time;
      }
    }
}

/// Limits many powers of ten apart. Regression: the speed through the blend was taken for 0, and
/// the motion jumped over it.
TEST_F(TrajectoryTest, BlendsFarBelowTheVelocityLimitsAreGoneThrough) {
  std::vector<std::vector<double>> path(3, std::vector<double>(7));
  path[1][0] = 1e-6;
  path[2][0] = 1e-6;
  path[2][1] = 1e-6;
  MotionLimits limits;
  limits.velocity.assign(7, 1e9);
  limits.acceleration.assign(7, 1e-9);
  const std::vector<Blend> blends = {{1, 5e-7, 5e-7}};
  const double slow = Trajectory(space, path, limits, {blends}).duration();
  EXPECT_NEAR(slow / Trajectory(space, path, limits).duration(), 0.7, 0.3);
  limits.velocity.assign(7, 1);
  EXPECT_NEAR(Trajectory(space, path, limits, {blends}).duration(), slow, 1e-9 * slow);
}

/// Regression: blends were made shorter until they were proven, and then took less than rows of a
/// file can hold. The cubics through the rows left the tolerance of a constraint.
TEST_F(TrajectoryTest, PhasesOfShortBlendsHaveRoomForRows) {
  std::vector<std::vector<double>> path(3, std::vector<double>(7));
  path[1][0] = 0.1;
  path[2][0] = 0.1;
  path[2][1] = 0.1;
  MotionLimits limits;
  limits.velocity.assign(7, 20);
  limits.acceleration.assign(7, 3000);
  for (const double jerk : {kInfinity, 1e8}) {
    limits.jerk.assign(7, jerk);
    for (const double length : {1e-9, 1e-7, 1e-5})
      for (const double ramp : {0.1, 0.4, 0.5}) {
        const std::vector<Blend> blends = {{1, length, length, ramp}};
        const std::vector<double> knots = Trajectory(space, path, limits, {blends}).knots();
        for (std::size_t k = 1; k < knots.size(); ++k)
          EXPECT_GE(knots[k] - knots[k - 1], kLeastRow) << length << " " << ramp << " " << k;
      }
  }
}

/// Each edge turns the piano by half a turn: the chord of a blend over half of both could take the
/// opposite direction.
TEST_F(TrajectoryTest, BlendsOfHalfTurnsAreShorter) {
  Problem piano = loadProblem(leeway::sourceFolder() + "/problems/bodies/piano.yaml");
  piano.world.objects.clear();
  const double pi = 3.14159265358979323846;
  const std::vector<std::vector<double>> rows = {
      {3, 3, 0.3 - pi}, {3.5, 3, 0.3}, {3.5, 3.5, 0.3 + pi}};
  const Cuts cuts = certifiedCuts(std::make_shared<const CompiledScene>(piano), rows,
                                  {{1e3, 1e3, 1e3}, {0.05, 0.05, 1}, {}});
  EXPECT_TRUE(cuts.left_out.empty()) << "the line would turn by nothing";
  ASSERT_EQ(cuts.blends.size(), 1U);
  EXPECT_LT(cuts.blends[0].before, 1.55);
  EXPECT_LT(cuts.blends[0].after, 1.55);
  EXPECT_GT(cuts.blends[0].before, 0.1);
}

TEST_F(TrajectoryTest, RefusesBlendsThatCannotBe) {
  std::vector<std::vector<double>> path(3, std::vector<double>(7));
  path[1][0] = 0.5;
  path[2][0] = 0.5;
  path[2][1] = 0.2;
  const MotionLimits limits = defaultMotionLimits(*space);
  const auto with = [&](const std::vector<Blend>& blends) {
    return Trajectory(space, path, limits, {blends}).duration();
  };
  EXPECT_GT(with({{1, 0.2, 0.1}}), 0);
  EXPECT_GT(with({{1, 0.2, 0.1, 0.5}}), 0);
  EXPECT_THROW(with({{1, 0.1, 0.21}}), std::invalid_argument);  // longer than its edge
  EXPECT_THROW(with({{1, 0.6, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.1, 0.2}}), std::invalid_argument);  // no length for slowing down
  EXPECT_THROW(with({{1, 0.5, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.1, 0}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.1, 0.1, 0.51}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.1, 0.1, -0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.1, std::nan("")}}), std::invalid_argument);
  EXPECT_THROW(with({{2, 0.1, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{0, 0.1, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.05, 0.05}, {1, 0.05, 0.05}}), std::invalid_argument);
  MotionLimits smooth = limits;
  smooth.jerk.assign(limits.velocity.size(), 20);
  const std::vector<Blend> blends = {{1, 0.1, 0.1}};
  EXPECT_THROW(Trajectory(space, path, smooth, {blends}), std::invalid_argument);
  const std::vector<Blend> ramped = {{1, 0.1, 0.1, 0.3}};
  EXPECT_GT(Trajectory(space, path, smooth, {ramped}).duration(), 0);
  const Problem body = loadProblem(leeway::sourceFolder() + "/problems/bodies/window.yaml");
  const auto turning = std::make_shared<ConfigurationSpace>(body.robot.model, body.robot.variables);
  const std::vector<std::vector<double>> poses = {
      {0, 0, 1, 0, 0, 0, 1}, {0.3, 0, 1, 0, 0, 0, 1}, {0.3, 0.3, 1, 0, 0, 0, 1}};
  EXPECT_THROW(Trajectory(turning, poses, defaultMotionLimits(*turning), {blends}),
               std::invalid_argument);
}

/// Dense truth for the whole chain, from planning to execution: by differences of positions alone,
/// velocity, acceleration and jerk keep their limits at 20,000 times; margins are kept; the time is
/// shorter than with stops.
TEST_F(TrajectoryTest, PlannedTrajectoriesKeepLimitsAndMargins) {
  int blended = 0;
  std::vector<double> ratios;
  for (const char* name : {"shelf/reach", "table/posts", "snake/clutter", "bodies/piano"}) {
    Problem shipped = loadProblem(leeway::sourceFolder() + "/problems/" + name + ".yaml");
    const PlanResult result = plan(shipped);
    ASSERT_EQ(result.status, PlanStatus::kSolved) << name;
    const auto scene = std::make_shared<const CompiledScene>(shipped);
    const std::size_t n = static_cast<std::size_t>(scene->space().size());
    EdgeCertifier certifier(scene);
    for (const bool smooth : {false, true}) {
      MotionLimits limits = motionLimits(shipped);
      for (std::size_t i = 0; i < n; ++i) {
        limits.jerk[i] = smooth ? 10 * limits.acceleration[i] : kInfinity;
        const std::string& variable =
            shipped.robot.model->variables[static_cast<std::size_t>(shipped.robot.variables[i])]
                .name;
        if (smooth) shipped.execution.jerks[variable] = limits.jerk[i];
      }
      const Trajectory trajectory = trajectoryOf(shipped, result.path);
      shipped.execution.corners = Corners::kStop;
      ratios.push_back(trajectory.duration() / trajectoryOf(shipped, result.path).duration());
      shipped.execution.corners = Corners::kBlend;
      EXPECT_LE(ratios.back(), 1 + 1e-12) << name;
      blended += static_cast<int>(trajectory.cutCorners().size());
      const int steps = 20000;
      const double h = trajectory.duration() / steps;
      std::vector<std::vector<double>> rows;
      for (int k = 0; k <= steps; ++k) {
        rows.emplace_back(n);
        trajectory.configuration(k * h, rows.back());
        if (k > 0) scene->space().unwrap(rows[rows.size() - 2], rows.back());
        if (k % 10 == 0) {
          ASSERT_EQ(certifier.decide(rows.back()), Verdict::kFree) << name << " at " << k;
        }
      }
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 3; k < rows.size(); ++k) {
          const double a = rows[k - 3][i], b = rows[k - 2][i], c = rows[k - 1][i], d = rows[k][i];
          // Rounding of positions below 16, divided by the steps.
          const double rounding = 4e-15;
          ASSERT_LE(std::abs(d - c) / h, limits.velocity[i] * (1 + 1e-9) + rounding / h) << name;
          ASSERT_LE(std::abs(d - 2 * c + b) / (h * h),
                    limits.acceleration[i] * (1 + 1e-9) + 2 * rounding / (h * h))
              << name;
          ASSERT_LE(std::abs(d - 3 * c + 3 * b - a) / (h * h * h),
                    limits.jerk[i] * (1 + 1e-9) + 4 * rounding / (h * h * h))
              << name;
        }
      std::vector<double> rest(n);
      trajectory.velocity(0, rest);
      for (const double v : rest) EXPECT_EQ(v, 0);
    }
  }
  EXPECT_GT(blended, 16);
  std::sort(ratios.begin(), ratios.end());
  EXPECT_LT(ratios[ratios.size() / 2], 0.85);
}

/// Blends keep constraints: the verifier proves it along the cubics.
TEST_F(TrajectoryTest, BlendsKeepConstraints) {
  Problem glass = loadProblem(leeway::sourceFolder() + "/problems/constrained/glass.yaml");
  for (const int v : glass.robot.variables)
    glass.execution.jerks[glass.robot.model->variables[static_cast<std::size_t>(v)].name] = 40;
  const PlanResult result = plan(glass);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  const Trajectory trajectory = trajectoryOf(glass, result.path);
  EXPECT_GT(trajectory.cutCorners().size(), 0U);
  EXPECT_TRUE(trajectory.cuts().left_out.empty());
  const Path motion = motionOf(trajectory);
  const VerifyResult proof = verify(glass, motion);
  EXPECT_EQ(proof.status, VerifyStatus::kCertified) << proof.reason;
  // The same motion breaks a constraint that is narrower than it, along cubics, too.
  for (Constraint& constraint : glass.constraints) constraint.angle *= 1e-3;
  EXPECT_NE(verify(glass, motion).status, VerifyStatus::kCertified);
  // A condition is looked at on edges only.
  Problem conditional = problem;
  conditional.condition.accept = [](std::span<const double>) { return true; };
  const PlanResult other = plan(conditional);
  ASSERT_EQ(other.status, PlanStatus::kSolved);
  EXPECT_TRUE(trajectoryOf(conditional, other.path).cutCorners().empty());
}

/// Waypoints near the line between those beside them are passed by.
TEST_F(TrajectoryTest, LeavesOutWaypointsNearTheLine) {
  Problem free = problem;
  free.world.objects.clear();
  const auto scene = std::make_shared<const CompiledScene>(free);
  std::vector<std::vector<double>> path(6, start());
  for (std::size_t i = 0; i < path.size(); ++i) {
    path[i][0] += 0.1 * static_cast<double>(i);
    path[i][1] += i == 3 ? 0.15 : i == 1 ? 0.03 : 0;
  }
  const MotionLimits limits = defaultMotionLimits(*space);
  const Cuts cuts = certifiedCuts(scene, path, limits);
  EXPECT_TRUE(std::binary_search(cuts.left_out.begin(), cuts.left_out.end(), 1));
  EXPECT_FALSE(std::binary_search(cuts.left_out.begin(), cuts.left_out.end(), 3)) << "too far";
  EXPECT_GT(cuts.clearance, 0) << "of the robot from itself";
  const Trajectory trajectory(space, path, limits, {{}, {1, 4}});
  EXPECT_EQ(trajectory.cutCorners(), (std::vector<int>{1, 4}));
  ASSERT_EQ(trajectory.times().size(), 6U);
  EXPECT_TRUE(std::is_sorted(trajectory.times().begin(), trajectory.times().end()));
  std::vector<double> q(7), expected(7);
  space->interpolate(path[3], path[5], 0.5, expected);
  trajectory.configuration((trajectory.times()[3] + trajectory.times()[5]) / 2, q);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(q[i], expected[i], 1e-9);
  for (const int i : {0, 2, 3, 5}) {
    trajectory.configuration(trajectory.times()[static_cast<std::size_t>(i)], q);
    for (std::size_t k = 0; k < 7; ++k)
      EXPECT_NEAR(q[k], path[static_cast<std::size_t>(i)][k], 1e-9) << i;
  }
  EXPECT_EQ(trajectory.place(trajectory.times()[1]).edge, 0);
  EXPECT_EQ(trajectory.place(trajectory.duration()).edge, 3);
  EXPECT_FALSE(trajectory.passes(0, 0.5).has_value());
  EXPECT_FALSE(trajectory.passes(1, 0.5).has_value());
  EXPECT_TRUE(trajectory.passes(2, 0.5).has_value());
  EXPECT_FALSE(trajectory.passes(4, 1).has_value());
  const std::vector<std::vector<int>> wrong = {{0}, {5}, {6}, {2, 1}, {1, 1}, {-1}};
  for (const std::vector<int>& left_out : wrong)
    EXPECT_THROW(Trajectory(space, path, limits, {{}, left_out}), std::invalid_argument);
  EXPECT_THROW(Trajectory(space, path, limits, {{{3, 0.01, 0.01}}, {3}}), std::invalid_argument);
  // An edge in place of two takes the sum of their least times.
  const std::vector<double> least = {0, 0, 0, 20, 30};
  const Trajectory slow(space, path, limits, {{}, {4}}, least);
  EXPECT_GT(slow.times()[5] - slow.times()[3], 50);
  EXPECT_LT(slow.times()[5] - slow.times()[3], 51);
}

/// A world without obstacles, and several limits on jerk.
/// The verifier certifies the rows of every motion that we make, whatever the limits are: those of
/// all joints or of one, small and large, with jerk or without.
/// Regression: places were wrapped to [-pi, pi), and took either sign of a quaternion.
TEST(Trajectory, ContinuesStraightThroughWholeTurns) {
  for (const bool turns_freely : {false, true}) {
    const auto model = turns_freely ? test::flyingBox() : test::disc();
    std::vector<int> variables(model->variables.size());
    std::iota(variables.begin(), variables.end(), 0);
    const auto space = std::make_shared<ConfigurationSpace>(model, variables);
    const std::vector<std::vector<double>> path =
        turns_freely ? std::vector<std::vector<double>>{{0, 0, 0, 0, 0, 0, 1},
                                                        {0.5, 0, 0, 0, 0, -0.8, -0.6},
                                                        {0.5, 0.5, 0, 0, 0, 1, 0}}
                     : std::vector<std::vector<double>>{{0, 0, 2.5}, {1, 0, -2.5}, {1, 1, -0.3}};
    Cuts cuts;
    if (!turns_freely) cuts.blends = {{1, 0.5, 0.5}};
    const Trajectory trajectory(space, path, defaultMotionLimits(*space), cuts);
    std::vector<double> before(variables.size()), q = before, rate = before;
    trajectory.configuration(0, before);
    const double step = trajectory.duration() / 2000;
    for (int k = 1; k <= 2000; ++k) {
      trajectory.configuration(k * step, q);
      trajectory.velocity((k - 0.5) * step, rate);
      for (std::size_t i = 0; i < q.size(); ++i)
        ASSERT_NEAR(q[i] - before[i], turns_freely && i > 2 ? 0 : rate[i] * step, 0.01) << k;
      before = q;
    }
    trajectory.configuration(trajectory.duration(), q);
    EXPECT_EQ(q, trajectory.waypoints().back());
    if (!turns_freely) {
      EXPECT_NEAR(q[2], collision::kTwoPi - 0.3, 1e-12);
    }
  }
}

TEST(Trajectory, RowsKeepAllLimits) {
  Problem problem = loadProblem(sourceFolder() + "/problems/shelf/reach.yaml");
  const PlanResult result = plan(problem);
  ASSERT_TRUE(result.certificate.certified);
  std::mt19937 random(23);
  const auto power = [&](double low, double high) {
    return std::pow(10, std::uniform_real_distribution<double>(low, high)(random));
  };
  int blended = 0;
  for (int i = 0; i < 60; ++i) {
    problem.execution = {};
    problem.execution.speed = power(-1, 0);
    problem.execution.corners = i % 4 == 0 ? Corners::kStop : Corners::kBlend;
    for (const int v : problem.robot.variables) {
      const std::string& joint = problem.robot.model->variables[at(v)].name;
      if (i % 3 != 0 || v == problem.robot.variables[at(i % 7)])
        problem.execution.accelerations[joint] = power(-2, 3);
      if (i % 2 == 0 && (i % 5 != 0 || v == problem.robot.variables[at(i % 7)]))
        problem.execution.jerks[joint] = power(-1, 6);
    }
    const Trajectory trajectory = trajectoryOf(problem, result.path);
    blended += trajectory.cutCorners().empty() ? 0 : 1;
    const VerifyResult proof = verify(problem, motionOf(trajectory));
    EXPECT_EQ(proof.status, VerifyStatus::kCertified) << i << ": " << proof.reason;
  }
  EXPECT_GT(blended, 20);
}

TEST_F(TrajectoryTest, BlendsSaveTime) {
  Problem free = problem;
  free.world.objects.clear();
  const auto scene = std::make_shared<const CompiledScene>(free);
  const std::size_t n = static_cast<std::size_t>(space->size());
  std::vector<std::vector<double>> path{start()};
  for (int i = 1; i < 6; ++i) {
    path.push_back(path.back());
    for (std::size_t k = 0; k < n; ++k)
      path.back()[k] += 0.1 * std::sin(2.9 * i + 1.3 * static_cast<double>(k) * i);
  }
  for (const double jerk : {kInfinity, 300.0, 50.0, 10.0}) {
    MotionLimits limits = defaultMotionLimits(*space);
    limits.jerk.assign(n, jerk);
    const Cuts cuts = certifiedCuts(scene, path, limits);
    EXPECT_GE(cuts.blends.size() + cuts.left_out.size(), 3U) << jerk;
    const double time = Trajectory(space, path, limits, cuts).duration();
    EXPECT_LT(time, 0.85 * Trajectory(space, path, limits).duration()) << jerk;
  }
  MotionLimits wrong = defaultMotionLimits(*space);
  wrong.velocity.pop_back();
  EXPECT_THROW(certifiedCuts(scene, path, wrong), std::invalid_argument);
  EXPECT_THROW(certifiedCuts(nullptr, path, defaultMotionLimits(*space)), std::invalid_argument);
}

TEST_F(TrajectoryTest, LimitsComeFromTheProblem) {
  problem.execution.speed = 0.5;
  problem.execution.velocities["joint2"] = 0.8;
  problem.execution.accelerations["joint1"] = 7;
  problem.execution.jerks["joint3"] = 11;
  problem.execution.acceleration_scale = 0.5;
  problem.execution.jerk_scale = 0.25;
  const MotionLimits limits = motionLimits(problem);
  const MotionLimits defaults = defaultMotionLimits(*space);
  EXPECT_EQ(limits.velocity[0], defaults.velocity[0] / 2);
  EXPECT_EQ(limits.velocity[1], 0.4);
  EXPECT_EQ(limits.acceleration[0], 3.5);
  EXPECT_EQ(limits.acceleration[1], 0.4) << "0.4 rad/s in half a second, and half of that";
  EXPECT_EQ(limits.jerk[2], 2.75);
  EXPECT_EQ(limits.jerk[0], kInfinity);
}

/// Exporters' value for "no limit". Regression: it gave an infinite acceleration.
TEST_F(TrajectoryTest, LargestNumberIsNoVelocityLimit) {
  auto model = std::make_shared<robots::Model>(*problem.robot.model);
  model->variables[static_cast<std::size_t>(problem.robot.variables[0])].velocity =
      std::numeric_limits<double>::max();
  problem.robot.model = model;
  const MotionLimits limits = motionLimits(problem);
  EXPECT_EQ(limits.velocity[0], kDefaultVelocity);
  EXPECT_EQ(limits.acceleration[0], 2 * kDefaultVelocity);
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
