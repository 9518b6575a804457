#include "leeway/planner/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "tests/support/allocations.h"
#include "tests/support/build_paths.h"

namespace leeway::planner {
namespace {

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
  EXPECT_NEAR(RestToRest(1, 1, kInfinity).duration(), 2, 1e-12);
  EXPECT_NEAR(RestToRest(0.5, 1, kInfinity).duration(), 2.5, 1e-12);
  EXPECT_NEAR(RestToRest(1e9, 1e9, 32).duration(), 4 * std::cbrt(1.0 / 64), 1e-12);
  // Regression: the square of a / j overflows; it moved for 4e100 s, far beyond the end.
  EXPECT_NEAR(RestToRest(1, 1, 1e-200).duration() / (4 * std::cbrt(0.5e200)), 1, 1e-12);
}

TEST(RestToRest, WhereAccelerationJumpsItIsAsAfterwards) {
  EXPECT_EQ(RestToRest(1, 1, kInfinity).at(0).acceleration, 1);
  EXPECT_EQ(RestToRest(1, 1, kInfinity).at(1).acceleration, -1);  // regression: 0
  EXPECT_EQ(RestToRest(0.5, 1, kInfinity).at(0.5).acceleration, 0);
  EXPECT_EQ(RestToRest(0.5, 1, kInfinity).at(2).acceleration, -1);  // regression: 0
  EXPECT_EQ(RestToRest(0.5, 1, kInfinity).at(2.5).acceleration, 0);
  // Rounding may put the start of the last phase farther from the end than its length.
  std::uint64_t state = 7;
  for (int i = 0; i < 200; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    const double v = 0.1 + static_cast<double>(state >> 40U) * 0x1p-24;
    const RestToRest profile(v, 3, kInfinity);
    const std::vector<double> knots = profile.knots();
    EXPECT_EQ(profile.at(knots[knots.size() - 2]).acceleration, -3) << v;
  }
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
  MotionLimits limits = defaultMotionLimits(*space);
  limits.velocity[2] = 0.3;
  limits.acceleration[4] = 0.2;
  // Edges fully used, one corner without blend (4), one with a small one.
  std::vector<Blend> blends;
  for (const int corner : {1, 2, 3, 5, 7})
    blends.push_back(
        {corner, (corner == 5 ? 0.01 : 0.5) * std::min(length(corner - 1), length(corner))});
  const Trajectory trajectory(space, path, limits, blends);
  const Trajectory stopping(space, path, limits);
  EXPECT_LT(trajectory.duration(), 0.9 * stopping.duration());
  std::vector<double> q(n), rate(n), second(n), before(n), before_rate(n), expected(n);
  const int steps = 20000;
  const double h = trajectory.duration() / steps;
  trajectory.configuration(0, before);
  trajectory.velocity(0, before_rate);
  const std::size_t allocated = collision::testing::allocationCount();
  for (const Trajectory* each : {&trajectory, &stopping})
    for (int k = 0; k <= 1000; ++k) {
      const double time = each->duration() * k / 1000;
      each->configuration(time, q);
      each->velocity(time, rate);
      each->acceleration(time, second);
    }
  EXPECT_EQ(collision::testing::allocationCount(), allocated) << "a controller samples them";
  int on_blends = 0, at_a_limit = 0;
  for (int k = 1; k <= steps; ++k) {
    const double time = k * h;
    trajectory.configuration(time, q);
    trajectory.velocity(time, rate);
    trajectory.acceleration(time, second);
    bool limited = false;
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_LE(std::abs(rate[i]), limits.velocity[i] * (1 + 1e-9)) << time;
      ASSERT_LE(std::abs(second[i]), limits.acceleration[i] * (1 + 1e-9)) << time;
      // Each is the integral of the next.
      ASSERT_NEAR(q[i] - before[i], h * (rate[i] + before_rate[i]) / 2,
                  limits.acceleration[i] * h * h);
      ASSERT_LE(std::abs(rate[i] - before_rate[i]), limits.acceleration[i] * h * (1 + 1e-6) + 1e-9);
      limited = limited || std::abs(rate[i]) > 0.97 * limits.velocity[i] ||
                std::abs(second[i]) > 0.97 * limits.acceleration[i];
    }
    at_a_limit += limited;
    const Trajectory::Place p = trajectory.place(time);
    if (p.blend >= 0) {
      ++on_blends;
      const std::size_t corner =
          static_cast<std::size_t>(blends[static_cast<std::size_t>(p.blend)].corner);
      const double cut = blends[static_cast<std::size_t>(p.blend)].length;
      std::vector<double> from(n), to(n);
      space->interpolate(path[corner - 1], path[corner], 1 - cut / length(p.edge), from);
      space->interpolate(path[corner], path[corner + 1], cut / length(p.edge + 1), to);
      const double t = p.t;
      for (std::size_t i = 0; i < n; ++i)
        ASSERT_NEAR(q[i],
                    (1 - t) * (1 - t) * from[i] + 2 * t * (1 - t) * path[corner][i] + t * t * to[i],
                    1e-12);
    } else {
      space->interpolate(path[static_cast<std::size_t>(p.edge)],
                         path[static_cast<std::size_t>(p.edge) + 1], p.t, expected);
      ASSERT_EQ(q, expected);
    }
    std::swap(before, q);
    std::swap(before_rate, rate);
  }
  EXPECT_GT(on_blends, steps / 10);
  EXPECT_GT(at_a_limit, steps * 9 / 10);  // nearly always: time-optimal up to the cells
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
      for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(q[i], expected[i], 1e-7) << edge << " " << t;
    }
  EXPECT_GT(passed, 10);
  EXPECT_FALSE(trajectory.passes(1, 0.1).has_value());  // the corner is cut

  // Between knots on an edge, the cubic through both ends equals the motion.
  const std::vector<double> knots = trajectory.knots();
  EXPECT_EQ(knots.front(), 0);
  EXPECT_EQ(knots.back(), trajectory.duration());
  int edges = 0;
  std::vector<double> q0(n), q1(n), v0(n), v1(n);
  for (std::size_t k = 1; k < knots.size(); ++k) {
    const double a = knots[k - 1], b = knots[k], middle_time = a + (b - a) / 2, step = b - a;
    ASSERT_GT(step, 0);
    if (step < 1e-9 || trajectory.place(middle_time).blend >= 0) continue;
    ++edges;
    trajectory.configuration(a, q0);
    trajectory.configuration(b, q1);
    trajectory.velocity(a, v0);
    trajectory.velocity(b - 1e-12, v1);
    trajectory.configuration(middle_time, q);
    for (std::size_t i = 0; i < n; ++i)
      EXPECT_NEAR(q[i], (q0[i] + q1[i]) / 2 + step * (v0[i] - v1[i]) / 8, 1e-9);
  }
  EXPECT_GT(edges, 5);
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
  const std::vector<Blend> blends = {{1, 7.07173e-20}, {2, 1.5e-12}};
  const Trajectory trajectory(space, path, limits, blends);
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
  const std::vector<Blend> blends = {{1, 5e-7}};
  const double slow = Trajectory(space, path, limits, blends).duration();
  EXPECT_NEAR(slow / Trajectory(space, path, limits).duration(), 0.7, 0.3);
  limits.velocity.assign(7, 1);
  EXPECT_NEAR(Trajectory(space, path, limits, blends).duration(), slow, 1e-9 * slow);
}

/// Each edge turns the piano by half a turn: the chord of a blend over half of both could take the
/// opposite direction.
TEST_F(TrajectoryTest, BlendsOfHalfTurnsAreShorter) {
  Problem piano = loadProblem(leeway::sourceFolder() + "/problems/bodies/piano.yaml");
  piano.world.objects.clear();
  const double pi = 3.14159265358979323846;
  const std::vector<std::vector<double>> rows = {
      {3, 3, 0.3 - pi}, {3, 3.00001, 0.3}, {3, 3.00003, 0.3 + pi}};
  const std::vector<Blend> blends =
      certifiedBlends(std::make_shared<const CompiledScene>(piano), rows);
  ASSERT_EQ(blends.size(), 1U);
  EXPECT_NEAR(blends[0].length, pi / 4, 1e-3);
}

TEST_F(TrajectoryTest, RefusesBlendsThatCannotBe) {
  std::vector<std::vector<double>> path{start(), start(), start()};
  path[1][0] += 0.5;
  path[2][0] += 0.5;
  path[2][1] += 0.2;
  const MotionLimits limits = defaultMotionLimits(*space);
  const auto with = [&](const std::vector<Blend>& blends) {
    return Trajectory(space, path, limits, blends).duration();
  };
  EXPECT_GT(with({{1, 0.2}}), 0);
  EXPECT_THROW(with({{1, 0.21}}), std::invalid_argument);  // longer than its edge
  EXPECT_THROW(with({{1, 0}}), std::invalid_argument);
  EXPECT_THROW(with({{2, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{0, 0.1}}), std::invalid_argument);
  EXPECT_THROW(with({{1, 0.05}, {1, 0.05}}), std::invalid_argument);
  MotionLimits smooth = limits;
  smooth.jerk.assign(limits.velocity.size(), 20);
  const std::vector<Blend> blends = {{1, 0.1}};
  EXPECT_THROW(Trajectory(space, path, smooth, blends), std::invalid_argument);
  const Problem body = loadProblem(leeway::sourceFolder() + "/problems/bodies/window.yaml");
  const auto turning = std::make_shared<ConfigurationSpace>(body.robot.model, body.robot.variables);
  const std::vector<std::vector<double>> poses = {
      {0, 0, 1, 0, 0, 0, 1}, {0.3, 0, 1, 0, 0, 0, 1}, {0.3, 0.3, 1, 0, 0, 0, 1}};
  EXPECT_THROW(Trajectory(turning, poses, defaultMotionLimits(*turning), blends),
               std::invalid_argument);
}

/// Dense truth: a blended trajectory keeps the margins.
TEST_F(TrajectoryTest, CertifiedBlendsKeepTheMargins) {
  int blended = 0, shortened = 0;
  for (const char* name : {"shelf/reach", "table/posts", "snake/clutter", "bodies/piano"}) {
    Problem shipped = loadProblem(leeway::sourceFolder() + "/problems/" + name + ".yaml");
    shipped.execution.corners = Corners::kBlend;
    const PlanResult result = plan(shipped);
    ASSERT_EQ(result.status, PlanStatus::kSolved) << name;
    const Trajectory trajectory = trajectoryOf(shipped, result.path);
    blended += static_cast<int>(trajectory.blends().size());
    const auto scene = std::make_shared<const CompiledScene>(shipped);
    EdgeCertifier certifier(scene);
    std::vector<double> q(static_cast<std::size_t>(scene->space().size()));
    std::vector<double> dq(q.size());
    for (const Blend& blend : trajectory.blends()) {
      double shorter = kInfinity;
      for (const int edge : {blend.corner - 1, blend.corner}) {
        scene->space().difference(result.path.positions[static_cast<std::size_t>(edge)],
                                  result.path.positions[static_cast<std::size_t>(edge) + 1], dq);
        double sum = 0;
        for (const double x : dq) sum += x * x;
        shorter = std::min(shorter, std::sqrt(sum));
      }
      shortened += blend.length < 0.49 * shorter;
    }
    for (int k = 0; k <= 2000; ++k) {
      trajectory.configuration(trajectory.duration() * k / 2000, q);
      ASSERT_EQ(certifier.decide(q), Verdict::kFree) << name << " at " << k;
    }
  }
  EXPECT_GT(blended, 8);
  EXPECT_GT(shortened, 0);  // the full cut would be too near
}

TEST_F(TrajectoryTest, LimitsComeFromTheProblem) {
  problem.execution.speed = 0.5;
  problem.execution.velocities["joint2"] = 0.8;
  problem.execution.accelerations["joint1"] = 7;
  problem.execution.jerks["joint3"] = 11;
  const MotionLimits limits = motionLimits(problem);
  const MotionLimits defaults = defaultMotionLimits(*space);
  EXPECT_EQ(limits.velocity[0], defaults.velocity[0] / 2);
  EXPECT_EQ(limits.velocity[1], 0.4);
  EXPECT_EQ(limits.acceleration[0], 7);
  EXPECT_EQ(limits.acceleration[1], 0.8);
  EXPECT_EQ(limits.jerk[2], 11);
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
