// Rigid objects that move: compiled, replanned among, and what else sees them.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/guard.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/execute/obstacles.h"
#include "planner/execute/step_certifier.h"
#include "tests/support/dense_truth.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using collision::PoseMotion;

robots::Pose posed(double x, double y, double angle) {
  robots::Pose pose = test::at(x, y, 0);
  pose.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

ObjectMotion through(std::vector<PoseMotion::Key> keys) {
  return {.poses = PoseMotion::keys(std::move(keys))};
}

/// A bar that is 0.6 long, with the motion.
Object bar(const std::string& name, const ObjectMotion& motion) {
  return movingObject(test::box(name, {0.05, 0.3, 0.5}, 0, 0, 0), motion);
}

/// A disc at the left of a gap, which a bar closes.
Problem gate(const ObjectMotion& motion) {
  Problem problem = test::wallProblem();
  problem.start = {-1, 1.2, 0};
  problem.goals = {test::pointGoal("goal", {1, 1.2, 0})};
  problem.world.objects.push_back(bar("gate", motion));
  problem.margins.common = 0.01;
  problem.limits.iterations = 1000;
  problem.execution.duration = 12;
  return problem;
}

ReplanResult expectSafe(const Problem& problem) {
  const ReplanResult result = replan(problem);
  EXPECT_TRUE(result.certified);
  const double kept = test::denseClearance(problem, result.trajectory, 0.001, 1.0);
  EXPECT_GT(kept, problem.margins.common);
  EXPECT_GE(kept, result.clearance.lower - 1e-9);
  return result;
}

TEST(MovingObjects, ReplannerWaitsForAGateThatOpens) {
  const ReplanResult result = expectSafe(
      gate(through({{0, posed(0, 1.2, 0)}, {2, posed(0, 1.2, 0)}, {3, posed(0, 2.2, 0)}})));
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_GT(result.waits, 30);
}

TEST(MovingObjects, ReplannerPassesADoorThatTurns) {
  const ReplanResult result =
      expectSafe(gate(through({{0, posed(0, 1.2, 0)}, {3, posed(0, 1.2, 1.5)}})));
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  EXPECT_GT(result.waits + result.replans, 0);
}

TEST(MovingObjects, ReplannerEvadesWhatComesAtAConstantVelocity) {
  Problem problem = gate({.poses = PoseMotion::steady({0, test::at(-3, 1.2, 0)}, {0.4, 0, 0},
                                                      Eigen::Vector3d::Zero())});
  EXPECT_EQ(problem.world.objects.back().X_WO.translation.x(), -3);
  problem.goals = {test::pointGoal("goal", {-1, 1.2, 0.5})};
  problem.start = {-1, 1.2, 0};
  problem.execution.duration = 8;
  const ReplanResult result = expectSafe(problem);
  EXPECT_GE(result.steps, 1);
}

TEST(MovingObjects, WhatWasSeenGrowsWithItsAge) {
  const auto problem = [](double speed, double turning, double age) {
    Problem p = gate({.speed_bound = speed, .turn_bound = turning, .age = age});
    p.world.objects.back().X_WO = test::at(0, -1, 0);  // far from the gap
    return p;
  };
  EXPECT_EQ(replan(problem(0.05, 0.05, 0)).status, ReplanStatus::kReached);
  EXPECT_EQ(replan(problem(0.05, 0.05, 0.5)).status, ReplanStatus::kReached);
  EXPECT_EQ(replan(problem(0.05, 0.05, 80)).status, ReplanStatus::kExposed);
  EXPECT_EQ(replan(problem(kInfinity, 0, 0)).status, ReplanStatus::kExposed);
  EXPECT_EQ(replan(problem(0, kInfinity, 0)).status, ReplanStatus::kExposed);
}

TEST(MovingObjects, TheGrowthIsThatOfTheFarthestPoint) {
  Problem problem = gate({.speed_bound = 0.3, .turn_bound = 0.5, .age = 2});
  Obstacles obstacles(problem, std::make_shared<const CompiledScene>(problem));
  const double extent = std::sqrt(0.05 * 0.05 + 0.3 * 0.3 + 0.5 * 0.5);
  const auto growth = [&](double t0, double t1) { return obstacles.growthOf(0, t0, t1).most; };
  EXPECT_NEAR(growth(0, 0), 2 * (0.3 + 0.5 * extent), 1e-9);
  EXPECT_NEAR(growth(0, 1), 3 * (0.3 + 0.5 * extent), 1e-9);
  obstacles.set("gate", test::at(0.1, 0, 0), 1, {0.1, 0});
  EXPECT_NEAR(growth(1, 2), 0.1, 1e-9);
  EXPECT_NEAR(growth(0, 1), 0.3 + 0.5 * extent, 1e-9);  // backwards by the bound before
  obstacles.set("gate", test::at(0.1, 0, 0), 2, {0, 0});
  EXPECT_EQ(growth(2, 50), 0);
  EXPECT_EQ(obstacles.place(0, 2, 50, false).growth, 0);
}

/// The bar crosses the robot's place from 1 s to 2 s.
TEST(MovingObjects, WhatAStepBeforeHasProvenIsNotProvenAgain) {
  const Problem problem =
      gate(through({{0, posed(-1, -2, 0)}, {1, posed(-1, 0.5, 0)}, {2, posed(-1, 2.9, 0)}}));
  const auto scene = std::make_shared<const CompiledScene>(problem);
  Obstacles obstacles(problem, scene);
  obstacles.look(0);
  StepCertifier certifier(scene, obstacles, problem.execution);
  certifier.setWork(1'000'000'000);
  certifier.begin(0);
  const std::vector<TimedPoint> stands = {{0, problem.start}, {9, problem.start}};
  using Tick = StepCertifier::Tick;
  const auto provenUntil = [&](double until, double known, std::uint64_t& edges) {
    const Tick steps = std::llround(until / problem.execution.step);
    const std::vector<Tick> marks = {StepCertifier::kStepTicks, steps * StepCertifier::kStepTicks};
    StepCertifier::Bodies broken;
    const std::uint64_t before = certifier.statistics().edges;
    const double proven = certifier.certify(stands, marks, 1, broken, known);
    edges = certifier.statistics().edges - before;
    return proven;
  };
  std::uint64_t all = 0, rest = 0, none = 0;
  EXPECT_NEAR(provenUntil(0.8, -kInfinity, all), 0.8, 1e-9);
  EXPECT_NEAR(provenUntil(0.8, 0.4, rest), 0.8, 1e-9);
  EXPECT_NEAR(provenUntil(0.8, 0.8 + 1e-9, none), 0.8, 1e-9);
  EXPECT_LT(rest, all);
  EXPECT_EQ(none, 1u);  // against what stands still
  // It is proven beyond what is known, and no farther than where the bar comes.
  EXPECT_NEAR(provenUntil(4, 0.4, all), problem.execution.step, 1e-9);
  EXPECT_NEAR(provenUntil(4, 1.5, all), problem.execution.step, 1e-9);
  EXPECT_NEAR(provenUntil(4, 3, all), 4, 1e-9);
}

TEST(MovingObjects, JumpsAreWhatTheBoundDoesNotAllow) {
  Problem problem = gate({.speed_bound = 0.3, .turn_bound = 0.5});
  Obstacles obstacles(problem, std::make_shared<const CompiledScene>(problem));
  EXPECT_LE(obstacles.jump("gate", posed(0.3, 0, 0.5), 1), kGuardJump);
  EXPECT_LE(obstacles.jump("gate", posed(0, 0.3, -0.5), 1), kGuardJump);
  EXPECT_GT(obstacles.jump("gate", posed(0.3, 0, 0.6), 1), kGuardJump);
  EXPECT_GT(obstacles.jump("gate", posed(0.4, 0, 0.5), 1), kGuardJump);
  // Each for itself, also where points are not faster than both allow.
  EXPECT_GT(obstacles.jump("gate", posed(0.4, 0, 0), 1), kGuardJump);
  EXPECT_GT(obstacles.jump("gate", posed(0, 0, 0.6), 1), kGuardJump);
  robots::Pose bad;
  bad.rotation(0, 0) = -1;
  EXPECT_TRUE(std::isnan(obstacles.jump("gate", bad, 1)));
  bad = {};
  bad.translation.z() = kNaN;
  EXPECT_TRUE(std::isnan(obstacles.jump("gate", bad, 1)));
  EXPECT_THROW(obstacles.set("gate", bad, 1, {0, 0}), std::invalid_argument);
  EXPECT_THROW(obstacles.set("gate", test::at(0, 0, 0), 1, {0, -1}), std::invalid_argument);
  EXPECT_THROW(obstacles.set("gate", test::at(0, 0, 0), 1, {kNaN, 0}), std::invalid_argument);
  EXPECT_THROW(obstacles.set("upper wall", test::at(0, 0, 0), 1, {0, 0}), std::invalid_argument);
  const std::vector<Eigen::Vector3d> vertices(3);
  EXPECT_THROW(obstacles.set("gate", std::span(vertices), 1, {0, 0}), std::invalid_argument);
}

/// The slow twin: random bars, a look at each millisecond. Of four, one is known by keys, one by
/// its velocity, one by a bound alone, and one is observed by the program.
TEST(MovingObjects, RandomBarsNeverTouchWhatIsCertified) {
  int steps = 0, disturbed = 0, reached = 0, unsafe = 0, exposed = 0;
  constexpr double kEnd = 1e3;  // [s]
  for (int seed = 0; seed < 24; ++seed) {
    Random random(78, static_cast<std::uint64_t>(seed));
    const auto randomKeys = [&] {
      std::vector<PoseMotion::Key> keys;
      double angle = random.uniform(-3, 3);
      for (int key = 0; key < 5; ++key) {
        keys.push_back(
            {1.2 * key, posed(random.uniform(-0.9, 1.2), random.uniform(-1.2, 1.2), angle)});
        angle += random.uniform(-2.5, 2.5);
      }
      return keys;
    };
    Problem problem = test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0});
    problem.margins.common = 0.01;
    problem.limits.iterations = 300;
    problem.execution.step = 0.1;
    problem.execution.duration = 8;
    problem.seed = static_cast<std::uint64_t>(seed);
    if (seed % 3 == 2) problem.execution.foresight = Foresight::kSpeedBound;
    problem.world.objects.push_back(bar("keys", through(randomKeys())));
    problem.world.objects.push_back(
        bar("steady", {.poses = PoseMotion::steady(
                           {0, posed(random.uniform(-0.9, 1.2), random.uniform(-1.2, 1.2), 0)},
                           {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0},
                           {0, 0, random.uniform(-1, 1)})}));
    // The robot does not know the motion of the observed one.
    const std::shared_ptr<const PoseMotion> unknown = PoseMotion::keys(randomKeys());
    Problem truth = problem;
    truth.world.objects.push_back(bar("seen", {.poses = unknown}));
    problem.world.objects.push_back(bar("seen", {.speed_bound = 0, .turn_bound = 0}));
    problem.world.objects.back().X_WO = unknown->pose(0);
    Replanner replanner(problem);
    std::vector<TimedPoint> sure;
    bool is_disturbed = false;
    while (replanner.time() < problem.execution.duration - 1e-9 && !replanner.reached()) {
      // The tightest bounds that are true from then on: its origin's and its turning's.
      const double now = replanner.time();
      const double speed = unknown->speedBound(now, kEnd, 0);
      const double turning = unknown->speedBound(now, kEnd, 1e6) * 1e-6 + 1e-9;
      replanner.setPose("seen", unknown->pose(now), now, speed, turning);
      const ReplanStep step = replanner.step();
      EXPECT_EQ(step.certified, !step.exposed) << "seed " << seed << ": " << step.why;
      exposed += step.exposed ? 1 : 0;
      if (!step.certified) break;
      sure.insert(sure.end(), step.motion.begin() + (sure.empty() ? 0 : 1), step.motion.end());
      const double kept = test::denseClearance(truth, step.motion, 0.001, 1.0);
      unsafe += kept > problem.margins.common ? 0 : 1;
      EXPECT_GE(kept, std::min(1.0, step.clearance.lower) - 1e-9) << "seed " << seed;
      is_disturbed = is_disturbed || step.decision == Decision::kWait ||
                     step.decision == Decision::kEvade || replanner.replans() > 0;
      ++steps;
    }
    disturbed += is_disturbed ? 1 : 0;
    reached += replanner.reached() ? 1 : 0;
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GE(exposed, 1);
  EXPECT_GE(disturbed, 8);
  EXPECT_GE(reached, 6);
  EXPECT_GT(steps, 200);
}

/// A scene whose object was moved answers as one that was compiled with the object there.
TEST(MovingObjects, APlaceInASceneIsThatOfACompiledOne) {
  Random random(79, 0);
  Problem problem = test::wallProblem();
  Object two = test::box("two", {0.05, 0.2, 0.1}, 0, 0, 0);
  two.geometries.push_back({collision::Shape::sphere(0.1), test::at(0.3, 0.1, 0), "two"});
  problem.world.objects.push_back(movingObject(two, {.speed_bound = 1, .turn_bound = 1}));
  problem.world.objects.push_back(bar("bar", {.speed_bound = 1, .turn_bound = 1}));
  problem.margins.pairs.push_back({"disc", "two", 0.05});
  problem.contacts.allowed.emplace_back("disc", "lower wall");
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const int first = scene->scene().find("two"), second = scene->scene().find("bar");
  EXPECT_EQ(scene->differenceFrom(problem), "");
  int free = 0, contacts = 0;
  for (int i = 0; i < 60; ++i) {
    Problem there = problem;
    std::vector<CompiledScene::Replacement> places;
    for (std::size_t k = 2; k < 4; ++k) {
      const robots::Pose X =
          posed(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-3, 3));
      there.world.objects[k].X_WO = X;
      there.world.objects[k].motion = nullptr;
      places.push_back({k == 2 ? first : second, 0, X});
    }
    const auto moved = scene->withShapes(places);
    EXPECT_TRUE(moved->hasPairsOf(*scene));
    EXPECT_EQ(moved->differenceFrom(problem), "");  // shapes and places are not compared
    EdgeCertifier asked(moved), expected(std::make_shared<const CompiledScene>(there));
    EdgeCertifier rebound(scene);
    rebound.rebind(moved);
    for (int e = 0; e < 20; ++e) {
      const std::vector<double> a = {random.uniform(-2, 2), random.uniform(-2, 2), 0},
                                b = {random.uniform(-2, 2), random.uniform(-2, 2), 0};
      const Verdict verdict = expected.certify(a, b).verdict;
      EXPECT_EQ(asked.certify(a, b).verdict, verdict);
      EXPECT_EQ(rebound.certify(a, b).verdict, verdict);
      EXPECT_NEAR(asked.clearance(a, 1e-6).clearance.lower,
                  expected.clearance(a, 1e-6).clearance.lower, 2e-6);
      (verdict == Verdict::kFree ? free : contacts) += 1;
    }
  }
  EXPECT_GT(free, 100);
  EXPECT_GT(contacts, 100);
}

TEST(MovingObjects, ScenesRefuseOtherPlaces) {
  const Problem problem = gate(through({{0, posed(0, 1.2, 0)}, {2, posed(0, 2.2, 0)}}));
  const CompiledScene scene(problem);
  const int wall = scene.scene().find("upper wall"), gate_body = scene.scene().find("gate");
  const auto with = [&](const CompiledScene::Replacement& r) { (void)scene.withShapes({&r, 1}); };
  EXPECT_NO_THROW(with({gate_body, 0, test::at(1, 0, 0)}));
  EXPECT_THROW(with({wall, 0, test::at(1, 0, 0)}), std::invalid_argument);
  EXPECT_THROW(with({0, 0, test::at(1, 0, 0)}), std::invalid_argument);
  EXPECT_THROW(with({gate_body, 1, test::at(1, 0, 0)}), std::invalid_argument);
  EXPECT_THROW(with({gate_body, 0, collision::Shape::sphere(1)}), std::invalid_argument);
  EXPECT_THROW(with({gate_body, 0, test::at(kNaN, 0, 0)}), std::invalid_argument);
  EXPECT_THROW((void)scene.withObjectAt("gate", test::at(1, 0, 0)), std::invalid_argument);
  EXPECT_NE(scene.withObjectAt("upper wall", test::at(1, 0, 0)), nullptr);
  const Object other = bar("other", {.speed_bound = 0, .turn_bound = 0});
  EXPECT_THROW((void)scene.withObjects({&other, 1}), robots::InputError);
  // A removed one is an obstacle of no kind.
  const auto without = scene.withObjects({}, {&gate_body, 1});
  EXPECT_THROW((void)without->withShapes(
                   std::vector<CompiledScene::Replacement>{{gate_body, 0, test::at(1, 0, 0)}}),
               std::invalid_argument);
}

TEST(MovingObjects, AProblemThatDiffersIsRefused) {
  const Problem problem = gate(through({{0, posed(0, 1.2, 0)}, {2, posed(0, 2.2, 0)}}));
  const CompiledScene scene(problem);
  Problem other = problem;
  other.world.objects.back().motion = nullptr;
  EXPECT_NE(scene.differenceFrom(other).find("moves there"), std::string::npos);
  other = problem;
  other.execution.start = 1;
  EXPECT_NE(scene.differenceFrom(other), "");
  other.world.objects.back() =
      movingObject(other.world.objects.back(), *other.world.objects.back().motion, 1);
  EXPECT_NO_THROW(validate(other));
  EXPECT_NE(scene.differenceFrom(other), "");
  other = problem;
  other.world.objects.pop_back();
  EXPECT_NE(scene.differenceFrom(other), "");
}

/// Plans and proofs hold for the start of the execution.
TEST(MovingObjects, PlansSeeTheStart) {
  Problem closed = gate(through({{0, posed(0, 1.2, 0)}, {2, posed(0, 2.2, 0)}}));
  closed.limits.iterations = 300;
  EXPECT_NE(plan(closed).status, PlanStatus::kSolved);
  Problem open = closed;
  open.execution.start = 2;
  open.world.objects.back() =
      movingObject(open.world.objects.back(), *open.world.objects.back().motion, 2);
  const PlanResult result = plan(open);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(verify(open, result.path).status, VerifyStatus::kCertified);
  EXPECT_NE(verify(closed, result.path).status, VerifyStatus::kCertified);
  // The path's file says of which moment it speaks.
  const Folder folder;
  writePath(folder.path("path.json"), open, result);
  EXPECT_NE(readText(folder.path("path.json")).find("\"obstacles_at\": 2"), std::string::npos);
}

TEST(MovingObjects, MistakesAreRefused) {
  const Problem good = gate(through({{0, posed(0, 1.2, 0)}, {2, posed(0, 2.2, 0)}}));
  const auto expect = [&](const auto& change, const char* part) {
    Problem problem = good;
    change(problem, problem.world.objects.back());
    robots::expectInputError([&] { validate(problem); }, "test", 0, {part});
  };
  const auto with = [](Object& object, const auto& change) {
    ObjectMotion motion = *object.motion;
    change(motion);
    object.motion = std::make_shared<const ObjectMotion>(motion);
  };
  EXPECT_NO_THROW(validate(good));
  expect([](Problem&, Object& o) { o.X_WO = test::at(0, 0, 0); }, "does not stand where");
  expect([](Problem& p, Object&) { p.execution.start = 1; }, "does not stand where");
  expect([](Problem&, Object& o) { o.geometries.clear(); }, "has no shape");
  expect([](Problem&, Object& o) { o.geometries[0].shape = collision::Shape::halfSpace(); },
         "half-space");
  expect([&](Problem&, Object& o) { with(o, [](ObjectMotion& m) { m.speed_bound = -1; }); },
         "speed bound -1");
  expect([&](Problem&, Object& o) { with(o, [](ObjectMotion& m) { m.turn_bound = kNaN; }); },
         "turning bound nan");
  expect([&](Problem&, Object& o) { with(o, [](ObjectMotion& m) { m.age = 1; }); }, "has an age");
  expect(
      [&](Problem&, Object& o) {
        with(o, [](ObjectMotion& m) {
          m.poses = nullptr;
          m.age = -1;
        });
      },
      "age");
  expect(
      [](Problem& p, Object& o) {
        p.robot.attachments.push_back({o, 0, {}, {}});
        p.world.objects.pop_back();
      },
      "is held and has a motion");
  EXPECT_THROW((void)attachObject(good, "gate", "disc"), std::invalid_argument);
  EXPECT_THROW((void)movingObject({"nothing", {}, {}}, {}), std::invalid_argument);
  // A bound that the motion exceeds would prove what does not hold.
  Problem bounded = good;
  with(bounded.world.objects.back(), [](ObjectMotion& m) { m.speed_bound = m.turn_bound = 0.1; });
  robots::expectInputError([&] { Replanner{bounded}; }, "test", 0, {"may reach 0.5"});
  robots::expectInputError([&] { Guard{bounded}; }, "test", 0, {"may reach 0.5"});
  // So would one that the motion exceeds later than an execution lasts: a Guard follows it then.
  bounded.execution.duration = 1;
  with(bounded.world.objects.back(), [](ObjectMotion& m) {
    m.poses = collision::PoseMotion::keys(
        {{0, test::at(1, 0, 0)}, {40, test::at(1, 0, 0)}, {41, test::at(0, 0, 0)}});
    m.speed_bound = m.turn_bound = 0.1;
  });
  bounded.world.objects.back().X_WO = test::at(1, 0, 0);
  robots::expectInputError([&] { validate(bounded); }, "test", 0, {"may reach 1"});
}

}  // namespace
}  // namespace leeway::planner
