#include "leeway/planner/verify.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/kinematics.h"
#include "planner/verify/kinematics.h"
#include "planner/verify/pairs.h"
#include "planner/verify/path_check.h"
#include "tests/support/polycubes.h"
#include "tests/support/random_problem.h"

namespace leeway::planner {
namespace {

using collision::Shape;
using Eigen::Vector3d;
using robots::Joint;
using robots::JointType;
using robots::Model;
using robots::Pose;

Pose shifted(double x, double y, double z) {
  return {Eigen::Matrix3d::Identity(), Vector3d(x, y, z)};
}

/// Builds robots link by link.
struct Builder {
  robots::RobotDescription model;

  int add(const std::string& name, int parent, JointType type, const Pose& X_PJ,
          const Vector3d& axis, std::vector<robots::Geometry> geometries, double limit = 3) {
    const int i = static_cast<int>(model.links.size());
    Joint joint;
    joint.name = name + "_joint";
    joint.type = type;
    joint.parent_link = parent;
    joint.child_link = i;
    joint.X_PJ = X_PJ;
    joint.axis = axis.normalized();
    joint.variable_count = type == JointType::kFixed      ? 0
                           : type == JointType::kPlanar   ? 3
                           : type == JointType::kFloating ? 7
                                                          : 1;
    if (joint.variable_count > 0) joint.first_variable = static_cast<int>(model.variables.size());
    for (int k = 0; k < joint.variable_count; ++k) {
      const bool bounded = type == JointType::kRevolute || type == JointType::kPrismatic;
      model.variables.push_back(
          {joint.name + (joint.variable_count > 1 ? "/" + std::to_string(k) : ""), i,
           bounded ? -limit : -kInfinity, bounded ? limit : kInfinity, kInfinity});
    }
    model.joints.push_back(joint);
    model.links.push_back({name, i, std::move(geometries)});
    return i;
  }
};

/// A planar arm of two bars of 1 m, 0.1 m thick, in the plane z = 0.
std::shared_ptr<const Model> arm() {
  Builder b;
  b.add("base", -1, JointType::kFixed, {}, Vector3d::UnitZ(), {});
  const robots::Geometry bar{Shape::box({0.5, 0.05, 0.05}), shifted(0.5, 0, 0), "bar"};
  b.add("upper", 0, JointType::kRevolute, {}, Vector3d::UnitZ(), {bar});
  b.add("lower", 1, JointType::kRevolute, shifted(1, 0, 0), Vector3d::UnitZ(), {bar});
  return std::make_shared<Model>(b.model);
}

Problem problemFor(std::shared_ptr<const Model> model, const std::vector<double>& goal) {
  Problem problem;
  problem.robot.model = model;
  for (std::size_t i = 0; i < model->variables.size(); ++i)
    problem.robot.variables.push_back(static_cast<int>(i));
  problem.start = model->defaultConfiguration();
  Goal g{"goal", {}};
  for (double x : goal) g.ranges.emplace_back(x, x);
  problem.goals.push_back(g);
  return problem;
}

Object box(const std::string& name, const Vector3d& half, double x, double y, double z) {
  return {name, {{Shape::box(half), {}, ""}}, shifted(x, y, z)};
}

Path pathOf(const Problem& problem, std::vector<std::vector<double>> rows) {
  Path path;
  for (int v : problem.robot.variables)
    path.names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
  path.positions = std::move(rows);
  return path;
}

TEST(Verify, FreePathIsCertifiedWithAClearanceThatHolds) {
  Problem problem = problemFor(arm(), {1.5, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.5, 0, 0));
  const Path path = pathOf(problem, {{0, 0}, {0.5, 0.5}, {1.5, 0}});
  const VerifyResult result = verify(problem, path);
  ASSERT_EQ(result.status, VerifyStatus::kCertified) << result.reason;
  // Minimum at the start: the tip, at 2 m, is 0.4 m from the wall.
  EXPECT_LE(result.clearance_lower, 0.4);
  EXPECT_GE(result.clearance_lower, 0.1);
}

/// The interval of the clearance is as narrow as requested, and holds the true clearance: 0.4 m at
/// the start, where the tip is 2 m away.
TEST(Verify, ProvesTheClearanceAsCloselyAsIsAsked) {
  Problem problem = problemFor(arm(), {1.5, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.5, 0, 0));
  const Path path = pathOf(problem, {{0, 0}, {0.5, 0.5}, {1.5, 0}});
  const double least = verify(problem, path).clearance_upper;
  for (const double width : {1e-2, 1e-4, 1e-6}) {
    int asked = 0;
    const VerifyResult result = verify(problem, path, {}, [&](const Interval& clearance) {
      ++asked;
      return clearance.width() <= width;
    });
    ASSERT_EQ(result.status, VerifyStatus::kCertified) << result.reason;
    EXPECT_GT(asked, 0);
    EXPECT_LE(result.clearance_upper - result.clearance_lower, width);
    EXPECT_LE(result.clearance_upper, least);
  }
  // A path that is refuted stays so.
  problem.margins.common = 0.45;
  EXPECT_NE(verify(problem, path, {}, [](const Interval&) { return false; }).status,
            VerifyStatus::kCertified);
}

/// Where a pair keeps its distance, no width is proven without end: what is proven still holds.
TEST(Verify, AClearanceThatIsNotProvenCloselyIsABound) {
  Problem problem = problemFor(arm(), {1.5, 0});
  problem.world.objects.push_back(box("pillar", {0.1, 0.1, 1}, 0, 0, 3));
  const Path path = pathOf(problem, {{0, 0}, {1.5, 0}});
  const VerifyResult rough = verify(problem, path),
                     close = verify(problem, path, {}, [](const Interval&) { return false; });
  ASSERT_EQ(close.status, VerifyStatus::kCertified);
  EXPECT_GE(close.clearance_lower, rough.clearance_lower);
  EXPECT_LE(close.clearance_lower, close.clearance_upper);
}

/// A trajectory in samples has many edges: what they may cost grows with them.
TEST(Verify, PathsOfManyEdgesAreDecided) {
  Problem problem = problemFor(arm(), {1.5, 0});
  for (int i = 0; i < 500; ++i)
    problem.world.objects.push_back(
        box("box " + std::to_string(i), {0.1, 0.1, 0.1}, 4 + 0.3 * i, 0, 0));
  std::vector<std::vector<double>> rows;
  constexpr int kEdges = 11'000;
  for (int i = 0; i <= kEdges; ++i) rows.push_back({1.5 * i / kEdges, 0});
  const Path path = pathOf(problem, rows);
  ASSERT_GT(kEdges * problem.world.objects.size() * 2, 10'000'000U) << "the limit of a short path";
  const VerifyResult result = verify(problem, path);
  EXPECT_EQ(result.status, VerifyStatus::kCertified) << result.segment << ' ' << result.reason;
  EXPECT_GT(result.clearance_lower, 1);
}

/// Extremes and speed of cubics, by brute force.
TEST(Verify, CubicsAreBounded) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-2, 2);
  int overshoots = 0;
  for (int i = 0; i < 500; ++i) {
    const double q0 = number(random), q1 = i % 7 == 0 ? q0 : number(random);
    const double v0 = i % 5 == 0 ? 0 : 3 * number(random);
    const double v1 = i % 3 == 0 ? 2 * (q1 - q0) - v0 : 3 * number(random);  // third one: no cube
    const verification::Cubic cubic(q0, q1, v0, v1);
    EXPECT_EQ(cubic.at(0), q0);
    EXPECT_EQ(cubic.at(1), q1);
    double least = kInfinity, most = -kInfinity, speed = 0;
    const int steps = 2000;
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      // Hermite's form.
      const double q = q0 * (1 + 2 * t) * (1 - t) * (1 - t) + v0 * t * (1 - t) * (1 - t) +
                       q1 * t * t * (3 - 2 * t) - v1 * t * t * (1 - t);
      EXPECT_NEAR(cubic.at(t), q, 1e-14);
      const double v =
          6 * (q1 - q0) * t * (1 - t) + v0 * (1 - t) * (1 - 3 * t) + v1 * t * (3 * t - 2);
      least = std::min(least, q);
      most = std::max(most, q);
      speed = std::max(speed, std::abs(v));
    }
    EXPECT_LE(cubic.least(), least + 1e-14);
    EXPECT_GE(cubic.most(), most - 1e-14);
    EXPECT_GE(cubic.speed(), speed - 1e-13);
    EXPECT_NEAR(cubic.least(), least, 1e-5);
    EXPECT_NEAR(cubic.most(), most, 1e-5);
    EXPECT_NEAR(cubic.speed(), speed, 1e-4);
    overshoots += most > std::max(q0, q1) + 0.1;
  }
  EXPECT_GT(overshoots, 50);
}

/// The motion with rest before and after it, in almost no time: limits that are far away.
Path withRest(Path path, Problem& problem) {
  for (const int v : problem.robot.variables)
    problem.execution.velocities[problem.robot.model->variables[at(v)].name] = 100;
  path.positions.insert(path.positions.begin(), path.positions.front());
  path.positions.push_back(path.positions.back());
  path.times.insert(path.times.begin(), path.times.front() - 2.1e-5);
  path.times.push_back(path.times.back() + 2.1e-5);
  const std::vector<double> rest(path.names.size(), 0);
  path.velocities.insert(path.velocities.begin(), rest);
  path.velocities.push_back(rest);
  return path;
}

/// A motion of cubics is proven as it is, not as lines between its rows.
TEST(Verify, MotionsOfCubicsAreProven) {
  Problem problem = problemFor(arm(), {1.5, 0});
  problem.world.objects.push_back(
      box("post", {0.02, 0.02, 1}, 1.98 * std::cos(0.75), 1.98 * std::sin(0.75), 0));
  Path path = pathOf(problem, {{0, 0}, {1.5, 0}});
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted) << "the line";
  path.times = {2, 3};
  path.velocities = {{1.5, 0}, {1.5, 0}};
  EXPECT_EQ(verify(problem, withRest(path, problem)).status, VerifyStatus::kRefuted)
      << "still the line";
  path.velocities = {{1.5, 4}, {1.5, -4}};  // the elbow bends by 1 in the middle
  const VerifyResult bent = verify(problem, withRest(path, problem));
  EXPECT_EQ(bent.status, VerifyStatus::kCertified) << bent.reason;
  EXPECT_GT(bent.clearance_lower, 0.01);
  path.times = {2, 2.1};  // less time, less bend
  EXPECT_EQ(verify(problem, withRest(path, problem)).status, VerifyStatus::kRefuted);
  path.times = {2, 4.5};
  const VerifyResult beyond = verify(problem, withRest(path, problem));
  EXPECT_EQ(beyond.status, VerifyStatus::kCertified) << beyond.reason;
  path.times = {2, 12};
  EXPECT_EQ(verify(problem, withRest(path, problem)).status, VerifyStatus::kRefuted);
  EXPECT_NE(verify(problem, withRest(path, problem))
                .reason.find("after the row, outside its limits -3 to 3"),
            std::string::npos)
      << verify(problem, withRest(path, problem)).reason;
  // Free rows and a line, but a curve that collides.
  path.positions = {{0, 0}, {0.3, 0}};
  problem.goals[0].ranges = {{0.3, 0.3}, {0, 0}};
  path.times = {0, 1};
  path.velocities = {{0, 0}, {0, 0}};
  EXPECT_EQ(verify(problem, withRest(path, problem)).status, VerifyStatus::kCertified);
  path.velocities = {{4, 0}, {-4, 0}};
  const VerifyResult swings = verify(problem, withRest(path, problem));
  EXPECT_EQ(swings.status, VerifyStatus::kRefuted);
  EXPECT_EQ(swings.b == "post" ? swings.a : swings.b, "lower");
  // Times and velocities that are none.
  const auto refused = [&](const std::string& reason) {
    const VerifyResult result = verify(problem, path);
    EXPECT_EQ(result.status, VerifyStatus::kRefuted);
    EXPECT_NE(result.reason.find(reason), std::string::npos) << result.reason;
  };
  path.times = {1, 1};
  refused("not after that of the row before");
  path.times = {0, kInfinity};
  refused("not finite");
  path.times = {0};
  refused("1 times and 2 velocities for its 2 rows");
  path.times = {0, 1};
  path.velocities = {{0, 0}, {0}};
  refused("a velocity is missing");
  path.velocities = {};
  refused("2 times and 0 velocities");
  EXPECT_THROW(edgesOf(ConfigurationSpace(problem.robot.model, problem.robot.variables), path),
               std::invalid_argument);
  // Conditions are proven along lines only, so this motion is undecided.
  path.velocities = {{0, 0}, {0, 0}};
  problem.condition.accept = [](std::span<const double>) { return true; };
  const VerifyResult conditional = verify(problem, path);
  EXPECT_EQ(conditional.status, VerifyStatus::kUndecided);
  EXPECT_NE(conditional.reason.find("straight lines only"), std::string::npos);
}

/// Limits on velocity, acceleration and jerk, those that are stated, and rest at both ends.
TEST(Verify, MotionsKeepTheirLimits) {
  Problem problem = problemFor(arm(), {1, 0});
  const std::string joint = problem.robot.model->variables[0].name;
  problem.execution.velocities[joint] = 1.5;
  Path path = pathOf(problem, {{0, 0}, {0.5, 0}, {1, 0}});
  path.times = {0, 1, 2};
  path.velocities = {{0, 0}, {0.75, 0}, {0, 0}};  // a cubic of velocity 0.75, at most
  const auto expect = [&](const std::string& reason, int segment) {
    const VerifyResult result = verify(problem, path);
    if (reason.empty()) {
      EXPECT_EQ(result.status, VerifyStatus::kCertified) << result.reason;
      return;
    }
    EXPECT_EQ(result.status, VerifyStatus::kRefuted) << reason;
    EXPECT_NE(result.reason.find(reason), std::string::npos) << result.reason;
    EXPECT_EQ(result.segment, segment) << result.reason;
  };
  expect("", -1);
  problem.execution.speed = 0.4998;  // 0.7497
  expect("", -1);                    // within a thousandth
  problem.execution.speed = 0.4;
  expect("'s velocity after the row reaches 0.75, over its limit of 0.6", 0);
  problem.execution.speed = 1;
  problem.execution.accelerations[joint] = 1.5;  // as at both ends of the cubics
  expect("", -1);
  problem.execution.acceleration_scale = 0.9;
  expect("'s acceleration after the row reaches 1.5, over its limit of 1.35", 0);
  problem.execution.acceleration_scale = 1;
  problem.execution.jerks[joint] = 100;
  expect("'s acceleration jumps at the row, from 0 to 1.5, although its jerk is limited", 0);
  problem.execution.jerks.clear();
  problem.execution.accelerations.clear();
  path.velocities[0][0] = 0.01;
  expect(" moves at 0.01 in the first row; rest is expected", 0);
  path.velocities[0][0] = 0;
  path.velocities[2][0] = -0.01;
  expect(" moves at -0.01 in the last row; rest is expected", 1);
  // Smooth from rest to rest: jerk 32 in the quarters of a second.
  path.positions = {{0, 0}, {1.0 / 12, 0}, {0.5, 0}, {11.0 / 12, 0}, {1, 0}};
  path.times = {0, 0.25, 0.5, 0.75, 1};
  path.velocities = {{0, 0}, {1, 0}, {2, 0}, {1, 0}, {0, 0}};
  problem.execution = {};
  problem.execution.velocities[joint] = 2;
  problem.execution.accelerations[joint] = 8;
  problem.execution.jerks[joint] = 32;
  expect("", -1);
  problem.execution.jerks[joint] = 31;
  expect("'s jerk after the row reaches 32, over its limit of 31", 0);
  // Rounding hides what rows that are dense, or far from time 0, would show.
  problem.execution.jerks[joint] = 32;
  for (double& time : path.times) time += 1e14;
  expect("cannot be told", 0);
  path.times = {0, 1e-6, 2e-6, 3e-6, 4e-6};
  expect("cannot be told: the next row is 1e-06 s later", 0);
}

/// Against states at 2,000 places of random cubics.
TEST(Verify, MotionsOfCubicsAgreeWithTheirStates) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  int certified = 0, refuted = 0;
  for (int i = 0; i < 120; ++i) {
    Problem problem = problemFor(arm(), {0, 0});
    for (int k = 0; k < 2; ++k)
      problem.world.objects.push_back(box("box " + std::to_string(k), {0.06, 0.06, 0.3},
                                          2 * number(random), 2 * number(random), 0));
    Path path =
        pathOf(problem, {{number(random), number(random)}, {number(random), number(random)}});
    for (std::size_t v = 0; v < 2; ++v) {
      problem.start[v] = path.positions[0][v];
      problem.goals[0].ranges[v] = {path.positions[1][v], path.positions[1][v]};
    }
    path.times = {0, 0.5};
    path.velocities = {{4 * number(random), 4 * number(random)},
                       {4 * number(random), 4 * number(random)}};
    const VerifyResult result = verify(problem, withRest(path, problem));
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    bool free = true;
    for (int k = 0; k <= 2000; ++k) {
      const double t = k / 2000.0;
      std::vector<double> q(2);
      for (std::size_t v = 0; v < 2; ++v)
        q[v] = path.positions[0][v] * (1 + 2 * t) * (1 - t) * (1 - t) +
               0.5 * path.velocities[0][v] * t * (1 - t) * (1 - t) +
               path.positions[1][v] * t * t * (3 - 2 * t) -
               0.5 * path.velocities[1][v] * t * t * (1 - t);
      free = free && certifier.decide(q) == Verdict::kFree;
    }
    if (result.status == VerifyStatus::kCertified) {
      ++certified;
      EXPECT_TRUE(free) << i;
    }
    refuted += result.status == VerifyStatus::kRefuted;
    if (free) {
      EXPECT_NE(result.status, VerifyStatus::kRefuted) << i;
    }
  }
  EXPECT_GT(certified, 20);
  EXPECT_GT(refuted, 20);
}

TEST(Verify, ObstacleBetweenWaypointsIsFoundInItsSegment) {
  Problem problem = problemFor(arm(), {1.5, 0});
  problem.world.objects.push_back(
      box("post", {0.02, 0.02, 1}, 1.8 * std::cos(1.0), 1.8 * std::sin(1.0), 0));
  const Path path = pathOf(problem, {{0, 0}, {0.5, 0}, {1.5, 0}});
  const VerifyResult result = verify(problem, path);
  ASSERT_EQ(result.status, VerifyStatus::kRefuted);
  EXPECT_EQ(result.segment, 1);
  EXPECT_NEAR(result.t0, 0.5, 0.05);
  EXPECT_EQ(result.t0, result.t1);
  EXPECT_EQ(result.a, "lower");
  EXPECT_EQ(result.b, "post");
  EXPECT_NE(result.reason.find("apart"), std::string::npos);
}

/// A wire of 0.1 mm: stepping checks with practical steps miss it.
TEST(Verify, ThinObstaclesAreNotJumpedOver) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 40; ++i) {
    Problem problem = problemFor(arm(), {2.5, 0});
    const double angle = std::uniform_real_distribution<double>(0.2, 2.4)(random);
    const double r = std::uniform_real_distribution<double>(0.3, 1.9)(random);
    problem.world.objects.push_back({"wire",
                                     {{Shape::cylinder(5e-5, 1), {}, ""}},
                                     shifted(r * std::cos(angle), r * std::sin(angle), 0)});
    EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}, {2.5, 0}})).status, VerifyStatus::kRefuted)
        << angle << ' ' << r;
    problem.world.objects[0].geometries[0].shape = Shape::sphere(0);  // a point
    EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}, {2.5, 0}})).status, VerifyStatus::kRefuted)
        << angle << ' ' << r;
  }
}

/// The tip passes a post at a given distance: certified if and only if there is clearance.
TEST(Verify, GrazingPassesAreDecidedToTheMicrometre) {
  for (double gap : {1e-2, 1e-4, 1e-6, -1e-6, -1e-4}) {
    Problem problem = problemFor(arm(), {1.5, 0});
    // The straight arm's far corners reach sqrt(2^2 + 0.05^2).
    const double reach = std::sqrt(4 + 0.0025);
    problem.world.objects.push_back(
        {"post",
         {{Shape::cylinder(0.1, 1), {}, ""}},
         shifted((reach + 0.1 + gap) * std::cos(0.7), (reach + 0.1 + gap) * std::sin(0.7), 0)});
    const VerifyResult result = verify(problem, pathOf(problem, {{0, 0}, {1.5, 0}}));
    EXPECT_EQ(result.status, gap > 0 ? VerifyStatus::kCertified : VerifyStatus::kRefuted)
        << gap << ' ' << result.reason;
    if (gap > 0) {
      EXPECT_LE(result.clearance_lower, gap);
      EXPECT_GE(result.clearance_lower, gap / 5);  // promised in verify.h
    }
  }
}

TEST(Verify, MarginsCount) {
  Problem problem = problemFor(arm(), {1, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.3, 0, 0));  // 0.2 m from the tip
  const Path path = pathOf(problem, {{0, 0}, {1, 0}});
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  problem.margins.common = 0.25;
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
  problem.margins.pairs.push_back({"wall", "lower", 0.1});
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  problem.margins.pairs[0].margin = 0.3;
  const VerifyResult refuted = verify(problem, path);
  EXPECT_EQ(refuted.status, VerifyStatus::kRefuted);
  EXPECT_EQ(refuted.a, "lower");
}

/// The words for the whole robot and the whole world, in the order of their entries.
TEST(Verify, MarginsOfTheWholeWorldCount) {
  Problem problem = problemFor(arm(), {1, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.3, 0, 0));  // 0.2 m from the tip
  const Path path = pathOf(problem, {{0, 0}, {1, 0}});
  const auto statusWith = [&](std::vector<PairMargin> margins) {
    problem.margins.pairs = std::move(margins);
    return verify(problem, path).status;
  };
  EXPECT_EQ(statusWith({{"robot", "world", 0.25}}), VerifyStatus::kRefuted);
  EXPECT_EQ(statusWith({{"world", "lower", 0.25}}), VerifyStatus::kRefuted);
  EXPECT_EQ(statusWith({{"robot", "wall", 0.25}}), VerifyStatus::kRefuted);
  EXPECT_EQ(statusWith({{"world", "upper", 0.25}}), VerifyStatus::kCertified);
  EXPECT_EQ(statusWith({{"robot", "world", 0.25}, {"lower", "wall", 0.1}}),
            VerifyStatus::kCertified);
  EXPECT_EQ(statusWith({{"lower", "wall", 0.1}, {"robot", "world", 0.25}}), VerifyStatus::kRefuted);
  EXPECT_EQ(statusWith({{"robot", "robot", 0.25}}), VerifyStatus::kCertified) << "neighbours";
  problem.margins.common = 0.25;
  EXPECT_EQ(statusWith({{"robot", "world", 0.1}}), VerifyStatus::kCertified);
}

/// Many URDFs have a root link named "world", without shapes: the word still stands for all
/// objects. With shapes, the name is the link's.
TEST(Verify, ALinkNamedWorldTakesTheWordIfItHasShapes) {
  auto model = std::make_shared<Model>(*arm());
  model->links[0].name = "world";
  Problem problem = problemFor(model, {1, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.3, 0, 0));
  problem.margins.pairs = {{"lower", "world", 0.25}};
  const Path path = pathOf(problem, {{0, 0}, {1, 0}});
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
  const CompiledScene bare(problem);
  for (const collision::ScenePair& pair : bare.scene().pairs())
    EXPECT_EQ(pair.margin, pair.body_a == 1 ? 0.25 : 0) << pair.body_a;

  auto shaped = std::make_shared<Model>(*model);
  shaped->links[0].geometries = {{Shape::sphere(0.01), shifted(0, 0, -1), "foot"}};
  problem.robot.model = shaped;
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  const CompiledScene scene(problem);
  for (const collision::ScenePair& pair : scene.scene().pairs())
    EXPECT_EQ(pair.margin,
              scene.isOfRobot(pair) && (pair.body_a == 2 || pair.body_b == 2) ? 0.25 : 0);
  problem.margins.pairs = {{"robot", "world", 0.25}};
  EXPECT_THROW(verify(problem, path), robots::InputError);
}

TEST(Verify, AllowedDepthOfConvexShapes) {
  Problem problem = problemFor(arm(), {1, 0});
  problem.world.objects.push_back(
      box("wall", {0.1, 0.1, 1}, 2.05, 0, 0));  // 0.05 m deep at the start
  const Path path = pathOf(problem, {{0, 0}, {1, 0}});
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
  problem.margins.common = -0.06;
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  problem.margins.common = -0.04;
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
}

TEST(Verify, WaypointsLimitsStartAndGoal) {
  Problem problem = problemFor(arm(), {1, 0});
  const auto expect = [&](const Path& path, int segment, double t, const std::string& word) {
    const VerifyResult result = verify(problem, path);
    EXPECT_EQ(result.status, VerifyStatus::kRefuted) << word;
    EXPECT_EQ(result.segment, segment) << word;
    EXPECT_EQ(result.t0, t) << word;
    EXPECT_NE(result.reason.find(word), std::string::npos) << result.reason;
  };
  EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}, {1, 0}})).status, VerifyStatus::kCertified);
  EXPECT_EQ(verify(problem, pathOf(problem, {{1e-10, 0}, {1, -1e-10}})).status,
            VerifyStatus::kCertified);
  expect(pathOf(problem, {{0, 0}, {3.1, 0}, {1, 0}}), 1, 0, "upper_joint is 3.1");
  expect(pathOf(problem, {{0, 0}, {1, -3.1}}), 0, 1, "lower_joint is -3.1");
  expect(pathOf(problem, {{0, 0}, {1, kInfinity}}), 0, 1, "not finite");
  expect(pathOf(problem, {{0, 0}, {1, std::nan("")}}), 0, 1, "not finite");
  expect(pathOf(problem, {{1e-6, 0}, {1, 0}}), 0, 0, "not the start");
  expect(pathOf(problem, {{0, 0}, {1, 1e-6}}), 0, 1, "goals");
  expect(pathOf(problem, {}), 0, 0, "no waypoints");
  expect(pathOf(problem, {{0, 0}, {1}}), 0, 1, "values");
  Path renamed = pathOf(problem, {{0, 0}, {1, 0}});
  renamed.names[1] = "elbow";
  expect(renamed, 0, 0, "columns");
  problem.goals.push_back({"range", {{1.5, 2.0}, {-0.5, 0.5}}});
  EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}, {1.75, 0.25}})).status,
            VerifyStatus::kCertified);
  expect(pathOf(problem, {{0, 0}, {2.01, 0.25}}), 0, 1, "goals");
}

TEST(Verify, OneWaypointIsAnEdgeThatDoesNotMove) {
  Problem problem = problemFor(arm(), {0, 0});
  EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}})).status, VerifyStatus::kCertified);
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.05, 0, 0));
  EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}})).status, VerifyStatus::kRefuted);
}

TEST(Verify, TouchingIsNotCertified) {
  Problem problem = problemFor(arm(), {1, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.1, 0, 0));
  EXPECT_NE(verify(problem, pathOf(problem, {{0, 0}, {1, 0}})).status, VerifyStatus::kCertified);
}

TEST(Verify, SelfCollisionAdjacencyAndAllowedPairs) {
  Builder b;
  b.add("base", -1, JointType::kFixed, {}, Vector3d::UnitZ(),
        {{Shape::box({0.2, 0.2, 0.2}), {}, ""}});
  const robots::Geometry bar{Shape::box({0.5, 0.05, 0.05}), shifted(0.5, 0, 0), "bar"};
  b.add("upper", 0, JointType::kRevolute, {}, Vector3d::UnitZ(), {bar});
  b.add("lower", 1, JointType::kRevolute, shifted(1, 0, 0), Vector3d::UnitZ(), {bar});
  Problem problem = problemFor(std::make_shared<Model>(b.model), {0, 2.9});
  const Path path = pathOf(problem, {{0, 0}, {0, 2.9}});  // the lower arm folds back onto the base
  const VerifyResult result = verify(problem, path);
  ASSERT_EQ(result.status,
            VerifyStatus::kRefuted);  // base-upper and upper-lower always overlap: adjacent
  EXPECT_EQ(result.a, "base");
  EXPECT_EQ(result.b, "lower");
  problem.contacts.allowed.emplace_back("lower", "base");
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  problem.contacts.allowed.clear();
  b.model.has_srdf = true;
  b.model.disabled_pairs.push_back({0, 2, "Never"});
  problem.robot.model = std::make_shared<Model>(b.model);
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  problem.contacts.checked = {{"upper", "base"}};
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
  problem.contacts.checked.clear();
  problem.contacts.replace_srdf = true;
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
}

TEST(Verify, PassiveJointsDoNotMoveAndFixedBlocksAreAdjacent) {
  Builder b;
  const auto ball = [](double r) {
    return std::vector<robots::Geometry>{{Shape::sphere(r), {}, ""}};
  };
  b.add("base", -1, JointType::kFixed, {}, Vector3d::UnitZ(), ball(0.1));
  b.add("cover", 0, JointType::kFixed, shifted(0, 0, 0.1), Vector3d::UnitZ(), ball(0.1));
  b.add("arm", 0, JointType::kRevolute, {}, Vector3d::UnitZ(), ball(0.1));
  b.add("tool", 2, JointType::kFixed, shifted(0, 0, 0.1), Vector3d::UnitZ(), ball(0.1));
  b.add("finger", 3, JointType::kPrismatic, shifted(0, 0, 0.2), Vector3d::UnitX(), ball(0.02));
  Problem problem = problemFor(std::make_shared<Model>(b.model), {1});
  problem.robot.variables = {0};
  EXPECT_EQ(
      verification::collectPairs(problem, verification::collectBodies(problem)).checked.size(), 2u)
      << "base-finger and cover-finger; the rest is adjacent or rigid";
  b.model.has_srdf = true;
  problem.robot.model = std::make_shared<Model>(b.model);
  // With an SRDF only links that share a joint are adjacent: adds base-tool, cover-arm, cover-tool;
  // arm-finger and tool-finger do not move.
  EXPECT_EQ(
      verification::collectPairs(problem, verification::collectBodies(problem)).checked.size(), 5u);
}

TEST(Verify, AttachedBodiesMoveAndMayTouchWhatTheyMay) {
  Problem problem = problemFor(arm(), {1, 0});
  problem.world.objects.push_back(box("wall", {0.1, 0.1, 1}, 2.6, 0, 0));
  problem.world.objects.push_back(
      box("shelf", {0.1, 0.1, 0.1}, 2.3 * std::cos(0.5), 2.3 * std::sin(0.5), 0));
  Attachment held;
  held.object = {"stick", {{Shape::capsule(0.02, 0.2), {}, ""}}, {}};
  held.link = 2;
  held.X_LO.translation = {1.2, 0, 0};
  held.X_LO.rotation << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // its axis along the arm
  problem.robot.attachments.push_back(held);
  const Path path = pathOf(problem, {{0, 0}, {1, 0}});
  const VerifyResult result = verify(problem, path);
  ASSERT_EQ(result.status, VerifyStatus::kRefuted);
  EXPECT_EQ(result.a, "stick");
  EXPECT_EQ(result.b, "shelf");
  EXPECT_NEAR(result.t0, 0.5, 0.1);
  problem.contacts.allowed.emplace_back("stick", "shelf");
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
  problem.robot.attachments[0].X_LO.translation = {-0.5, 0, 0};  // into the upper arm
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kRefuted);
  problem.robot.attachments[0].touch_links = {1};
  EXPECT_EQ(verify(problem, path).status, VerifyStatus::kCertified);
}

TEST(Verify, FreeBodyThroughAWindow) {
  for (double width : {0.3, 0.38, 0.42}) {
    // A 1 m stick makes half a turn while flying through a gap along x, `width` less than its
    // length.
    const auto body = robots::freeBody("stick", {{Shape::box({0.5, 0.02, 0.02}), {}, ""}},
                                       JointType::kFloating, {-3, -3, -3}, {3, 3, 3});
    Problem problem = problemFor(body, {0, 2, 0, 0, 0, 1, 0});
    problem.start = {0, -2, 0, 0, 0, 0, 1};
    problem.world.objects.push_back(box("left", {0.5, 0.01, 1}, -0.5 - width / 2, 0, 0));
    problem.world.objects.push_back(box("right", {0.5, 0.01, 1}, 0.5 + width / 2, 0, 0));
    // Half a turn about z: at y = 0 the stick points along y and fits if the gap allows for its
    // turning.
    const Path path = pathOf(problem, {{0, -2, 0, 0, 0, 0, 1}, {0, 2, 0, 0, 0, 1, 0}});
    const VerifyResult result = verify(problem, path);
    // Dense sampling: minimum distance between the stick and the walls' edges.
    double least = 1;
    for (int i = 0; i <= 4000; ++i) {
      const double t = i / 4000.0, angle = M_PI * t, y = -2 + 4 * t;
      for (double u = -0.5; u <= 0.5; u += 0.002) {
        const double px = u * std::cos(angle), py = y + u * std::sin(angle);
        if (std::abs(py) <= 0.01) least = std::min(least, width / 2 - std::abs(px));
      }
    }
    const bool free = least > 0.03, hit = least < -0.03;
    if (free) {
      EXPECT_EQ(result.status, VerifyStatus::kCertified) << width << ' ' << result.reason;
    }
    if (hit) {
      EXPECT_EQ(result.status, VerifyStatus::kRefuted) << width;
    }
  }
}

TEST(Verify, SolidMeshesHoldWhatIsInsideThem) {
  // A 2 m cube as a mesh: the arm's tip ends wholly inside, not touching the surface at the end.
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
  const std::vector<collision::TriangleMesh::Triangle> faces = {
      {0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto body = robots::freeBody("fly", {{Shape::sphere(0.1), {}, ""}}, JointType::kFloating,
                                     {-9, -9, -9}, {9, 9, 9});
  Problem problem = problemFor(body, {0.3, 0.2, 0.1, 0, 0, 0, 1});
  problem.start = problem.robot.model->defaultConfiguration();
  problem.world.objects.push_back(
      {"cube", {{Shape::mesh(collision::TriangleMesh::make(corners, faces)), {}, ""}}, {}});
  const Path inside = pathOf(problem, {{0, 0, 0, 0, 0, 0, 1}, {0.3, 0.2, 0.1, 0, 0, 0, 1}});
  EXPECT_EQ(verify(problem, inside).status, VerifyStatus::kRefuted);
  // Depths of meshes below zero are unprovable: reported at the first check, not after half a
  // million (minutes).
  problem.margins.common = -5;
  const VerifyResult deep = verify(problem, inside);
  EXPECT_EQ(deep.status, VerifyStatus::kUndecided);
  EXPECT_EQ(deep.t0, 0.5);
  EXPECT_EQ(deep.t1, 0.5);
  problem.margins.common = 0;
  problem.start[0] = 3;
  problem.goals[0].ranges[0] = {3, 3};
  EXPECT_EQ(
      verify(problem, pathOf(problem, {{3, 0, 0, 0, 0, 0, 1}, {3, 0.2, 0.1, 0, 0, 0, 1}})).status,
      VerifyStatus::kCertified);
}

// Bricks, and concave solids of cells, pass through each other along their faces: no triangle of
// one crosses a triangle of the other at any time. Regression: paths through them stayed undecided
// after seconds, and so did states half inside.
TEST(Verify, SolidsWithFlushSidesAreRefuted) {
  using collision::testing::Cells;
  const auto solid = [](const Cells& cells) {
    const auto soup = collision::testing::cellSoup(cells);
    return Shape::mesh(collision::TriangleMesh::make(soup.vertices, soup.triangles));
  };
  const auto brick = collision::testing::boxSoup({0.5, 0.5, 1}, {0.5, 0.5, 1});
  const std::vector<std::pair<Shape, Shape>> pairs = {
      {Shape::mesh(collision::TriangleMesh::make(brick.vertices, brick.triangles)),
       Shape::mesh(collision::TriangleMesh::make(brick.vertices, brick.triangles))},
      {solid({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}), solid({{0, 0, 0}, {0, 0, 1}, {0, 1, 0}})},
      {solid({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}}),
       solid({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}})}};
  for (const auto& [moving, standing] : pairs) {
    const auto body = robots::freeBody("moving", {{moving, {}, "moving"}}, JointType::kFloating,
                                       {-9, -9, -9}, {9, 9, 9});
    Problem problem = problemFor(body, {0, 0, -5, 0, 0, 0, 1});
    problem.start = {0, 0, 5, 0, 0, 0, 1};
    problem.world.objects.push_back({"standing", {{standing, {}, "standing"}}, {}});
    const std::vector<double> above{0, 0, 5, 0, 0, 0, 1}, below{0, 0, -5, 0, 0, 0, 1},
        half{0, 0, 1, 0, 0, 0, 1}, away{0, 0, 4, 0, 0, 0, 1};
    const VerifyResult result = verify(problem, pathOf(problem, {above, below}));
    EXPECT_EQ(result.status, VerifyStatus::kRefuted) << result.reason;
    problem.goals[0].ranges[2] = {4, 4};
    EXPECT_EQ(verify(problem, pathOf(problem, {above, away})).status, VerifyStatus::kCertified);
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    EXPECT_EQ(certifier.certify(above, below).verdict, collision::Verdict::kNotFree);
    EXPECT_EQ(certifier.certify(above, away).verdict, collision::Verdict::kFree);
    EXPECT_EQ(certifier.decide(half), collision::Verdict::kNotFree);
    const StateCheck check = certifier.clearance(half, 1e-6);
    EXPECT_EQ(check.verdict, collision::Verdict::kNotFree);
    EXPECT_LT(check.clearance.upper, -0.1);
  }
}

TEST(Verify, RowsAreStraightLinesAndJumpingMimicsAreNotCertified) {
  Builder b;
  const robots::Geometry bar{Shape::box({0.5, 0.05, 0.05}), shifted(0.5, 0, 0), "bar"};
  b.add("wheel", -1, JointType::kContinuous, {}, Vector3d::UnitZ(), {bar});
  Problem problem = problemFor(std::make_shared<Model>(b.model), {-3});
  problem.start[0] = 3;
  problem.world.objects.push_back(
      box("post", {0.1, 0.1, 0.1}, 0.7, 0, 0));  // at angle 0: the long way round hits it
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const auto shortest = [&](Path path) {
    path.positions = unwrapped(space, std::move(path.positions));
    return verify(problem, path).status;
  };
  const Path across = pathOf(problem, {{3}, {-3}}),
             around = pathOf(problem, {{3 - 2 * M_PI}, {-3 + 2 * M_PI}});
  EXPECT_EQ(verify(problem, across).status, VerifyStatus::kRefuted);
  EXPECT_EQ(verify(problem, around).status, VerifyStatus::kRefuted);
  EXPECT_EQ(shortest(across), VerifyStatus::kCertified);
  EXPECT_EQ(shortest(around), VerifyStatus::kCertified);
  // Two turns pass the post, wherever they begin.
  EXPECT_EQ(verify(problem, pathOf(problem, {{3}, {-3 + 6 * M_PI}})).status,
            VerifyStatus::kRefuted);
  EXPECT_EQ(verify(problem, pathOf(problem, {{3}, {-3 + 1000 * M_PI}})).status,
            VerifyStatus::kUndecided);
  problem.world.objects[0].X_WO.translation.x() = -0.7;
  problem.start[0] = 2.5;
  problem.goals[0].ranges[0] = {-2.5, -2.5};
  EXPECT_EQ(verify(problem, pathOf(problem, {{2.5}, {-2.5}})).status, VerifyStatus::kCertified);
  EXPECT_EQ(shortest(pathOf(problem, {{2.5}, {-2.5}})), VerifyStatus::kRefuted);
  problem.start[0] = 3;
  problem.goals[0].ranges[0] = {-3, -3};
  // A mimic at half the angle turns the opposite way when its master wraps.
  const int follower =
      b.add("follower", -1, JointType::kContinuous, shifted(0, 0, 5), Vector3d::UnitZ(), {bar});
  Joint& joint = b.model.joints[static_cast<std::size_t>(follower)];
  b.model.variables.pop_back();
  joint.mimic = 0;
  joint.first_variable = -1;
  joint.variable_count = 0;
  joint.multiplier = 0.5;
  problem.robot.model = std::make_shared<Model>(b.model);
  problem.world.objects.clear();
  const VerifyResult result = verify(problem, pathOf(problem, {{3}, {-3 + 2 * M_PI}}));
  EXPECT_EQ(result.status, VerifyStatus::kUndecided);
  EXPECT_NE(result.reason.find("follower_joint mimics wheel_joint"), std::string::npos)
      << result.reason;
  EXPECT_EQ(verify(problem, across).status, VerifyStatus::kCertified);
}

// The planner omits pairs without relative motion. Regression: it was refuted for that.
TEST(Verify, FollowersWithoutAFactorStandStill) {
  Builder b;
  const robots::Geometry bar{Shape::box({0.5, 0.05, 0.05}), shifted(0.5, 0, 0), "bar"};
  b.add("wheel", -1, JointType::kContinuous, {}, Vector3d::UnitZ(), {bar});
  const int follower = b.add("follower", 0, JointType::kRevolute, {}, Vector3d::UnitZ(), {});
  b.add("tip", follower, JointType::kFixed, {}, Vector3d::UnitZ(), {bar});
  Joint& joint = b.model.joints[static_cast<std::size_t>(follower)];
  b.model.variables.pop_back();
  joint.mimic = 0;
  joint.first_variable = -1;
  joint.variable_count = 0;
  joint.multiplier = 0;
  joint.offset = 0.2;
  b.model.has_srdf = true;
  const Problem problem = problemFor(std::make_shared<Model>(b.model), {1});
  EXPECT_TRUE(CompiledScene(problem).scene().pairs().empty());
  EXPECT_EQ(verify(problem, pathOf(problem, {{0}, {1}})).status, VerifyStatus::kCertified);
}

TEST(Verify, StopsWhenToldTo) {
  Problem problem = problemFor(arm(), {1, 0});
  for (int i = 0; i < 200; ++i)
    problem.world.objects.push_back(box("far " + std::to_string(i), {0.1, 0.1, 0.1}, 5, 5, i));
  PlanOptions options;
  options.stop = [] { return true; };
  const VerifyResult result = verify(problem, pathOf(problem, {{0, 0}, {1, 0}}), options);
  EXPECT_EQ(result.status, VerifyStatus::kUndecided);
  EXPECT_NE(result.reason.find("stopped"), std::string::npos);
}

// Checks of deeply overlapping meshes take milliseconds; their cost is counted. Regression: 20,000
// of them took 25 s merely to refute what was already undecided.
TEST(Verify, DeepMeshesEndWithTheirWork) {
  const auto body = robots::freeBody("ring", {{testing::bumpyRing(), {}, "ring"}},
                                     JointType::kPlanar, {-2, -2, 0}, {2, 2, 0});
  Problem problem = problemFor(body, {0.3, 0.1, 0.5});
  problem.start = {-0.3, 0, 0};
  problem.world.objects.push_back(
      {"other", {{testing::bumpyRing(), {}, ""}}, shifted(0.2, 0.05, 0.1)});
  // Little more than the depth: a coarse tolerance would be met by hulls alone.
  problem.margins.common = -0.2;
  PlanOptions options;
  int asked = 0;  // every 64 checks
  options.stop = [&asked] { return ++asked > 100; };
  const VerifyResult result =
      verify(problem, pathOf(problem, {{-0.3, 0, 0}, {0.3, 0.1, 0.5}}), options);
  EXPECT_EQ(result.status, VerifyStatus::kUndecided);
  EXPECT_EQ(result.reason, "a mesh that overlaps within its margin is not proven");
  EXPECT_LT(asked, 20);
}

TEST(Verify, HalfSpaces) {
  Problem problem = problemFor(arm(), {1, 0});
  problem.world.objects.push_back({"floor", {{Shape::halfSpace(), {}, ""}}, shifted(0, 0, -0.06)});
  EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}, {1, 0}})).status, VerifyStatus::kCertified);
  problem.world.objects[0].X_WO = shifted(0, 0, -0.04);
  EXPECT_EQ(verify(problem, pathOf(problem, {{0, 0}, {1, 0}})).status, VerifyStatus::kRefuted);
}

/// Minimum distance of the arm's bars to the objects over 1000 samples of an edge, by the planner's
/// kinematics.
double denseLook(const Problem& problem, const std::vector<double>& a,
                 const std::vector<double>& b) {
  collision::Scratch scratch;
  std::vector<Pose> X_WL(problem.robot.model->links.size());
  double least = kInfinity;
  for (int i = 0; i <= 1000; ++i) {
    const double t = i / 1000.0;
    robots::forwardKinematics(
        *problem.robot.model,
        std::vector<double>{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])}, X_WL);
    for (std::size_t l = 1; l < 3; ++l)
      for (const robots::Geometry& bar : problem.robot.model->links[l].geometries)
        for (const Object& object : problem.world.objects)
          least = std::min(
              least, collision::distance(bar.shape, X_WL[l] * bar.X_BG, object.geometries[0].shape,
                                         object.X_WO, {}, scratch)
                         .distance.lower);
  }
  return least;
}

TEST(Verify, RandomEdgesAgainstADenseLook) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int certified = 0, refuted = 0, undecided = 0, unsafe = 0, missed = 0, boast = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<double> a{2.9 * uniform(random), 2.9 * uniform(random)},
        b{a[0] + 0.7 * uniform(random), a[1] + 0.7 * uniform(random)};
    b[0] = std::clamp(b[0], -3.0, 3.0);
    b[1] = std::clamp(b[1], -3.0, 3.0);
    Problem problem = problemFor(arm(), b);
    problem.start = a;
    for (int k = 0; k < 3; ++k) {
      const Shape shapes[] = {Shape::box({0.1, 0.2, 0.3}), Shape::sphere(0.1),
                              Shape::capsule(0.05, 0.3)};
      problem.world.objects.push_back(
          {"o" + std::to_string(k),
           {{shapes[k], {}, ""}},
           shifted(2 * uniform(random), 2 * uniform(random), 0.2 * uniform(random))});
    }
    const VerifyResult result = verify(problem, pathOf(problem, {a, b}));
    const double least = denseLook(problem, a, b);
    certified += result.status == VerifyStatus::kCertified ? 1 : 0;
    refuted += result.status == VerifyStatus::kRefuted ? 1 : 0;
    undecided += result.status == VerifyStatus::kUndecided ? 1 : 0;
    unsafe += result.status == VerifyStatus::kCertified && least <= 0 ? 1 : 0;
    boast +=
        result.status == VerifyStatus::kCertified && result.clearance_lower > least + 1e-9 ? 1 : 0;
    missed += result.status != VerifyStatus::kCertified && least > 0.01
                  ? 1
                  : 0;  // resolution of 1000 samples
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_EQ(boast, 0);
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(undecided, 0);
  EXPECT_GT(certified, 60);
  EXPECT_GT(refuted, 60);
}

/// A robot with every kind of joint, at random.
Model everyJoint(std::mt19937_64& random) {
  Builder b;
  std::uniform_real_distribution<double> uniform(-1, 1);
  const JointType types[] = {JointType::kFloating, JointType::kRevolute,   JointType::kPlanar,
                             JointType::kFixed,    JointType::kContinuous, JointType::kPrismatic,
                             JointType::kRevolute};
  int parent = -1;
  for (int i = 0; i < 7; ++i) {
    Pose X;
    X.translation = {uniform(random), uniform(random), uniform(random)};
    const Eigen::Vector3d w(uniform(random), uniform(random), uniform(random));
    double s, c;
    collision::sineCosine(w.norm(), s, c);
    for (int k = 0; k < 3; ++k) {
      const Vector3d a = w.normalized(), e = Vector3d::Unit(k);
      X.rotation.col(k) = a * a[k] + c * (e - a * a[k]) + s * a.cross(e);
    }
    parent = b.add("l" + std::to_string(i), parent, types[i], X,
                   {uniform(random), uniform(random), uniform(random)}, {});
  }
  Joint& last = b.model.joints.back();
  last.mimic = 1;
  last.multiplier = -1.5;
  last.offset = 0.3;
  b.model.variables.pop_back();
  last.first_variable = -1;
  last.variable_count = 0;
  return Model(b.model);
}

TEST(VerifyKinematics, AgreesWithTheOtherKinematics) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (int i = 0; i < 500; ++i) {
    const Model model = everyJoint(random);
    std::vector<double> q;
    for (std::size_t v = 0; v < model.variables.size(); ++v) q.push_back(uniform(random));
    std::vector<Pose> fast(model.links.size());
    robots::forwardKinematics(model, q, fast);
    const std::vector<Pose> slow = verification::placeLinks(model, q);
    for (std::size_t l = 0; l < fast.size(); ++l) {
      ASSERT_LT((fast[l].rotation - slow[l].rotation).norm(), 1e-13);
      ASSERT_LT((fast[l].translation - slow[l].translation).norm(), 1e-12);
    }
  }
}

/// No point of a body moves farther than the bound, and some come near it.
TEST(VerifyKinematics, MotionBoundsHoldAndBite) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double tightest = 0;
  int unsafe = 0;
  for (int i = 0; i < 300; ++i) {
    const auto model = std::make_shared<Model>(everyJoint(random));
    std::vector<int> variables;
    for (std::size_t v = 0; v < model->variables.size(); ++v)
      variables.push_back(static_cast<int>(v));
    const ConfigurationSpace space(model, variables);
    const auto point = [&] {
      std::vector<double> q(variables.size());
      for (double& x : q) x = uniform(random);
      double* r = &q[3];
      const double norm = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
      for (int k = 0; k < 4; ++k) r[k] /= norm;
      return q;
    };
    std::vector<double> a = point(), b = point(), dq(a.size()), q(a.size());
    if (i % 2 == 0) {  // one joint alone
      const std::vector<double> c = b;
      b = a;
      const std::size_t v = static_cast<std::size_t>(i / 2) % 3 == 0   ? 7
                            : static_cast<std::size_t>(i / 2) % 3 == 1 ? 10
                                                                       : 11;
      b[v] = c[v];
    }
    space.difference(a, b, dq);
    const int link = 6;
    const Vector3d center_L(uniform(random), uniform(random), uniform(random));
    const double radius = 0.2, half = std::pow(10, -1.5 * (1 + uniform(random))) * 0.5,
                 middle = 0.5;
    space.interpolate(a, b, middle, q);
    const std::vector<Pose> X_WL = verification::placeLinks(*model, q);
    const auto motion = verification::boundMotion(*model, verification::jointsAbove(*model, link),
                                                  X_WL, dq, X_WL[link] * center_L, radius, half);
    for (int k = 0; k < 20; ++k) {
      Vector3d offset(uniform(random), uniform(random), uniform(random));
      const Vector3d p_L = center_L + offset.normalized() * radius;
      space.interpolate(a, b, middle + half * uniform(random), q);
      const double t_other = uniform(random);
      space.interpolate(a, b, middle + half * t_other, q);
      const double moved =
          (verification::placeLinks(*model, q)[link] * p_L - X_WL[link] * p_L).norm();
      const double bound = half * std::abs(t_other) * motion.speed + motion.slack;
      unsafe += moved > bound ? 1 : 0;
      tightest = std::max(tightest, moved / bound);
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(tightest, 0.7) << "the bound is never approached: it says nothing";
}

TEST(VerifyKinematics, SpheresHoldTheirShapes) {
  const std::vector<Vector3d> points = {{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}, {1, 1, 1}};
  const auto hull = verification::enclosingSphere(Shape::convexHull(points));
  for (const Vector3d& p : points) EXPECT_LE((p - hull.center).norm(), hull.radius);
  EXPECT_GE(verification::enclosingSphere(Shape::cone(3, 4)).radius, 5);
  EXPECT_GE(verification::enclosingSphere(Shape::cylinder(3, 4)).radius, 5);
  EXPECT_GE(verification::enclosingSphere(Shape::capsule(3, 4)).radius, 7);
  EXPECT_GE(verification::enclosingSphere(Shape::box({2, 3, 6})).radius, 7);
  EXPECT_GE(verification::enclosingSphere(Shape::ellipsoid({1, 3, 2})).radius, 3);
  EXPECT_TRUE(std::isinf(verification::enclosingSphere(Shape::halfSpace()).radius));
}

}  // namespace
}  // namespace leeway::planner
