#include "leeway/planner/replanner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include "collision/base/numbers.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/plan.h"
#include "leeway/robots/input_error.h"
#include "planner/base/random.h"
#include "planner/execute/drive.h"
#include "planner/execute/timed_path.h"
#include "planner/timing/motion_limits.h"
#include "tests/support/build_paths.h"
#include "tests/support/dense_truth.h"
#include "tests/support/input_errors.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using collision::DeformableMesh;
using collision::VertexMotion;

struct Sheet {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<DeformableMesh::Triangle> triangles;
};

/// An upright sheet across x = 0, from y0 to y1, in cells.
Sheet sheet(double y0, double y1, int cells) {
  Sheet s;
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= cells; ++i)
      s.vertices.emplace_back(0, y0 + (y1 - y0) * i / cells, -0.5 + 0.5 * j);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, c = a + cells + 1;
      s.triangles.push_back({a, a + 1, c + 1});
      s.triangles.push_back({a, c + 1, c});
    }
  return s;
}

/// Vertices pass through these displacements.
std::shared_ptr<const VertexMotion> moved(
    const Sheet& s, const std::vector<std::pair<double, Eigen::Vector3d>>& keys) {
  collision::MorphMotion motion;
  for (const auto& [time, by] : keys) {
    std::vector<Eigen::Vector3d> reference = s.vertices;
    for (Eigen::Vector3d& v : reference) v += by;
    motion.references.push_back(reference);
  }
  for (std::size_t k = 0; k < keys.size(); ++k) {
    std::vector<double> weights(keys.size(), 0.0);
    weights[k] = 1;
    motion.keys.push_back({keys[k].first, weights});
  }
  return VertexMotion::morph(motion);
}

DeformingObstacle obstacle(const std::string& name, const Sheet& s,
                           const std::vector<std::pair<double, Eigen::Vector3d>>& keys) {
  return makeDeformingObstacle(name, DeformableMesh::make(s.vertices, s.triangles), moved(s, keys),
                               {});
}

/// A disc crosses a wall with a gap from left to right; a sheet temporarily closes the gap.
Problem gate(const std::vector<std::pair<double, Eigen::Vector3d>>& keys) {
  Problem problem = test::wallProblem();
  problem.start = {-1, 1.2, 0};
  problem.goals = {test::pointGoal("goal", {1, 1.2, 0})};
  const Sheet s = sheet(0.95, 1.45, 4);
  problem.world.deforming.push_back(obstacle("gate", s, keys));
  problem.margins.common = 0.01;
  problem.limits.iterations = 1000;
  problem.execution.duration = 12;
  return problem;
}

/// Checks that certified steps are free; returns the clearance kept.
double expectTruth(const Problem& problem, const ReplanResult& result, double step = 0.002) {
  const double kept = test::denseClearance(problem, result.trajectory, step, 1.0);
  if (result.certified) {
    EXPECT_GT(kept, problem.margins.common);
    EXPECT_GE(kept, result.clearance.lower - 1e-9);
  }
  return kept;
}

/// How far rows of an execution exceed its limits, as a share, by their differences: the greatest
/// of velocity, acceleration and jerk.
double excess(const Problem& problem, std::span<const TimedPoint> rows) {
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const MotionLimits limits = motionLimits(problem);
  std::vector<TimedPoint> all(rows.begin(), rows.end());
  const double period = all[1].time - all[0].time;
  for (int k = 0; k < 3; ++k) all.push_back({all.back().time + period, all.back().position});
  const std::size_t size = all[0].position.size();
  std::vector<double> v(size), a(size), v_before(size), a_before(size);
  double most = 0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    EXPECT_NEAR(all[k].time - all[k - 1].time, period, 1e-9);
    space.difference(all[k - 1].position, all[k].position, v);
    for (std::size_t i = 0; i < size; ++i) {
      v[i] /= period;
      a[i] = (v[i] - v_before[i]) / period;
      most = std::max({most, std::abs(v[i]) / limits.velocity[i],
                       std::abs(a[i]) / limits.acceleration[i],
                       std::abs(a[i] - a_before[i]) / period / limits.jerk[i]});
    }
    v_before = v;
    a_before = a;
  }
  return most - 1;
}

TEST(Replanner, WithoutAnythingThatDeformsThePathIsFollowed) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 0.7}};
  problem.execution.speed = 0.5;
  const ReplanResult result = replan(problem);
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_TRUE(result.certified);
  EXPECT_EQ(result.plans, 1);
  EXPECT_EQ(result.replans, 0);
  EXPECT_EQ(result.waits + result.evasions, 0);
  EXPECT_EQ(result.trajectory.front().position, problem.start);
  EXPECT_EQ(result.trajectory.back().position, (std::vector<double>{1, -1, 0}));
  EXPECT_LT(excess(problem, result.trajectory), 1e-6);
  double fastest = 0;
  for (std::size_t i = 1; i < result.trajectory.size(); ++i) {
    const TimedPoint &a = result.trajectory[i - 1], &b = result.trajectory[i];
    ASSERT_GT(b.time, a.time);
    const double time = b.time - a.time;
    EXPECT_LE(std::abs(b.position[0] - a.position[0]), 0.35 * time + 1e-12);
    EXPECT_LE(std::abs(b.position[1] - a.position[1]), 0.5 * time + 1e-12);
    fastest = std::max(fastest, std::abs(b.position[0] - a.position[0]) / (0.35 * time));
    fastest = std::max(fastest, std::abs(b.position[1] - a.position[1]) / (0.5 * time));
  }
  EXPECT_GT(fastest, 0.999);
}

/// Steps and stops keep the limits, and a world at rest has no pause: with and without a limit on
/// jerk, with cut corners and without.
TEST(Replanner, KeepsLimitsOnAccelerationAndJerk) {
  for (const double jerk : {kInfinity, 30.0})
    for (const Corners corners : {Corners::kBlend, Corners::kStop}) {
      Problem problem = test::wallProblem();
      problem.execution.accelerations = {{"disc/x", 1.5}};
      problem.execution.corners = corners;
      if (jerk < kInfinity) problem.execution.jerks = {{"disc/x", jerk}, {"disc/y", jerk}};
      std::vector<TimedPoint> executed;
      int stops = 0;
      double longest = 0;
      const ReplanResult result = replan(problem, {}, [&](const ReplanStep& step) {
        executed.insert(executed.end(), step.motion.begin() + (executed.empty() ? 0 : 1),
                        step.motion.end());
        std::vector<TimedPoint> until_rest = executed;
        until_rest.insert(until_rest.end(), step.stop.begin(), step.stop.end());
        EXPECT_LT(excess(problem, until_rest), 1e-5) << step.time;
        stops += step.stop.empty() ? 0 : 1;
        if (!step.stop.empty()) longest = std::max(longest, step.stop.back().time - step.time);
      });
      EXPECT_EQ(result.status, ReplanStatus::kReached);
      EXPECT_EQ(result.waits + result.evasions, 0);
      EXPECT_GT(stops, result.steps / 2);
      EXPECT_LT(longest, 2);  // of about 6 s
    }
}

/// Short steps share a stop, and a log states it once. Long ones take no longer than their rows do.
TEST(Replanner, StepsOfAnyLength) {
  Problem problem = test::wallProblem();
  problem.execution.step = 0.002;
  int stops = 0, kept = 0;
  std::vector<TimedPoint> executed, stop;
  replan(
      problem, {},
      [&](const ReplanStep& step) {
        EXPECT_TRUE(step.certified);
        executed.insert(executed.end(), step.motion.begin() + (executed.empty() ? 0 : 1),
                        step.motion.end());
        stops += step.keeps_stop ? 0 : 1;
        kept += step.keeps_stop ? 1 : 0;
        stop = step.stop;
      },
      200);
  EXPECT_LE(stops, 12);
  EXPECT_GE(kept, 188);
  executed.insert(executed.end(), stop.begin(), stop.end());
  EXPECT_LT(excess(problem, executed), 1e-5);
  problem.execution.step = 20;
  problem.execution.duration = 40;
  EXPECT_EQ(replan(problem).status, ReplanStatus::kReached);
}

/// A stop leaves neither the way of its drive nor the limits, and is much shorter than the rest.
TEST(Drive, StopsOnItsWay) {
  const Problem problem = test::wallProblem();
  const auto space =
      std::make_shared<const ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  const double period = 0.01;
  MotionLimits limits{{1, 1, 1}, {2, 2, 2}, {20, 20, kInfinity}};
  const Drive drive(space, {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}}, limits, period,
                    {{{1, 0.2, 0.2, 0.3}}});
  EXPECT_EQ(drive.at(0), (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(drive.at(drive.rows()), (std::vector<double>{1, 2, 0}));
  int shorter = 0;
  for (int row = 0; row <= drive.rows(); ++row) {
    const std::vector<double> stop = drive.stop(row);
    double before = row;
    for (const double time : stop) {
      EXPECT_GE(time, before);
      EXPECT_LE(time, before + 1 + 1e-9);
      before = time;
    }
    shorter += static_cast<int>(stop.size()) < drive.rows() - row ? 1 : 0;
    EXPECT_LE(static_cast<double>(stop.size()) * period, 1.5) << row;
  }
  EXPECT_GT(shorter, drive.rows() / 2);
  EXPECT_EQ(drive.pathFrom(0).back(), (std::vector<double>{1, 2, 0}));
}

/// A part of a motion begins at the first of rows with one time, where the part before ends.
TEST(Replanner, PartsBeginAtTheFirstOfRowsWithOneTime) {
  const Problem problem = test::wallProblem();
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const std::vector<double> a = {1 - 0x1p-53, 0, 0}, b = {1, 0, 0}, c = {1.5, 0, 0};
  const std::vector<TimedPoint> motion = {{8, a}, {8, b}, {9, c}};
  const std::vector<TimedPoint> first = partOf(space, motion, 8, 8.25),
                                second = partOf(space, motion, 8.25, 9);
  EXPECT_EQ(first.front().position, a);
  EXPECT_EQ(first.back().position, second.front().position);
  EXPECT_EQ(second.back().position, c);
}

TEST(Replanner, WaitsForAGateThatOpens) {
  // Closed from the start to 2 s: no path, so it waits; then the gate moves up and away.
  const Problem problem = gate({{0, {0, 0, 0}}, {2, {0, 0, 0}}, {3, {0, 0, 1.2}}});
  int waits = 0, broken = 0;
  const ReplanResult result = replan(problem, {}, [&](const ReplanStep& step) {
    waits += step.decision == Decision::kWait;
    broken += step.path_held ? 0 : 1;
    EXPECT_TRUE(step.certified);
    EXPECT_EQ(step.motion.front().time, step.time);
    EXPECT_LE(step.clearance.lower, step.clearance.upper);
    EXPECT_GT(step.clearance.lower, problem.margins.common - 1e-12);
  });
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_GT(waits, 30);
  EXPECT_GT(broken, 30);
  expectTruth(problem, result);
}

TEST(Replanner, PlansAnewWhereTheWayIsClosed) {
  // Open at first; it closes for good before the disc arrives; the long way is below.
  Problem problem = gate({{0, {0, 0, 1.5}}, {0.2, {0, 0, 1.5}}, {0.5, {0, 0, 0}}});
  problem.world.objects[0] = test::box("lower wall", {0.05, 0.9, 0.5}, 0, 0, 0);  // y -0.9 to 0.9
  const ReplanResult first = replan(problem, {}, {}, 1);
  const PlanResult plan_alone = plan(problem);
  ASSERT_EQ(plan_alone.status, PlanStatus::kSolved);
  const ReplanResult result = replan(problem);
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_GE(result.replans, 1);
  expectTruth(problem, result);
  // Guards the test: the first path, executed blindly at the same speed, hits the gate.
  std::vector<TimedPoint> blind = {{0, plan_alone.path.positions.front()}};
  for (std::size_t i = 1; i < plan_alone.path.positions.size(); ++i) {
    const auto &a = plan_alone.path.positions[i - 1], &b = plan_alone.path.positions[i];
    double time = 0;
    for (std::size_t k = 0; k < a.size(); ++k) time = std::max(time, std::abs(b[k] - a[k]));
    blind.push_back({blind.back().time + time, b});
  }
  EXPECT_LE(test::denseClearance(problem, blind, 0.005, 1.0), 0);
}

TEST(Replanner, EvadesWhatComesWhereItStands) {
  // A sheet sweeps over the start, and no path leads to the goal.
  Problem problem = gate({{0, {0, 0, 0}}, {20, {0, 0, 0}}});
  const Sheet s = sheet(0.9, 1.5, 4);
  problem.world.deforming.push_back(
      obstacle("broom", s, {{0, {-1.9, 0, 0}}, {0.5, {-1.9, 0, 0}}, {3.5, {-0.6, 0, 0}}}));
  problem.execution.duration = 3;
  int evasions = 0;
  const ReplanResult result = replan(
      problem, {}, [&](const ReplanStep& step) { evasions += step.decision == Decision::kEvade; });
  EXPECT_EQ(result.status, ReplanStatus::kTimeout);
  EXPECT_TRUE(result.certified);
  EXPECT_GT(evasions, 3);
  expectTruth(problem, result);
}

TEST(Replanner, SaysWhenNothingIsCertain) {
  // Two sheets close in on the disc, which stands, from both sides, faster than it can leave.
  Problem problem = gate({{0, {0, 0, 0}}, {20, {0, 0, 0}}});
  const Sheet s = sheet(-2, 2.5, 4);
  for (const double side : {-1.0, 1.0})
    problem.world.deforming.push_back(obstacle(side < 0 ? "left" : "right", s,
                                               {{0, {-1 + side * 0.8, 0, 0}}, {0.3, {-1, 0, 0}}}));
  const ReplanResult result = replan(problem);
  EXPECT_EQ(result.status, ReplanStatus::kExposed);
  EXPECT_STREQ(toString(result.status), "exposed");
  EXPECT_FALSE(result.certified);
  EXPECT_LT(result.steps, 8);
  // All steps but the last are free.
  std::vector<TimedPoint> before = result.trajectory;
  while (before.size() > 1 && before.back().time > (result.steps - 1) * 0.05 + 1e-9)
    before.pop_back();
  EXPECT_GT(test::denseClearance(problem, before, 0.002, 1.0), problem.margins.common);
}

TEST(Replanner, ASpeedBoundAloneIsEnoughForSafety) {
  Problem problem = gate({{0, {0, 0, 0}}, {1, {0, 0, 0}}, {3, {0, 0, 1.2}}});
  problem.execution.foresight = Foresight::kSpeedBound;
  problem.world.deforming[0].speed_bound = 1;
  const ReplanResult result = replan(problem);
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_GT(result.waits, 10);
  expectTruth(problem, result);
}

TEST(Replanner, AProgramSaysWhereTheVerticesAre) {
  Problem problem = gate({{0, {0, 0, 0}}, {1, {0, 0, 0}}, {2, {0, 0, 1.5}}});
  const std::shared_ptr<const VertexMotion> truth = problem.world.deforming[0].motion;
  Problem blind = problem;
  blind.world.deforming[0].motion = nullptr;
  Replanner replanner(blind);
  ReplanResult result;
  result.certified = true;
  std::vector<Eigen::Vector3d> vertices(blind.world.deforming[0].mesh->rest().begin(),
                                        blind.world.deforming[0].mesh->rest().end());
  // Invalid input is refused without changing the state.
  EXPECT_THROW(replanner.setVertices("door", vertices, 0, 1), std::invalid_argument);
  EXPECT_THROW(replanner.setVertices("gate", std::span(vertices).first(3), 0, 1),
               std::invalid_argument);
  EXPECT_THROW(replanner.setVertices("gate", vertices, 0.1, 1), std::invalid_argument);
  EXPECT_THROW(replanner.setVertices("gate", vertices, 0, -1), std::invalid_argument);
  EXPECT_THROW(replanner.setVertices("gate", vertices, 0, std::nan("")), std::invalid_argument);
  vertices[1].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(replanner.setVertices("gate", vertices, 0, 1), std::invalid_argument);
  result.clearance = {1, 1};
  while (!replanner.reached() && replanner.time() < 8) {
    truth->evaluate(replanner.time(), vertices);
    replanner.setVertices("gate", vertices, replanner.time(), 1.5);
    const ReplanStep step = replanner.step();
    ASSERT_TRUE(step.certified) << step.time;
    result.clearance.lower = std::min(result.clearance.lower, step.clearance.lower);
    result.trajectory.insert(result.trajectory.end(), step.motion.begin(), step.motion.end());
    // The robot is at the commanded place, up to encoder errors.
    if (step.index == 3) {
      std::vector<double> measured(replanner.state().begin(), replanner.state().end());
      measured[1] += 1e-4;
      replanner.setState(measured);
      EXPECT_EQ(replanner.state()[1], measured[1]);
    }
  }
  EXPECT_TRUE(replanner.reached());
  for (std::size_t i = 1; i < result.trajectory.size(); ++i)
    result.trajectory[i].time = std::max(result.trajectory[i].time, result.trajectory[i - 1].time);
  expectTruth(problem, result);
  EXPECT_THROW(replanner.setState(std::vector<double>{0, 0}), std::invalid_argument);
  EXPECT_THROW(replanner.setState(std::vector<double>{9, 0, 0}), std::invalid_argument);
}

/// All is proven for a robot that is beside its motion by a tracking error, and what is measured
/// within that changes nothing, also where the path is at its margin.
TEST(Replanner, ATrackingErrorIsProven) {
  const Problem problem = test::wallProblem();
  const double error = 0.01;
  ReplanOptions options;
  options.joint_errors = {error, error, 0};
  Replanner replanner(problem, options);
  Random random(83, 0);
  const auto off = [&](std::vector<double> place) {
    for (std::size_t i = 0; i < 2; ++i) place[i] += random.uniform(-error, error);
    return place;
  };
  std::vector<TimedPoint> followed;
  double nearest = kInfinity;
  while (!replanner.reached() && replanner.time() < 12) {
    const ReplanStep step = replanner.step();
    ASSERT_TRUE(step.certified) << step.time << ": " << step.why;
    ASSERT_NE(step.decision, Decision::kWait);
    for (const TimedPoint& row : step.motion) followed.push_back({row.time, off(row.position)});
    nearest = std::min(nearest, step.clearance.upper);
    const std::vector<double> state(replanner.state().begin(), replanner.state().end());
    replanner.setState(off(state));
    EXPECT_TRUE(std::equal(state.begin(), state.end(), replanner.state().begin()));
  }
  EXPECT_TRUE(replanner.reached());
  EXPECT_LT(nearest, 0.03);  // the path passes the wall as near as it may
  EXPECT_GT(test::denseClearance(problem, followed, 0.002, 1.0), problem.margins.common);
  const auto refused = [&](std::vector<double> errors, const char* why) {
    options.joint_errors = std::move(errors);
    robots::expectInputError([&] { Replanner{problem, options}; }, "test", 0, {"Replanner", why});
  };
  refused({0.1}, "joint_errors has 1 numbers; 3 are expected");
  refused({0, -1, 0}, "joint_errors[1] is -1; 0 or more");
}

/// Regression: a robot that was measured ahead of its drive stopped at the joint's limit at once,
/// at 46 m/s^2, in a step that was certified.
TEST(Replanner, MeasuredBesideItsDriveItKeepsItsLimits) {
  for (const double ahead : {0.2, 0.01}) {
    Problem problem = test::problemOf(test::disc(), {0, 0, 0}, {2, 0, 0});
    problem.world.objects.push_back(test::box("wall", {1, 1, 1}, 0, 5, 0));
    const std::string& x = problem.robot.model->variables[0].name;
    problem.execution.velocities[x] = 1;
    problem.execution.accelerations[x] = 2;
    Replanner replanner(problem);
    std::vector<TimedPoint> rows;
    double most = 0, last = 0;  // acceleration
    bool certified = true;
    for (int k = 0; k < 200 && !replanner.reached(); ++k) {
      const ReplanStep step = replanner.step();
      certified = certified && step.certified;
      for (const TimedPoint& row : step.motion)
        if (rows.empty() || row.time > rows.back().time) rows.push_back(row);
      if (replanner.state()[0] < 1 || last > 0) continue;
      std::vector<double> measured(replanner.state().begin(), replanner.state().end());
      measured[0] += last = ahead;
      replanner.setState(measured);
      rows = {{replanner.time(), measured}};
    }
    EXPECT_EQ(last, ahead);
    EXPECT_TRUE(certified);
    EXPECT_TRUE(replanner.reached());
    const auto velocity = [&](std::size_t i) {
      return (rows[i].position[0] - rows[i - 1].position[0]) / (rows[i].time - rows[i - 1].time);
    };
    for (std::size_t i = 2; i < rows.size(); ++i)
      most = std::max(most,
                      std::abs(velocity(i) - velocity(i - 1)) / (rows[i].time - rows[i - 1].time));
    EXPECT_LE(most, 2 * (1 + 1e-5));
  }
}

TEST(Replanner, VerticesWithoutASpeedBoundStopTheRobot) {
  Problem problem = gate({{0, {0, 0, 1.5}}, {1, {0, 0, 1.5}}});
  problem.world.deforming[0].motion = nullptr;
  Replanner replanner(problem);
  const ReplanStep step = replanner.step();
  EXPECT_EQ(step.decision, Decision::kUnsafe);
  EXPECT_FALSE(step.certified);
  EXPECT_TRUE(step.exposed);
  EXPECT_NE(step.why.find("it stands, where an obstacle may reach it: "), std::string::npos)
      << step.why;
  EXPECT_EQ(step.motion.front().position, step.motion.back().position);
}

TEST(Replanner, TheSameSeedTakesTheSameSteps) {
  const Problem problem =
      gate({{0, {0, 0, 1.5}}, {0.7, {0, 0, 1.5}}, {1.2, {0, 0, 0}}, {2, {0, 0, 2}}});
  const ReplanResult one = replan(problem), two = replan(problem);
  ASSERT_EQ(one.trajectory.size(), two.trajectory.size());
  for (std::size_t i = 0; i < one.trajectory.size(); ++i) {
    EXPECT_EQ(one.trajectory[i].time, two.trajectory[i].time);
    EXPECT_EQ(one.trajectory[i].position, two.trajectory[i].position);
  }
  EXPECT_EQ(one.clearance.lower, two.clearance.lower);
  EXPECT_EQ(one.clearance.upper, two.clearance.upper);
}

TEST(Replanner, ScenesAreReadByOthersWhileTheNextIsMade) {
  const Problem problem = gate({{0, {0, 0, 1.5}}, {4, {0, 0, 0}}});
  Replanner replanner(problem);
  replanner.step();
  std::vector<std::thread> readers;
  std::vector<PlanResult> results(6);
  for (int k = 0; k < 6; ++k) {
    readers.emplace_back([&results, k, scene = replanner.scene(), &problem] {
      results[static_cast<std::size_t>(k)] = plan(scene, problem);
    });
    replanner.step();
  }
  for (std::thread& reader : readers) reader.join();
  for (const PlanResult& result : results) EXPECT_EQ(result.status, PlanStatus::kSolved);
}

TEST(Replanner, RefusesSettingsThatMakeNoSense) {
  Problem problem = test::wallProblem();
  problem.execution.step = 0.05;
  const struct {
    double Execution::*setting;
    double value;
    const char* told;
  } cases[] = {
      {&Execution::start, HUGE_VAL, "execution.start is inf; a finite number"},
      {&Execution::step, 0, "execution.step is 0; a number above 0 is expected"},
      {&Execution::duration, 0.01, "execution.duration is 0.01; at least a step, 0.05 s,"},
      {&Execution::speed, 2,
       "execution.speed is 2; a share of the velocity limits, 1e-09 up to 1,"},
      {&Execution::look_ahead, std::nan(""), "execution.look_ahead is nan; zero or more"},
      {&Execution::look_ahead, 51, "execution.look_ahead is 51; at most 1000 steps of 0.05 s"},
      {&Execution::buffer, -0.5, "execution.buffer is -0.5; zero or more"},
      {&Execution::patience, -1, "execution.patience is -1; zero or more"},
  };
  for (const auto& c : cases) {
    Problem broken = problem;
    broken.execution.*c.setting = c.value;
    try {
      const Replanner replanner(broken);
      ADD_FAILURE() << "accepted: " << c.told;
    } catch (const robots::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(c.told), std::string::npos) << error.what();
    }
  }
  EXPECT_NO_THROW(Replanner{problem});
  problem.world.deforming.push_back({{"nobody", {}, {}}, nullptr, nullptr, 1, {}});
  EXPECT_THROW(Replanner{problem}, robots::InputError);
}

/// Shipped scenes: reached, every step certified and free, and the first path alone would fail.
class ShippedScene : public testing::TestWithParam<const char*> {};

TEST_P(ShippedScene, IsExecutedAndNeedsReplanning) {
  const Problem problem = loadProblem(leeway::sourceFolder() + "/problems/" + GetParam() + ".yaml");
  const ReplanResult result = replan(
      problem, {}, [&](const ReplanStep& step) { EXPECT_TRUE(step.certified) << step.time; });
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_GT(result.replans + result.waits + result.evasions, 0);
  expectTruth(problem, result, 0.02);
  // The first path alone, executed blindly, violates the margin.
  const PlanResult alone = plan(problem);
  ASSERT_EQ(alone.status, PlanStatus::kSolved);
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  std::vector<TimedPoint> blind = {{problem.execution.start, alone.path.positions.front()}};
  for (std::size_t i = 1; i < alone.path.positions.size(); ++i)
    blind.push_back(
        {blind.back().time + edgeDuration(space, velocityLimits(problem),
                                          alone.path.positions[i - 1], alone.path.positions[i]),
         alone.path.positions[i]});
  EXPECT_LE(test::denseClearance(problem, blind, 0.02, 1.0), 0);
}

INSTANTIATE_TEST_SUITE_P(Files, ShippedScene,
                         testing::Values("deforming/curtain", "deforming/heap", "deforming/figure",
                                         "moving/conveyor", "moving/walker"),
                         [](const auto& scene) {
                           const std::string name = scene.param;
                           return name.substr(name.find('/') + 1);
                         });

/// Random sheets fly through the room, and what is known of them is true: nothing touches a robot
/// that moves, and where one may reach a robot that stands, the status says that. So it is where
/// the work of a step decides little.
TEST(Replanner, RandomSheetsNeverTouchARobotThatMoves) {
  int steps = 0, disturbed = 0, reached = 0, exposed = 0;
  for (int seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    Random random(77, static_cast<std::uint64_t>(seed));
    Problem problem = test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0});
    problem.margins.common = 0.01;
    problem.limits.iterations = 300;
    problem.execution.step = 0.1;
    problem.execution.duration = 8;
    problem.seed = static_cast<std::uint64_t>(seed);
    if (seed % 3 == 2) problem.execution.foresight = Foresight::kSpeedBound;
    for (int k = 0; k < 3; ++k) {
      const Sheet s = sheet(-0.3, 0.3, 3);
      std::vector<std::pair<double, Eigen::Vector3d>> keys;
      for (int key = 0; key < 4; ++key)
        keys.push_back({1.3 * key, {random.uniform(-0.8, 1.2), random.uniform(-1.2, 1.2), 0}});
      problem.world.deforming.push_back(obstacle("sheet " + std::to_string(k), s, keys));
    }
    ReplanOptions options;
    if (seed % 4 == 3) options.work = 100'000;
    const ReplanResult result = replan(problem, options, [&](const ReplanStep& step) {
      std::vector<TimedPoint> moves = step.motion;
      if (!step.certified) {
        EXPECT_TRUE(step.exposed) << step.time << ": " << step.why;
        EXPECT_TRUE(step.stop.empty());
        while (moves.size() > 1 && moves[moves.size() - 2].position == moves.back().position)
          moves.pop_back();
      }
      if (moves.size() > 1) {
        EXPECT_GT(test::denseClearance(problem, moves, 0.005, 1.0), problem.margins.common)
            << step.time;
      }
    });
    EXPECT_NE(result.status, ReplanStatus::kUnsafe);
    EXPECT_EQ(result.certified, result.status != ReplanStatus::kExposed);
    steps += result.steps;
    disturbed += result.waits + result.replans + result.evasions > 0 ? 1 : 0;
    reached += result.status == ReplanStatus::kReached ? 1 : 0;
    exposed += result.status == ReplanStatus::kExposed ? 1 : 0;
  }
  EXPECT_GE(disturbed, 12);
  EXPECT_GE(reached, 12);
  EXPECT_GE(exposed, 1);
  EXPECT_GT(steps, 200);
}

}  // namespace
}  // namespace leeway::planner
