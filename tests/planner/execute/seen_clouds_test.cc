// Clouds that are seen again and again: executed among, written to logs, and proven from these.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/replanner.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/random.h"
#include "planner/execute/cloud_scene.h"
#include "planner/execute/log_line.h"
#include "planner/execute/obstacles.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr double kDisc = 0.1;  ///< the radius of test::disc() [m]
constexpr double kBall = 0.02;

PointCloud ballsAt(const Points& points, double radius = kBall) {
  PointCloud cloud;
  for (const Eigen::Vector3d& p : points) cloud.balls.push_back({p, radius});
  return cloud;
}

std::shared_ptr<const PointCloud> shared(PointCloud cloud) {
  return std::make_shared<const PointCloud>(std::move(cloud));
}

Object cloudObject(const Points& points, const ObjectMotion& motion) {
  Object object{"seen", {}, {}};
  object.cloud = shared(ballsAt(points));
  return movingObject(object, motion);
}

/// Points on a line at x, every 2 cm.
Points fence(double x, double from, double to) {
  Points points;
  for (double y = from; y <= to; y += 0.02) points.emplace_back(x, y, 0);
  return points;
}

/// The disc, left of a gap in a wall that a fence closes.
Problem fenceGate(const ObjectMotion& motion = {.speed_bound = 0, .turn_bound = 0}) {
  Problem problem = test::wallProblem();
  problem.name = "fence";
  problem.start = {-1, 1.2, 0};
  problem.goals = {test::pointGoal("goal", {1, 1.2, 0})};
  problem.margins.common = 0.01;
  problem.limits.iterations = 1000;
  problem.execution.duration = 12;
  problem.world.objects.push_back(cloudObject(fence(0, 0.9, 1.5), motion));
  return problem;
}

/// The least distance of the disc from the points over a motion, looked at each millisecond.
template <class PointsAt>
double denseRoom(const std::vector<TimedPoint>& motion, const PointsAt& pointsAt) {
  double least = kInfinity;
  for (std::size_t i = 1; i < motion.size(); ++i) {
    const TimedPoint &a = motion[i - 1], &b = motion[i];
    const int parts = std::max(1, static_cast<int>(std::ceil((b.time - a.time) / 0.001)));
    for (int k = 0; k <= parts; ++k) {
      const double t = static_cast<double>(k) / parts;
      const double x = a.position[0] + t * (b.position[0] - a.position[0]);
      const double y = a.position[1] + t * (b.position[1] - a.position[1]);
      for (const Eigen::Vector3d& p : pointsAt(a.time + t * (b.time - a.time)))
        least = std::min(least, std::hypot(p.x() - x, p.y() - y) - kDisc - kBall);
    }
  }
  return least;
}

std::vector<std::string> run(const Problem& problem, Replanner& replanner, int most,
                             const std::function<void(Replanner&)>& observe) {
  std::vector<std::string> lines;
  for (int k = 0; k < most && !replanner.reached(); ++k) {
    observe(replanner);
    const ReplanStep step = replanner.step();
    lines.push_back(logLine(problem, step));
    if (!step.certified) break;
  }
  lines.push_back(logLine(problem, replanner.executed()));
  return lines;
}

class SeenClouds : public ::testing::Test {
 protected:
  VerifyResult verified(const Problem& problem, const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return verifyLog(problem, folder_.write("run.jsonl", text));
  }
  std::string file() const { return folder_.path("run.jsonl"); }
  Folder folder_;
};

TEST_F(SeenClouds, WhatWasSeenOnceIsInTheWayAndGrows) {
  EXPECT_NE(replan(fenceGate()).status, ReplanStatus::kReached);
  Problem open = fenceGate({.speed_bound = 0.05, .turn_bound = 0});
  open.world.objects.back() =
      cloudObject(fence(1.5, -1.5, -1), {.speed_bound = 0.05, .turn_bound = 0});
  const ReplanResult result = replan(open);
  EXPECT_EQ(result.status, ReplanStatus::kReached);
  open.world.objects.back() =
      cloudObject(fence(1.5, -1.5, -1), {.speed_bound = 0.05, .turn_bound = 0, .age = 80});
  EXPECT_EQ(replan(open).status, ReplanStatus::kExposed);
}

TEST_F(SeenClouds, ACloudThatIsGoneLetsTheRobotPass) {
  const Problem problem = fenceGate();
  Replanner replanner(problem);
  int step = 0;
  const auto lines = run(problem, replanner, 200, [&](Replanner& r) {
    const bool is_open = ++step > 10;
    r.setCloud("seen", shared(ballsAt(fence(is_open ? 1.8 : 0, 0.9, 1.5))), r.time(), 0.05);
  });
  EXPECT_TRUE(replanner.reached());
  EXPECT_GT(replanner.executed().waits, 5);
  const VerifyResult result = verified(problem, lines);
  EXPECT_EQ(result.status, VerifyStatus::kCertified) << result.reason;
  EXPECT_GT(result.clearance_lower, problem.margins.common);
  // The scene of the last look has the cloud that was seen last.
  const auto scene = replanner.scene();
  const collision::Body& body =
      scene->scene().bodies()[static_cast<std::size_t>(scene->scene().find("seen"))];
  EXPECT_EQ((*body.balls)[0].center.x(), 1.8);
}

/// The slow twin: points that move at up to 0.3 m/s, each by itself, seen in frames that change,
/// 50 ms late, more of them with time. What is certified keeps its margin at each millisecond.
TEST_F(SeenClouds, WhatIsCertifiedKeepsItsDistanceFromPointsThatMove) {
  int steps = 0, disturbed = 0, unsafe = 0, proven = 0;
  for (int seed = 0; seed < 16; ++seed) {
    Random random(91, static_cast<std::uint64_t>(seed));
    Points from, velocity;
    const auto addPoint = [&](double least_x, double time) {
      const Eigen::Vector3d p(random.uniform(least_x, 1.3), random.uniform(-1.8, 1.8),
                              random.uniform(-0.04, 0.04));
      const double angle = random.uniform(-3, 3), speed = random.uniform(0, 0.3);
      velocity.emplace_back(speed * std::cos(angle), speed * std::sin(angle), 0);
      from.push_back(p - time * velocity.back());
    };
    for (int i = 0; i < 12; ++i) addPoint(-0.9, 0);
    const auto pointsAt = [&](double time) {
      Points points = from;
      for (std::size_t i = 0; i < points.size(); ++i) points[i] += time * velocity[i];
      return points;
    };
    Problem problem = test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0});
    problem.margins.common = 0.01;
    problem.limits.iterations = 300;
    problem.execution.step = 0.1;
    problem.execution.duration = 5;
    problem.seed = static_cast<std::uint64_t>(seed);
    problem.world.objects.push_back(
        cloudObject(pointsAt(0), {.speed_bound = 0.3, .turn_bound = 0}));
    Replanner replanner(problem);
    std::vector<std::string> lines;
    bool is_disturbed = false;
    while (replanner.time() < problem.execution.duration - 1e-9 && !replanner.reached()) {
      const double seen = std::max(0.0, replanner.time() - 0.05);
      const robots::Pose X_WO{
          Eigen::AngleAxisd(random.uniform(-3, 3), Eigen::Vector3d::UnitX()).toRotationMatrix(),
          {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}};
      Points points_O;
      for (const Eigen::Vector3d& p : pointsAt(seen))
        points_O.push_back(X_WO.rotation.transpose() * (p - X_WO.translation));
      std::reverse(points_O.begin(), points_O.end());  // balls do not correspond
      replanner.setCloud("seen", shared(ballsAt(points_O)), seen, 0.3, X_WO);
      const ReplanStep step = replanner.step();
      lines.push_back(logLine(problem, step));
      if (!step.certified) break;
      const double kept = denseRoom(step.motion, pointsAt);
      unsafe += kept > problem.margins.common ? 0 : 1;
      EXPECT_GE(kept, step.clearance.lower - 1e-9) << "seed " << seed;
      is_disturbed = is_disturbed || step.decision != Decision::kFollow;
      ++steps;
      // Another point appears, far from the robot.
      if (seed % 2 == 0 && replanner.state()[0] < 0.3) addPoint(1, replanner.time());
    }
    disturbed += is_disturbed ? 1 : 0;
    lines.push_back(logLine(problem, replanner.executed()));
    const bool was_certified = replanner.executed().certified;
    const VerifyResult result = verified(problem, lines);
    if (was_certified) {
      EXPECT_EQ(result.status, VerifyStatus::kCertified)
          << "seed " << seed << ", line " << result.line << ": " << result.reason;
      ++proven;
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(steps, 150);
  EXPECT_GE(disturbed, 8);
  EXPECT_GE(proven, 3);
}

/// A cloud that grows in its scene is one of greater balls.
TEST_F(SeenClouds, GrowthIsThatOfEveryBall) {
  Random random(92, 0);
  int free = 0, contacts = 0;
  for (int i = 0; i < 10; ++i) {
    Points points;
    for (int k = 0; k < 10 + 10 * i; ++k)
      points.emplace_back(random.uniform(-2, 2), random.uniform(-2, 2), 0);
    Problem problem = test::wallProblem();
    problem.margins.common = 0.01;
    problem.margins.pairs.push_back({"disc", "seen", 0.03});
    problem.world.objects.push_back(cloudObject(points, {.speed_bound = 0.1, .turn_bound = 0}));
    Obstacles obstacles(problem, std::make_shared<const CompiledScene>(problem));
    ASSERT_EQ(obstacles.groups(), 2u);
    if (i % 2 == 1) {  // the same after another cloud
      obstacles.set("seen", Obstacles::CloudSight{shared(ballsAt({{0, 0, 0}}))}, 0, {1});
      obstacles.set("seen", Obstacles::CloudSight{shared(ballsAt(points))}, 0, {0.1});
    }
    const Obstacles::Placement placed = obstacles.place(1, 0.2, 0.6, true);
    EXPECT_NEAR(placed.growth, 0.06, 1e-9);
    EXPECT_TRUE(placed.grown->hasPairsOf(*obstacles.sceneOf(1)));
    EdgeCertifier grown(placed.grown), middle(placed.middle);
    for (int e = 0; e < 25; ++e) {
      const std::vector<double> a = {random.uniform(-2, 2), random.uniform(-2, 2), 0},
                                b = {random.uniform(-2, 2), random.uniform(-2, 2), 0};
      const std::vector<TimedPoint> edge = {{0, a}, {1, b}};
      const double room = denseRoom(edge, [&](double) { return points; }) - 0.03;
      const Verdict verdict = grown.certify(a, b).verdict;
      const Verdict at_middle = middle.certify(a, b).verdict;
      const auto expect = [&](Verdict found, double growth) {
        if (room > growth + 2e-3) {
          EXPECT_EQ(found, Verdict::kFree) << room;
        }
        if (room < growth - 2e-3) {
          EXPECT_NE(found, Verdict::kFree) << room;
        }
      };
      expect(verdict, 0.06);
      expect(at_middle, 0.04);
      (verdict == Verdict::kFree ? free : contacts) += 1;
    }
  }
  EXPECT_GT(free, 20);
  EXPECT_GT(contacts, 50);
}

TEST_F(SeenClouds, ACloudIsOnlyCheckedAgainstTheRobot) {
  Problem problem = fenceGate();
  problem.world.objects.push_back(test::box("bar", {0.05, 0.3, 0.5}, 1, 0, 0));
  problem.contacts.allowed.emplace_back("disc", "bar");
  Obstacles obstacles(problem, std::make_shared<const CompiledScene>(problem));
  const std::size_t balls = problem.world.objects[2].cloud->size();
  EXPECT_EQ(obstacles.sceneOf(1)->scene().pairs().size(), balls);
  EXPECT_EQ(obstacles.sceneOf(0)->scene().pairs().size(), 0u);
  EXPECT_EQ(obstacles.still()->scene().pairs().size(), 2u);  // of the wall's two parts
  problem.contacts.allowed.emplace_back("seen", "disc");
  Obstacles allowed(problem, std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(allowed.sceneOf(1)->scene().pairs().size(), 0u);
  EXPECT_EQ(allowed.world()->scene().pairs().size(), 2u);
}

TEST_F(SeenClouds, KnownPosesCarryACloud) {
  const auto sideways = collision::PoseMotion::keys(
      {{0, test::at(0, 0, 0)}, {0.5, test::at(0, 0, 0)}, {1.5, test::at(0, 1, 0)}});
  for (const Foresight foresight : {Foresight::kMotion, Foresight::kSpeedBound}) {
    Problem problem = fenceGate({.poses = sideways});
    problem.execution.foresight = foresight;
    std::vector<std::string> lines;
    const ReplanResult result = replan(
        problem, {}, [&](const ReplanStep& step) { lines.push_back(logLine(problem, step)); });
    lines.push_back(logLine(problem, result));
    EXPECT_EQ(result.status, ReplanStatus::kReached);
    EXPECT_TRUE(result.certified);
    const Points rest = fence(0, 0.9, 1.5);
    EXPECT_GT(denseRoom(result.trajectory,
                        [&](double time) {
                          Points points = rest;
                          for (Eigen::Vector3d& p : points) p = sideways->pose(time) * p;
                          return points;
                        }),
              problem.margins.common);
    const VerifyResult proof = verified(problem, lines);
    EXPECT_EQ(proof.status, VerifyStatus::kCertified) << proof.reason;
  }
}

TEST_F(SeenClouds, PosesMoveACloudAndTheNextCloudKeepsThem) {
  const Problem problem = fenceGate();
  Replanner replanner(problem);
  replanner.setPose("seen", test::at(0, 1.5, 0), 0, 0.01, 0);
  ReplanStep step = replanner.step();
  ASSERT_TRUE(step.certified);
  const Points across = fence(0, -0.3, 0.3);
  replanner.setCloud("seen", shared(ballsAt(across)), 0, 0.01);
  step = replanner.step();
  const auto& seen = std::get<SeenCloud>(step.observed.at(0).seen);
  EXPECT_EQ(seen.X_WO.translation, Eigen::Vector3d(0, 1.5, 0));
  EXPECT_EQ(seen.cloud->size(), across.size());
  EXPECT_EQ(step.obstacles.at(0).strategy, "cloud");
}

TEST_F(SeenClouds, NumbersInALogReadBackToTheBit) {
  const Problem problem = fenceGate();
  Replanner replanner(problem);
  PointCloud cloud;
  Random random(93, 0);
  for (int k = 0; k < 50; ++k)
    cloud.balls.push_back(
        {{random.uniform(2, 3), random.uniform(-1, 1) / 3, 1e-300 * k}, random.uniform(1e-9, 0.1)});
  replanner.setCloud("seen", shared(cloud), 0, 0.1);
  const auto line = nlohmann::json::parse(logLine(problem, replanner.step()));
  const auto& sight = line.at("observed").at(0);
  EXPECT_EQ(sight.at("object"), "seen");
  EXPECT_FALSE(sight.contains("turn_bound"));
  ASSERT_EQ(sight.at("balls").size(), cloud.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const auto& ball = sight.at("balls").at(k);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(ball.at(i).get<double>(), cloud.balls[k].center[static_cast<Eigen::Index>(i)]);
    EXPECT_EQ(ball.at(3).get<double>(), cloud.balls[k].radius);
  }
}

/// A line with a document that was changed, and the sum of the changed text.
std::string changedLine(const std::string& line,
                        const std::function<void(nlohmann::ordered_json&)>& change) {
  auto document = nlohmann::ordered_json::parse(line);
  change(document);
  document.erase("sum");
  std::string text = document.dump();
  text.pop_back();
  return fmt::format("{}{}{:016x}{}", text, kBeforeSum, lineSum(text), kAfterSum);
}

TEST_F(SeenClouds, LogsWithOtherCloudsAreRefutedOrRefused) {
  const Problem problem = fenceGate();
  Replanner replanner(problem);
  const auto lines = run(problem, replanner, 200, [&](Replanner& r) {
    r.setCloud("seen", shared(ballsAt(fence(1.8, 0.9, 1.5))), r.time(), 0.05);
  });
  ASSERT_TRUE(replanner.reached());
  ASSERT_EQ(verified(problem, lines).status, VerifyStatus::kCertified);
  using Json = nlohmann::ordered_json;
  const auto with = [&](const std::function<void(Json&)>& change) {
    std::vector<std::string> changed = lines;
    changed[4] = changedLine(lines[4], [&](Json& line) { change(line["observed"][0]); });
    return changed;
  };
  // A ball in the way: where the robot is during step 4.
  const auto position = Json::parse(lines[4]).at("position");
  VerifyResult result = verified(problem, with([&](Json& seen) {
                                   seen["balls"].push_back({position[0], position[1], 0, 0.02});
                                 }));
  EXPECT_EQ(result.status, VerifyStatus::kRefuted);
  EXPECT_EQ(result.line, 5);
  EXPECT_EQ(result.b, "seen");
  // A cloud that is older than the last one hides what that one shows.
  result = verified(problem, with([](Json& seen) { seen["time"] = 0.0; }));
  EXPECT_EQ(result.status, VerifyStatus::kRefuted);
  EXPECT_NE(result.reason.find("before the one of"), std::string::npos) << result.reason;
  // No bound: nothing is proven.
  result = verified(problem, with([](Json& seen) { seen["speed_bound"] = nullptr; }));
  EXPECT_EQ(result.status, VerifyStatus::kUndecided) << result.reason;
  // No ball at all, as where all were carved out: nothing is in the way.
  result = verified(problem, with([](Json& seen) { seen["balls"] = Json::array(); }));
  EXPECT_EQ(result.status, VerifyStatus::kCertified) << result.reason;
  const auto expectRefused = [&](const std::function<void(Json&)>& change,
                                 const std::string& what) {
    const auto changed = with(change);
    robots::expectInputError([&] { verified(problem, changed); }, file(), 5, {what});
  };
  expectRefused([](Json& seen) { seen["balls"][3].erase(3); }, "has 3 numbers");
  expectRefused([](Json& seen) { seen["balls"][3][3] = -1; }, "ball 3 has the radius -1");
  expectRefused([](Json& seen) { seen["balls"][3][1] = 1e12; }, "ball 3 has the coordinate");
  expectRefused([](Json& seen) { seen["balls"][3] = "no"; }, "balls");
  expectRefused([](Json& seen) { seen["object"] = "upper wall"; }, "no cloud with a motion");
  expectRefused([](Json& seen) { seen.erase("rotation"); }, "rotation");
}

TEST_F(SeenClouds, SightsThatMakeNoSenseChangeNothing) {
  Problem problem = fenceGate();
  problem.world.objects.push_back(movingObject(test::box("bar", {0.05, 0.3, 0.5}, 1.8, 0, 0),
                                               {.speed_bound = 0, .turn_bound = 0}));
  Replanner replanner(problem);
  const auto cloud = shared(ballsAt(fence(1.8, 0.9, 1.5)));
  const auto expectThrow = [&](const std::string& words, const auto& call) {
    try {
      call();
      ADD_FAILURE() << words;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  expectThrow("no cloud with a motion 'bar'; that object is rigid",
              [&] { replanner.setCloud("bar", cloud, 0, 0); });
  expectThrow("no cloud with a motion 'upper wall'; known: seen",
              [&] { replanner.setCloud("upper wall", cloud, 0, 0); });
  expectThrow("no cloud with a motion 'sen'; did you mean 'seen'?",
              [&] { replanner.setCloud("sen", cloud, 0, 0); });
  expectThrow("no object with a motion 'bare'; did you mean 'bar'?",
              [&] { replanner.setPose("bare", {}, 0, 0, 0); });
  expectThrow("no deforming obstacle 'seen'; that object is a cloud",
              [&] { replanner.setVertices("seen", Points(3), 0, 0); });
  expectThrow("later than the present", [&] { replanner.setCloud("seen", cloud, 1, 0); });
  expectThrow("at least 0 m/s", [&] { replanner.setCloud("seen", cloud, 0, -1); });
  expectThrow("at least 0 m/s", [&] { replanner.setCloud("seen", cloud, 0, kNaN); });
  expectThrow("is missing", [&] { replanner.setCloud("seen", nullptr, 0, 0); });
  expectThrow("no ball is left", [&] { replanner.setCloud("seen", shared({}), 0, 0); });
  expectThrow("ball 1 has the coordinate nan", [&] {
    replanner.setCloud("seen", shared(ballsAt({{0, 0, 0}, {0, kNaN, 0}})), 0, 0);
  });
  expectThrow("ball 0 has the radius 0", [&] {
    replanner.setCloud("seen", shared(ballsAt({{0, 0, 0}}, 0)), 0, 0);
  });
  robots::Pose bad;
  bad.rotation(0, 0) = 2;
  expectThrow("its pose", [&] { replanner.setCloud("seen", cloud, 0, 0, bad); });
  PointCloud cropped = *cloud;
  cropped.crops.push_back({0.5, {}, reachOf(problem)});
  expectThrow("was cropped", [&] { replanner.setCloud("seen", shared(cropped), 0, 0); });
  expectThrow("before the one of 0 s", [&] { replanner.setCloud("seen", cloud, -1, 0); });
  // The fence is still there.
  EXPECT_TRUE(replanner.step().observed.empty());
  EXPECT_TRUE(replanner.path().empty());
  // All of it was carved out: nothing is left, and that is accepted.
  PointCloud carved_out;
  carved_out.filters.push_back({"carve", "balls that touch disc", 12});
  replanner.setCloud("seen", shared(carved_out), replanner.time(), 1);
  while (!replanner.reached() && replanner.time() < 10) ASSERT_TRUE(replanner.step().certified);
  EXPECT_TRUE(replanner.reached());
}

/// The fence without the balls at its middle, which were carved out where it stands.
PointCloud carvedFence(const robots::Pose& X_WC) {
  const robots::Geometry post{collision::Shape::sphere(0.05), X_WC * test::at(0, 1.2, 0), {}};
  return carved(ballsAt(fence(0, 0.9, 1.5)), X_WC, {&post, 1}, 0, "post");
}

/// What was carved out covers its hole at one place only.
TEST_F(SeenClouds, ACarvedCloudStaysWhereItWasCarved) {
  const robots::Pose there = test::at(0.1, 0, 0);
  const auto cut = shared(carvedFence(there));
  ASSERT_LT(cut->size(), fence(0, 0.9, 1.5).size());
  const Problem problem = fenceGate();
  Replanner replanner(problem);
  EXPECT_THROW(replanner.setCloud("seen", cut, 0, 0), std::invalid_argument);
  EXPECT_THROW(replanner.setCloud("seen", cut, 0, 0, test::at(0.2, 0, 0)), std::invalid_argument);
  replanner.setCloud("seen", cut, 0, 0, there);
  replanner.setPose("seen", there, 0, 0, 0);
  try {
    replanner.setPose("seen", test::at(0.1, 0.3, 0), 0, 0, 0);
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("at which it was carved"), std::string::npos);
  }
  EXPECT_TRUE(replanner.step().certified);  // of the cloud that was seen, where it was seen
  const auto scene = replanner.scene();
  const auto body = static_cast<std::size_t>(scene->scene().find("seen"));
  EXPECT_EQ(scene->scene().bodies()[body].X_WB.translation, there.translation);
  // So do problems.
  Problem moved = problem;
  moved.world.objects.back().cloud = cut;
  robots::expectInputError([&] { validate(moved); }, "fence", 0, {"at which it was carved"});
  moved.world.objects.back().X_WO = there;
  EXPECT_NO_THROW(validate(moved));
  // A log in which the problem's carved cloud is seen elsewhere, from a program that did not know.
  Replanner elsewhere(problem);
  elsewhere.setPose("seen", test::at(0, 0.5, 0), 0, 0, 0);
  const std::vector<std::string> lines = {logLine(problem, elsewhere.step()),
                                          logLine(problem, elsewhere.executed())};
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kCertified);
  moved.world.objects.back() = problem.world.objects.back();
  moved.world.objects.back().cloud = shared(carvedFence({}));
  const VerifyResult refuted = verified(moved, lines);
  EXPECT_EQ(refuted.status, VerifyStatus::kRefuted);
  EXPECT_NE(refuted.reason.find("at which it was carved"), std::string::npos) << refuted.reason;
}

TEST_F(SeenClouds, ACloudThatIsWhollyCarvedOutTakesLaterScans) {
  Problem problem = fenceGate();
  const robots::Geometry all{collision::Shape::sphere(9), {}, {}};
  const PointCloud none = carved(*problem.world.objects.back().cloud, {}, {&all, 1}, 0, "all");
  ASSERT_EQ(none.size(), 0u);
  Object seen{"seen", {}, {}};
  seen.cloud = shared(none);
  problem.world.objects.back() = movingObject(seen, {.speed_bound = 0.01});
  EXPECT_EQ(problem.world.objects.back().motion->turn_bound, 0);  // of a cloud: its points' speed
  Replanner replanner(problem);
  std::vector<std::string> lines = run(problem, replanner, 5, [](Replanner&) {});
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kCertified);
  lines.pop_back();
  // A ball in front of the robot: the log is proven against it, too.
  const double x = replanner.state()[0], y = replanner.state()[1];
  replanner.setCloud("seen", shared(ballsAt({{x + 0.6, y, 0}})), replanner.time(), 0.01);
  const ReplanStep step = replanner.step();
  lines.push_back(logLine(problem, step));
  lines.push_back(logLine(problem, replanner.executed()));
  const VerifyResult proven = verified(problem, lines);
  EXPECT_EQ(proven.status, VerifyStatus::kCertified) << proven.reason;
  lines[5] = changedLine(
      lines[5], [&](nlohmann::ordered_json& line) { line["observed"][0]["balls"][0][0] = x; });
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kRefuted);
}

TEST_F(SeenClouds, CroppedCloudsDoNotMoveAndCarvedOnesOnlyByABound) {
  Problem problem = fenceGate();
  Object& seen = problem.world.objects.back();
  PointCloud cloud = *seen.cloud;
  cloud.filters.push_back({"carve", "balls that touch disc", 1});
  seen.cloud = shared(cloud);
  EXPECT_NO_THROW(validate(problem));
  EXPECT_NO_THROW(Replanner{problem});
  Problem moves = problem;
  moves.world.objects.back().motion = std::make_shared<const ObjectMotion>(ObjectMotion{
      .poses = collision::PoseMotion::steady({0, {}}, {0.1, 0, 0}, Eigen::Vector3d::Zero())});
  robots::expectInputError([&] { validate(moves); }, "fence", 0, {"was carved for one place"});
  cloud.crops.push_back({1, {}, reachOf(problem)});
  seen.cloud = shared(cloud);
  robots::expectInputError([&] { validate(problem); }, "fence", 0, {"was cropped"});
}

}  // namespace
}  // namespace leeway::planner
