// Logs of executions: what Replanner writes is proven, and what was changed is refuted or refused.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/planner/replanner.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/random.h"
#include "planner/execute/log_line.h"
#include "planner/verify/moving_body.h"
#include "tests/support/dense_truth.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using collision::DeformableMesh;
using collision::PoseMotion;
using collision::VertexMotion;
using Json = nlohmann::ordered_json;
using Lines = std::vector<std::string>;

robots::Pose posed(double x, double y, double angle) {
  robots::Pose pose = test::at(x, y, 0);
  pose.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

Object bar(const std::string& name, const ObjectMotion& motion) {
  return movingObject(test::box(name, {0.05, 0.3, 0.5}, 0, 0, 0), motion);
}

/// A disc at the left of a gap in a wall.
Problem gate() {
  Problem problem = test::wallProblem();
  problem.name = "gate";
  problem.start = {-1, 1.2, 0};
  problem.goals = {test::pointGoal("goal", {1, 1.2, 0})};
  problem.margins.common = 0.01;
  problem.limits.iterations = 1000;
  problem.execution.duration = 12;
  return problem;
}

/// A bar closes the gap for a while.
Problem barGate() {
  Problem problem = gate();
  problem.world.objects.push_back(
      bar("bar", {.poses = PoseMotion::keys(
                      {{0, posed(0, 1.2, 0)}, {1, posed(0, 1.2, 0.2)}, {2, posed(0, 2.2, 1)}})}));
  return problem;
}

std::vector<Eigen::Vector3d> sheetVertices() {
  std::vector<Eigen::Vector3d> vertices;
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= 4; ++i) vertices.emplace_back(0, 0.95 + 0.125 * i, -0.5 + 0.5 * j);
  return vertices;
}

std::shared_ptr<const DeformableMesh> sheet() {
  std::vector<DeformableMesh::Triangle> triangles;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 4; ++i) {
      const int a = j * 5 + i, c = a + 5;
      triangles.push_back({a, a + 1, c + 1});
      triangles.push_back({a, c + 1, c});
    }
  return DeformableMesh::make(sheetVertices(), triangles);
}

/// A sheet closes the gap for a while.
Problem sheetGate() {
  collision::MorphMotion motion;
  motion.references = {sheetVertices(), sheetVertices()};
  for (Eigen::Vector3d& v : motion.references[1]) v.z() += 1.2;
  motion.keys = {{0.5, {1, 0}}, {1.5, {0, 1}}};
  Problem problem = gate();
  problem.world.deforming.push_back(
      makeDeformingObstacle("sheet", sheet(), VertexMotion::morph(motion), {}));
  return problem;
}

Lines logOf(const Problem& problem, int steps = 0) {
  Lines lines;
  const ReplanResult result = replan(
      problem, {}, [&](const ReplanStep& step) { lines.push_back(logLine(problem, step)); }, steps);
  lines.push_back(logLine(problem, result));
  return lines;
}

/// The program sees a bar, or a sheet, at each step, as a motion that the robot does not know moves
/// it, with the tightest bounds that are true for a time, by default the step's.
Lines logOfObserver(const Problem& problem, const PoseMotion& unknown, int most = 200,
                    double bounded = 0) {
  Lines lines;
  Replanner replanner(problem);
  for (int k = 0; k < most && !replanner.reached(); ++k) {
    const double now = replanner.time(), next = now + std::max(bounded, problem.execution.step);
    replanner.setPose("bar", unknown.pose(now), now, unknown.speedBound(now, next, 0),
                      unknown.speedBound(now, next, 1e6) * 1e-6 + 1e-9);
    const ReplanStep step = replanner.step();
    lines.push_back(logLine(problem, step));
    if (!step.certified) break;
  }
  lines.push_back(logLine(problem, replanner.executed()));
  return lines;
}

std::shared_ptr<const PoseMotion> opening() {
  return PoseMotion::keys(
      {{0, posed(0, 1.2, 0)}, {0.4, posed(0, 1.2, 0)}, {1.4, posed(0, 2.2, 1)}});
}

Problem observedGate() {
  Problem problem = gate();
  problem.world.objects.push_back(bar("bar", {.speed_bound = 0, .turn_bound = 0}));
  problem.world.objects.back().X_WO = posed(0, 1.2, 0);
  return problem;
}

std::string textOf(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class VerifyLog : public ::testing::Test {
 protected:
  VerifyResult verified(const Problem& problem, const Lines& lines) {
    return verifyLog(problem, folder_.write("run.jsonl", textOf(lines)));
  }
  std::string file() const { return folder_.path("run.jsonl"); }

  void expectCertified(const Problem& problem, const Lines& lines) {
    ASSERT_GT(lines.size(), 3u);
    const VerifyResult result = verified(problem, lines);
    EXPECT_EQ(result.status, VerifyStatus::kCertified)
        << "line " << result.line << ", " << result.t0 << " s: " << result.a << " " << result.b
        << ": " << result.reason;
    EXPECT_GT(result.clearance_lower, problem.margins.common);
    EXPECT_EQ(result.line, 0);
  }
  void expectRefused(const Problem& problem, const Lines& lines, int line,
                     std::initializer_list<std::string> words) {
    const std::string path = folder_.write("run.jsonl", textOf(lines));
    robots::expectInputError([&] { verifyLog(problem, path); }, path, line, words);
  }
  void expectNotProven(const Problem& problem, const Lines& lines, VerifyStatus status, int line,
                       const std::string& words) {
    const VerifyResult result = verified(problem, lines);
    EXPECT_EQ(result.status, status) << result.reason;
    EXPECT_EQ(result.line, line) << result.reason;
    EXPECT_NE(result.reason.find(words), std::string::npos) << result.reason;
  }

  Folder folder_;
};

/// A line with a document that was changed, and the sum of the changed text.
std::string forged(const std::string& line, const std::function<void(Json&)>& change) {
  Json document = Json::parse(line);
  change(document);
  document.erase("sum");
  std::string text = document.dump();
  text.pop_back();
  return fmt::format("{}{}{:016x}{}", text, kBeforeSum, lineSum(text), kAfterSum);
}

TEST_F(VerifyLog, StepsWithoutObstaclesThatMoveAreProven) {
  expectCertified(gate(), logOf(gate()));
}

TEST_F(VerifyLog, RigidObstaclesMoveByTheVerifiersOwnKinematics) {
  Problem problem = barGate();
  expectCertified(problem, logOf(problem));
  problem.execution.foresight = Foresight::kSpeedBound;
  expectCertified(problem, logOf(problem));
  problem.world.objects.back() =
      bar("bar", {.poses = PoseMotion::steady({0, posed(0, 1.2, 0.1)}, {0, 0.4, 0}, {0, 0, 0.5})});
  problem.execution.foresight = Foresight::kMotion;
  expectCertified(problem, logOf(problem));
}

TEST_F(VerifyLog, WhatWasSeenOnceGrows) {
  Problem problem = gate();
  problem.world.objects.push_back(
      bar("bar", {.speed_bound = 0.05, .turn_bound = 0.05, .age = 0.5}));
  problem.world.objects.back().X_WO = test::at(0, -1, 0);
  expectCertified(problem, logOf(problem));
}

TEST_F(VerifyLog, DeformingObstaclesAreProven) {
  Problem problem = sheetGate();
  expectCertified(problem, logOf(problem));
  problem.execution.foresight = Foresight::kSpeedBound;
  expectCertified(problem, logOf(problem));
  problem.world.deforming[0].speed_bound = 2;
  expectCertified(problem, logOf(problem));
}

TEST_F(VerifyLog, BodiesThatTurnFreelyAreProven) {
  Problem problem = test::problemOf(test::flyingBox(), {-0.5, 0, 0, 0, 0, 0, 1},
                                    {0.5, 0.2, 0.1, 0, 0, std::sqrt(0.5), std::sqrt(0.5)});
  problem.world.objects.push_back(test::box("block", {0.05, 0.2, 0.2}, 0, 0, 0));
  problem.limits.iterations = 2000;
  expectCertified(problem, logOf(problem));
}

/// Regression: angles were wrapped to [-pi, pi), and orientations changed their sign, in the middle
/// of a motion. Logs that were written so are still read.
TEST_F(VerifyLog, MotionsContinueStraightFromRowToRow) {
  Problem up = gate(), down = gate();
  up.start[2] = 2.5;
  up.goals = {test::pointGoal("goal", {1, 1.2, -2.5})};
  down.start[2] = -7;
  down.goals = {test::pointGoal("goal", {1, 1.2, -2.7986666666666666})};  // less 2 pi: rounded
  Problem free = test::problemOf(test::flyingBox(), {-0.5, 0, 0, 0, 0, 0, 1},
                                 {0.5, 0.2, 0.1, 0, 0, -0.8, -0.6});
  for (const Problem* problem : {&up, &down, &free}) {
    Lines lines;
    std::vector<double> last;
    const auto follow = [&](std::vector<double>& from, const TimedPoint& row) {
      for (std::size_t i = 0; i < from.size(); ++i) EXPECT_NEAR(row.position[i], from[i], 0.2);
      from = row.position;
    };
    const ReplanResult result = replan(*problem, {}, [&](const ReplanStep& step) {
      for (const TimedPoint& row : step.motion) follow(last, row);
      std::vector<double> stopping = last;
      for (const TimedPoint& row : step.stop) follow(stopping, row);
      lines.push_back(logLine(*problem, step));
    });
    EXPECT_EQ(result.status, ReplanStatus::kReached);
    lines.push_back(logLine(*problem, result));
    expectCertified(*problem, lines);
    if (problem == &free) continue;
    EXPECT_GT(std::abs(last[2]), 3.2);
    for (std::string& line : lines)
      line = forged(line, [](Json& document) {
        const auto wrap = [](Json& row) {
          row["position"][2] = std::remainder(row["position"][2].get<double>(), collision::kTwoPi);
        };
        if (document.contains("position")) wrap(document);
        for (const char* key : {"motion", "stop"})
          if (document.contains(key) && document[key].is_array())
            for (Json& row : document[key]) wrap(row);
      });
    expectCertified(*problem, lines);
  }
}

TEST_F(VerifyLog, WhatAProgramObservesIsProven) {
  const Problem problem = observedGate();
  const Lines lines = logOfObserver(problem, *opening());
  EXPECT_GT(lines.size(), 20u);
  expectCertified(problem, lines);
  const Json first = Json::parse(lines[0]);
  EXPECT_EQ(first["observed"][0]["object"], "bar");
  EXPECT_EQ(first["obstacles"][0]["seen"], 0);
  EXPECT_EQ(first["obstacles"][0]["predicted"], false);
}

TEST_F(VerifyLog, VerticesThatAProgramObservesAreProven) {
  Problem problem = gate();
  problem.world.deforming.push_back(makeDeformingObstacle("sheet", sheet(), nullptr, {}));
  Lines lines;
  Replanner replanner(problem);
  std::vector<Eigen::Vector3d> seen = sheetVertices();
  while (!replanner.reached() && lines.size() < 200) {
    replanner.setVertices("sheet", seen, replanner.time(), 0.5);
    const ReplanStep step = replanner.step();
    ASSERT_TRUE(step.certified);
    lines.push_back(logLine(problem, step));
    for (Eigen::Vector3d& v : seen) v.z() += 0.4 * problem.execution.step;
  }
  EXPECT_TRUE(replanner.reached());
  lines.push_back(logLine(problem, replanner.executed()));
  expectCertified(problem, lines);
  // A sheet that was seen farther away than its bound allows was not within it before.
  Lines jumped = lines;
  jumped[5] = forged(lines[5], [](Json& line) { line["observed"][0]["vertices"][7][0] = 0.1; });
  expectNotProven(problem, jumped, VerifyStatus::kRefuted, 6, "is 0.1");
  jumped = lines;
  jumped[5] = forged(lines[5], [](Json& line) { line["observed"][0]["vertices"].erase(3); });
  expectRefused(problem, jumped, 6, {"14 vertices of 'sheet'; 15 are expected"});
}

/// Any change of a line, or of their order, is found, whatever it changes.
TEST_F(VerifyLog, EveryChangeOfALineIsFound) {
  const Problem problem = observedGate();
  const Lines lines = logOfObserver(problem, *opening());
  ASSERT_GT(lines.size(), 10u);
  for (const char* key :
       {"\"time\":", "\"decision\":\"", "\"certified\":", "\"clearance_lower\":",
        "\"motion\":[{\"time\":", "\"observed\":[{\"object\":\"bar\",\"time\":", "\"rotation\":[[",
        "\"speed_bound\":", "\"seen\":", "\"edges\":", "\"sum\":\""}) {
    Lines changed = lines;
    const std::size_t at = changed[4].find(key);
    ASSERT_NE(at, std::string::npos) << key;
    char& c = changed[4][at + std::string(key).size()];
    c = c == '1' ? '2' : '1';
    expectRefused(problem, changed, 5, {"the line was changed after it was written: its sum is "});
  }
  for (const std::size_t left :
       {std::size_t{0}, std::size_t{1}, lines[4].size() / 2, lines[4].size() - 1}) {
    Lines cut(lines.begin(), lines.begin() + 5);
    cut[4].resize(left);
    expectRefused(problem, cut, 5, {"the line has no sum at its end: it was cut or changed"});
  }
}

TEST_F(VerifyLog, LinesThatAreMissingOrNotInOrderAreFound) {
  const Problem problem = barGate();
  const Lines lines = logOf(problem);
  ASSERT_GT(lines.size(), 10u);
  Lines changed = lines;
  changed.erase(changed.begin());
  expectNotProven(problem, changed, VerifyStatus::kRefuted, 1,
                  "step 1 is where step 0 is expected");
  changed = lines;
  changed.erase(changed.begin() + 4);
  expectNotProven(problem, changed, VerifyStatus::kRefuted, 5,
                  "step 5 is where step 4 is expected");
  changed = lines;
  std::swap(changed[4], changed[5]);
  expectNotProven(problem, changed, VerifyStatus::kRefuted, 5,
                  "step 5 is where step 4 is expected");
  changed = lines;
  changed.insert(changed.begin() + 4, changed[3]);
  expectNotProven(problem, changed, VerifyStatus::kRefuted, 5,
                  "step 3 is where step 4 is expected");
  changed = lines;
  changed.erase(changed.end() - 2);
  expectNotProven(problem, changed, VerifyStatus::kRefuted, static_cast<int>(changed.size()),
                  "steps is ");
  changed = lines;
  changed.pop_back();
  expectNotProven(problem, changed, VerifyStatus::kUndecided, static_cast<int>(changed.size()),
                  "the log was cut behind this line");
  changed = lines;
  changed.push_back(lines.back());
  expectRefused(problem, changed, static_cast<int>(changed.size()),
                {"the line follows the end of the execution"});
  expectRefused(problem, {}, 0, {"is empty"});
  expectRefused(problem, {"{}"}, 1, {"the line has no sum"});
  EXPECT_THROW(verifyLog(problem, folder_.path("nowhere.jsonl")), robots::InputError);
}

/// Lines that were changed on purpose, with new sums.
TEST_F(VerifyLog, WhatContradictsTheRestIsRefuted) {
  const Problem problem = observedGate();
  const Lines lines = logOfObserver(problem, *opening());
  ASSERT_GT(lines.size(), 12u);
  const int last = static_cast<int>(lines.size());
  const auto expectRefuted = [&](int line, const std::function<void(Json&)>& change,
                                 const std::string& words) {
    Lines changed = lines;
    changed[static_cast<std::size_t>(line) - 1] =
        forged(lines[static_cast<std::size_t>(line) - 1], change);
    SCOPED_TRACE(words);
    expectNotProven(problem, changed, VerifyStatus::kRefuted, line, words);
  };
  expectRefuted(
      1, [](Json& l) { l["step"] = 1; }, "step 1 is where step 0");
  expectRefuted(
      1, [](Json& l) { l["motion"][0]["time"] = 0.01; }, "the execution begins at 0 s");
  expectRefuted(
      1,
      [](Json& l) {
        for (Json& row : l["motion"]) row["position"][1] = 1.3;
        l["position"][1] = 1.3;
      },
      "the first waypoint is not the start");
  expectRefuted(
      5, [](Json& l) { l["motion"][0]["time"] = 0.19; }, "the step before ends at 0.2");
  expectRefuted(
      5, [](Json& l) { l["time"] = 0.21; }, "its time is 0.21 s; its motion begins at");
  expectRefuted(
      5, [](Json& l) { l["motion"][0]["position"][0] = -0.99; },
      "its motion does not begin where the step before ends: ");
  expectRefuted(
      5, [](Json& l) { l["position"][1] = 0; }, "position is not where its motion ends");
  expectRefuted(
      5,
      [](Json& l) {
        Json& rows = l["motion"];
        rows.insert(rows.end() - 1, rows[0]);
        rows[1]["time"] = 0.19;
      },
      "times that do not decrease are expected");
  expectRefuted(
      5, [](Json& l) { l["observed"][0]["time"] = 0.3; }, "'bar' was seen at 0.3 s, later");
  expectRefuted(
      5, [](Json& l) { l["observed"] = Json::array(); }, "'bar' was seen at 0.2");
  expectRefuted(
      5, [](Json& l) { l["observed"][0]["time"] = 0.19; }, "'bar' was seen at 0.2");
  expectRefuted(
      5, [](Json& l) { l["observed"][0]["position"][1] = 1.7; },
      "at most 0 m is allowed by its speed bound, on which line 4 relied");
  expectRefuted(
      5,
      [](Json& l) {
        l["observed"][0]["rotation"] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
      },
      "allowed by its turning bound, on which line 4 relied");
  expectRefuted(
      5, [](Json& l) { l["obstacles"][0]["predicted"] = true; }, "'bar' is predicted");
  expectRefuted(
      5, [](Json& l) { l["obstacles"] = Json::array(); }, "it lists 0 obstacles");
  expectRefuted(
      5, [](Json& l) { l["obstacles"][0]["name"] = "car"; }, "obstacles[0] is 'car'");
  expectRefuted(
      5, [](Json& l) { l["certified"] = false; }, "certified is false with the decision");
  expectRefuted(
      5, [](Json& l) { l["reached"] = true; }, "ends in none of the problem's goals");
  expectRefuted(
      last, [](Json& l) { l["steps"] = 3; }, "steps is 3; by the lines before it is ");
  expectRefuted(
      last, [](Json& l) { l["waits"] = 0; }, "waits is 0; by the lines before it is ");
  expectRefuted(
      last, [](Json& l) { l["certified"] = false; }, "certified is false");
  expectRefuted(
      last, [](Json& l) { l["status"] = "unsafe"; }, "status: ");
  expectRefuted(
      last, [](Json& l) { l["duration"] = 1; }, "duration is 1; by the lines before");
}

TEST_F(VerifyLog, WhatIsNoLineOfALogIsRefused) {
  const Problem problem = observedGate();
  const Lines lines = logOfObserver(problem, *opening());
  const int last = static_cast<int>(lines.size());
  const auto expectBad = [&](int line, const std::function<void(Json&)>& change,
                             std::initializer_list<std::string> words) {
    Lines changed = lines;
    changed[static_cast<std::size_t>(line) - 1] =
        forged(lines[static_cast<std::size_t>(line) - 1], change);
    SCOPED_TRACE(*words.begin());
    expectRefused(problem, changed, line, words);
  };
  expectBad(3, [](Json& l) { l["version"] = 1; }, {"version is 1; 2, as `leeway replan` "});
  expectBad(3, [](Json& l) { l.erase("motion"); }, {"key 'motion' is missing"});
  expectBad(3, [](Json& l) { l["decision"] = "folow"; }, {"decision is 'folow'", "'follow'"});
  expectBad(3, [](Json& l) { l["joint_names"][1] = "disc/z"; },
            {"'disc/z'", "'disc/y' is expected"});
  expectBad(3, [](Json& l) { l["joint_names"].erase(1); }, {"2 joints are named; 3"});
  expectBad(3, [](Json& l) { l["motion"] = Json::array({l["motion"][0]}); },
            {"motion has ", "at least 2"});
  expectBad(3, [](Json& l) { l["motion"][0]["position"].erase(1); }, {"2 numbers; 3"});
  expectBad(3, [](Json& l) { l["motion"][1]["position"][0] = "a"; }, {"a number is expected"});
  expectBad(3, [](Json& l) { l["motion"][1]["position"][0] = nullptr; }, {"a number is expected"});
  expectBad(3, [](Json& l) { l["motion"][1]["time"] = "soon"; }, {"a number is expected"});
  expectBad(3, [](Json& l) { l["observed"][0]["object"] = "ba"; },
            {"no object with a motion 'ba'; did you mean 'bar'?"});
  expectBad(3, [](Json& l) { l["observed"][0]["rotation"][0][0] = 0; }, {"the pose is at"});
  expectBad(3, [](Json& l) { l["observed"][0]["speed_bound"] = -1; }, {"zero or more"});
  expectBad(last, [](Json& l) { l["problem"] = "other"; }, {"'other'", "'gate' is expected"});
  expectBad(last, [](Json& l) { l["status"] = "arrived"; }, {"status is 'arrived'"});
}

/// The motion itself is proven: a robot that drives where it cannot be, or too fast, is found even
/// if everything else in its log agrees.
TEST_F(VerifyLog, MotionsThatAreNotFreeOrTooFastAreRefuted) {
  Problem problem = barGate();
  problem.execution.accelerations = {{"disc/x", 100}};
  const Lines lines = logOf(problem);
  // The bar is in the gap until about 1 s; the robot drives through it from the start.
  Lines bold;
  const double step = problem.execution.step;
  for (int k = 0; k < 30; ++k)
    bold.push_back(forged(lines[0], [&](Json& l) {
      const auto row = [&](int i) {
        return Json{{"time", i * step}, {"position", {-1 + 0.05 * i, 1.2, 0}}};
      };
      l["step"] = k;
      l["time"] = k * step;
      l["motion"] = {row(k), row(k + 1)};
      l["stop"] = Json::array();
      l["position"] = l["motion"][1]["position"];
      l["decision"] = "follow";
      l["reached"] = false;
      l["obstacles"][0]["seen"] = k * step;
    }));
  const VerifyResult hit = verified(problem, bold);
  EXPECT_EQ(hit.status, VerifyStatus::kRefuted) << hit.reason;
  EXPECT_EQ(hit.a, "disc");
  EXPECT_EQ(hit.b, "bar");
  EXPECT_GE(hit.line, 14);
  EXPECT_LE(hit.line, 25);
  EXPECT_GE(hit.t0, 0.65);
  EXPECT_NE(hit.reason.find("mm"), std::string::npos) << hit.reason;
  Problem slow = problem;
  slow.execution.velocities = {{"disc/x", 0.9}};
  const VerifyResult fast = verified(slow, bold);
  EXPECT_EQ(fast.status, VerifyStatus::kRefuted);
  EXPECT_EQ(fast.line, 1);
  EXPECT_NE(fast.reason.find("disc/x moves by 0.05"), std::string::npos) << fast.reason;
  // Nor does it reach its speed at once, or brake at once.
  problem.execution.accelerations = {{"disc/x", 19}};
  const VerifyResult sudden = verified(problem, bold);
  EXPECT_EQ(sudden.status, VerifyStatus::kRefuted);
  EXPECT_EQ(sudden.line, 1);
  EXPECT_NE(sudden.reason.find("disc/x's acceleration is 20 at 0.05 s; its limit is 19"),
            std::string::npos)
      << sudden.reason;
  problem.execution.accelerations = {{"disc/x", 100}};
  problem.execution.jerks = {{"disc/x", 300}};
  EXPECT_NE(verified(problem, bold).reason.find("disc/x's jerk is 400"), std::string::npos);
  problem.execution.jerks.clear();
  // The log of one problem does not prove another, with a gap that stays closed.
  Problem closed = gate();
  closed.execution = problem.execution;
  closed.world.objects.push_back(
      bar("bar", {.poses = PoseMotion::keys({{0, posed(0, 1.2, 0)}, {9, posed(0, 1.2, 0.1)}})}));
  const VerifyResult other = verified(closed, lines);
  EXPECT_EQ(other.status, VerifyStatus::kRefuted);
  EXPECT_EQ(other.b, "bar");
}

/// The stop of a step is proven with what the step knew: that it is free, ends at rest, and keeps
/// the limits.
TEST_F(VerifyLog, StopsAreProven) {
  const Problem problem = gate();
  const Lines lines = logOf(problem);
  std::size_t k = 0;
  while (k + 2 < lines.size() && Json::parse(lines[k])["stop"].size() < 10) ++k;
  const auto refuted = [&](const std::function<void(Json&)>& change, const std::string& why) {
    Lines changed = lines;
    changed[k] = forged(lines[k], [&](Json& l) { change(l["stop"]); });
    const VerifyResult result = verified(problem, changed);
    EXPECT_NE(result.status, VerifyStatus::kCertified);
    EXPECT_EQ(result.line, static_cast<int>(k) + 1);
    EXPECT_EQ(result.reason.substr(0, 13), "in its stop: ");
    EXPECT_NE(result.reason.find(why), std::string::npos) << result.reason;
  };
  refuted([](Json& stop) { stop = Json::array(); }, "acceleration is ");
  refuted([](Json& stop) { stop.erase(stop.begin() + 5, stop.end()); }, "acceleration is ");
  // It creeps into the wall, far below the limits.
  refuted(
      [](Json& stop) {
        Json row = stop.back();
        const double x = row["position"][0].get<double>(), y = row["position"][1].get<double>(),
                     t = row["time"].get<double>();
        for (int i = 1; i <= 3000; ++i) {
          row["time"] = t + 0.02 * i;
          row["position"][0] = x + 0.0005 * i;
          row["position"][1] = y - 0.0005 * i;
          stop.push_back(row);
        }
      },
      "mm");
}

/// A stop that a step keeps is not written again, and proven again only where more is known.
TEST_F(VerifyLog, StopsThatAreKept) {
  Problem problem = observedGate();
  problem.execution.step = 0.005;
  const std::shared_ptr<const PoseMotion> still =
      PoseMotion::keys({{0, posed(0, 2.2, 1)}, {9, posed(0, 2.2, 1.1)}});
  problem.world.objects.back().X_WO = posed(0, 2.2, 1);
  Lines lines = logOfObserver(problem, *still, 40);
  const auto isKept = [&](std::size_t k) { return Json::parse(lines[k])["stop"].is_null(); };
  std::size_t first = 0, kept = 0;
  for (std::size_t k = 0; k + 1 < lines.size(); ++k) kept += isKept(k) ? 1u : 0u;
  while (!isKept(first)) ++first;
  EXPECT_GE(kept, 30u);
  expectCertified(problem, lines);
  const auto changed = [&](const std::function<void(Json&)>& change) {
    Lines other = lines;
    other[first] = forged(lines[first], change);
    return other;
  };
  const int line = static_cast<int>(first) + 1;
  expectNotProven(problem, changed([](Json& l) {
                    Json& x = l["motion"].back()["position"][0];
                    x = l["position"][0] = x.get<double>() + 1e-15;
                  }),
                  VerifyStatus::kRefuted, line, "is not the beginning of that");
  Lines none = lines;
  none[0] = forged(lines[0], [](Json& l) { l["stop"] = nullptr; });
  expectNotProven(problem, none, VerifyStatus::kRefuted, 1, "is not the beginning of that");
  // A bar that may have become faster could come into the stop.
  expectNotProven(problem, changed([](Json& l) { l["observed"][0]["speed_bound"] = 30; }),
                  VerifyStatus::kRefuted, line, "if it moves as its bounds allow");
}

/// A bar that was in the gap comes over a robot that stands, faster than it can leave, goes back,
/// and opens the gap.
Lines logOfExposed(const Problem& problem) {
  Lines lines;
  Replanner replanner(problem);
  for (int k = 0; k < 200 && !replanner.reached(); ++k) {
    const double now = replanner.time(), next = now + problem.execution.step;
    const bool is_fast = k == 3 || k == 4;
    replanner.setPose("bar", k == 4 ? posed(-0.95, 1.2, 0) : opening()->pose(now), now,
                      is_fast ? 100 : opening()->speedBound(now, next, 0),
                      opening()->speedBound(now, next, 1e6) * 1e-6 + 1e-9);
    const ReplanStep step = replanner.step();
    EXPECT_EQ(step.exposed, is_fast) << k << ": " << step.why;
    lines.push_back(logLine(problem, step));
  }
  EXPECT_TRUE(replanner.reached());
  lines.push_back(logLine(problem, replanner.executed()));
  return lines;
}

TEST_F(VerifyLog, ExposedStepsAreProvenButForWhatReachesARobotThatStands) {
  const Problem problem = observedGate();
  const Lines lines = logOfExposed(problem);
  const VerifyResult result = verified(problem, lines);
  EXPECT_EQ(result.status, VerifyStatus::kExposed) << result.reason;
  EXPECT_EQ(result.line, 4);
  EXPECT_EQ(result.t0, Json::parse(lines[3])["time"].get<double>());
  EXPECT_NE(result.reason.find("the robot stands where an obstacle that moves may reach it"),
            std::string::npos);
  Lines cut = lines;
  cut.pop_back();
  expectNotProven(problem, cut, VerifyStatus::kUndecided, static_cast<int>(cut.size()), "was cut");
}

TEST_F(VerifyLog, ExposedExcusesNothingElse) {
  const Problem problem = observedGate();
  const Lines lines = logOfExposed(problem);
  const auto expectRefuted = [&](std::size_t line, const std::function<void(Json&)>& change,
                                 const std::string& words) {
    Lines changed = lines;
    changed[line - 1] = forged(lines[line - 1], change);
    SCOPED_TRACE(words);
    expectNotProven(problem, changed, VerifyStatus::kRefuted, static_cast<int>(line), words);
  };
  const auto makeExposed = [](Json& l) {
    l["exposed"] = true;
    l["certified"] = false;
    l["decision"] = "unsafe";
  };
  // The bar does come over the robot.
  Lines told = lines;
  for (const std::size_t k : {3u, 4u})
    told[k] = forged(lines[k], [](Json& l) { l["exposed"] = false; });
  const VerifyResult hit = verified(problem, told);
  EXPECT_EQ(hit.status, VerifyStatus::kRefuted);
  EXPECT_EQ(hit.line, 4);
  EXPECT_EQ(hit.b, "bar");
  expectRefuted(
      4, [](Json& l) { l["certified"] = true; }, "certified is true with the decision 'unsafe'");
  expectRefuted(
      3, [](Json& l) { l["exposed"] = true; }, "exposed is true, and so is certified");
  // It moves while it says that it is exposed: a little, also away from its place for one row, or
  // with other times.
  for (const double by : {1e-15, 1e-6, -0.01})
    expectRefuted(
        5,
        [&](Json& l) {
          Json& x = l["motion"].back()["position"][0];
          x = l["position"][0] = x.get<double>() + by;
        },
        "is not what the stop of the step before leaves: disc/x is ");
  expectRefuted(
      5,
      [](Json& l) {
        Json& x = l["motion"][1]["position"][0];
        x = x.get<double>() - 1e-5;
      },
      "is not what the stop of the step before leaves: disc/x is ");
  // A motion that is exposed must be proven, too.
  std::size_t moving = 6;
  while (Json::parse(lines[moving])["decision"] != "follow" ||
         Json::parse(lines[moving])["stop"].size() < 4)
    ++moving;
  expectRefuted(moving + 2, makeExposed, "is not what the stop of the step before leaves");
  // The bar is still there when a step says that it is certified, or the bar jumps farther.
  expectRefuted(
      6,
      [&](Json& l) {
        l["observed"][0]["position"] = Json::parse(lines[4])["observed"][0]["position"];
        l["observed"][0]["rotation"] = Json::parse(lines[4])["observed"][0]["rotation"];
        l["observed"][0]["speed_bound"] = 100;
      },
      "at least ");
  expectRefuted(
      5, [](Json& l) { l["observed"][0]["position"][0] = 9; }, "on which line 4 relied");
  Lines ended = lines;
  ended.back() = forged(lines.back(), [](Json& l) { l["status"] = "exposed"; });
  expectNotProven(problem, ended, VerifyStatus::kRefuted, static_cast<int>(lines.size()),
                  "status: exposed is true; by the lines before it is false");
}

/// A stop that was proven before is all that a robot in motion can do, and is proven again.
TEST_F(VerifyLog, ExposedStepsThatMoveAreProven) {
  Problem problem = observedGate();
  problem.world.objects.back().X_WO = posed(0, 2.2, 1);
  const std::shared_ptr<const PoseMotion> still =
      PoseMotion::keys({{0, posed(0, 2.2, 1)}, {9, posed(0, 2.2, 1)}});
  Lines lines = logOfObserver(problem, *still, 6);
  // The robot takes the stop of the last step, says that it is exposed, and stands behind it.
  const Json last = Json::parse(lines[5]);
  ASSERT_GT(last["stop"].size(), 2u);
  const auto goOn = [&](double bound) {
    Lines changed = lines;
    changed[6] = forged(lines[5], [&](Json& l) {
      l["step"] = 6;
      l["time"] = last["motion"].back()["time"];
      l["motion"] = last["stop"];
      l["motion"].insert(l["motion"].begin(), last["motion"].back());
      Json rest = last["stop"].back();
      rest["time"] = rest["time"].get<double>() + 5;
      l["motion"].push_back(rest);
      l["position"] = rest["position"];
      l["stop"] = Json::array();
      l["exposed"] = true;
      l["certified"] = false;
      l["decision"] = "unsafe";
      l["observed"][0]["time"] = l["obstacles"][0]["seen"] = l["time"];
      l["observed"][0]["speed_bound"] = bound;
    });
    changed.push_back(forged(lines.back(), [&](Json& l) {
      l["steps"] = 7;
      l["waits"] = l["waits"].get<int>() + 1;
      l["status"] = "exposed";
      l["certified"] = false;
      l["duration"] = Json::parse(changed[6])["motion"].back()["time"];
    }));
    return verified(problem, changed);
  };
  // The bar comes over the place in the five seconds, but not before the robot rests; or before.
  const VerifyResult reached = goOn(0.5);
  EXPECT_EQ(reached.status, VerifyStatus::kExposed) << reached.reason;
  EXPECT_EQ(reached.line, 7);
  const VerifyResult hit = goOn(30);
  EXPECT_EQ(hit.status, VerifyStatus::kRefuted);
  EXPECT_EQ(hit.line, 7);
  EXPECT_EQ(hit.b, "bar");
}

/// A robot is exposed only to obstacles that move.
TEST_F(VerifyLog, ExposedIsOnlyToWhatMoves) {
  Problem problem = observedGate();
  problem.world.objects.back() = bar("bar", {.speed_bound = kInfinity, .turn_bound = 0});
  const Lines lines = logOf(problem);
  ASSERT_EQ(lines.size(), 2u);
  expectNotProven(problem, lines, VerifyStatus::kExposed, 1, "may reach it");
  Problem within = problem;
  within.world.objects.push_back(test::box("block", {0.1, 0.1, 0.1}, -1, 1.2, 0));
  const VerifyResult hit = verified(within, lines);
  EXPECT_EQ(hit.status, VerifyStatus::kRefuted);
  EXPECT_EQ(hit.b, "block");
  Problem still = problem;
  still.world.objects.erase(still.world.objects.end() - 1);
  Lines alone = lines;
  alone[0] = forged(lines[0], [](Json& l) { l["obstacles"] = Json::array(); });
  expectNotProven(still, alone, VerifyStatus::kRefuted, 1,
                  "exposed is true, and no obstacle moves");
}

/// Rounding of times hides little of a limit, however late it is.
TEST_F(VerifyLog, RoundingHidesLittle) {
  Problem problem = gate();
  problem.execution.jerks = {{"disc/x", 30}, {"disc/y", 30}};
  problem.execution.start = 1.7e9;
  const Lines lines = logOf(problem);
  expectCertified(problem, lines);
  problem.execution.jerks = {{"disc/x", 27}, {"disc/y", 27}};
  const VerifyResult result = verified(problem, lines);
  EXPECT_EQ(result.status, VerifyStatus::kRefuted);
  EXPECT_NE(result.reason.find("'s jerk is "), std::string::npos) << result.reason;
}

/// A bound that is known to be too small for the gap between looks proves nothing.
TEST_F(VerifyLog, BoundsCountFromTheTimeOfTheSight) {
  const Problem problem = observedGate();
  Lines lines = logOfObserver(problem, *opening(), 6);
  const VerifyResult known = verified(problem, lines);
  ASSERT_EQ(known.status, VerifyStatus::kCertified) << known.reason;
  // From 1 m away, a bar that is 30 m/s fast could reach the robot within the step.
  lines[5] = forged(lines[5], [](Json& l) { l["observed"][0]["speed_bound"] = 30; });
  const VerifyResult near = verified(problem, lines);
  EXPECT_EQ(near.status, VerifyStatus::kRefuted);
  EXPECT_EQ(near.line, 6);
  EXPECT_NE(near.reason.find("if it moves as its bounds allow"), std::string::npos) << near.reason;
  // No bound, and no bound on its turning.
  lines[5] = forged(lines[5], [](Json& l) { l["observed"][0]["speed_bound"] = nullptr; });
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kUndecided);
  lines[5] = forged(lines[5], [](Json& l) {
    l["observed"][0]["speed_bound"] = 0;
    l["observed"][0]["turn_bound"] = nullptr;
  });
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kUndecided);
}

/// Sights bind each other, in whichever order a log states them: the earlier one's bounds hold.
TEST_F(VerifyLog, SightsThatContradictEachOtherAreRefuted) {
  const Problem problem = observedGate();
  const Lines lines = logOfObserver(problem, *opening(), 6);
  const auto far = [](Json sight, double time) {
    sight["time"] = time;
    sight["position"] = {0, 6, 0};
    sight["speed_bound"] = 0;
    return sight;
  };
  const double fourth = Json::parse(lines[3])["time"], third = Json::parse(lines[2])["time"];
  // Two sights in one line: the first agrees with what steps relied on, the second with nothing.
  Lines twice = lines;
  twice[3] =
      forged(lines[3], [&](Json& l) { l["observed"].push_back(far(l["observed"][0], fourth)); });
  expectNotProven(problem, twice, VerifyStatus::kRefuted, 4,
                  "by its speed bound, in the same line");
  // A first sight, with a bound that allows everything, does not hide what steps relied on.
  twice[3] = forged(lines[3], [&](Json& l) {
    l["observed"][0]["speed_bound"] = 1000;
    l["observed"].push_back(far(l["observed"][0], fourth));
    l["observed"][0]["time"] = third;
    l["observed"][0]["position"] = Json::parse(lines[2])["observed"][0]["position"];
    l["observed"][0]["rotation"] = Json::parse(lines[2])["observed"][0]["rotation"];
  });
  expectNotProven(problem, twice, VerifyStatus::kRefuted, 4, "on which line 3 relied");
  // A sight before the last one, from which the last one could not be reached.
  Lines older = lines;
  older[3] = forged(lines[3], [&](Json& l) {
    l["observed"][0] = far(l["observed"][0], third - 0.05);
    l["obstacles"][0]["seen"] = third - 0.05;
  });
  expectNotProven(problem, older, VerifyStatus::kRefuted, 4, "from a sight before");
  // The same against the problem's own motion, on which steps relied.
  const Problem known = barGate();
  Lines followed = logOf(known);
  ASSERT_GT(followed.size(), 16u);
  const double time = Json::parse(followed[14])["time"];
  followed[14] = forged(followed[14], [&](Json& l) {
    l["observed"] =
        Json::array({Json{{"object", "bar"},
                          {"time", -1},
                          {"position", {0, 1.2, 0}},
                          {"rotation", Json::parse(lines[0])["observed"][0]["rotation"]},
                          {"speed_bound", 0},
                          {"turn_bound", 0}}});
    l["obstacles"][0]["seen"] = -1;
    l["obstacles"][0]["predicted"] = false;
  });
  ASSERT_GT(time, 0.5);  // the bar has left its first place
  expectNotProven(known, followed, VerifyStatus::kRefuted, 15, "from where it was seen");
}

TEST_F(VerifyLog, AFirstMotionBeginsWhereTheRobotWasMeasured) {
  const Problem problem = observedGate();
  Lines lines = logOfObserver(problem, *opening(), 6);
  lines[0] = forged(lines[0], [](Json& l) { l["measured"] = l["motion"][0]["position"]; });
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kCertified);
  lines[0] = forged(lines[0], [](Json& l) { l["measured"][0] = 0.3; });
  expectNotProven(problem, lines, VerifyStatus::kRefuted, 1, "measured elsewhere");
}

TEST_F(VerifyLog, AMeasuredStateOffTheMotionLeavesAGap) {
  const Problem problem = gate();
  Replanner replanner(problem);
  Lines lines;
  for (int k = 0; k < 4; ++k) {
    if (k == 2) {
      std::vector<double> state(replanner.state().begin(), replanner.state().end());
      state[1] += 1e-3;
      replanner.setState(state);
    }
    lines.push_back(logLine(problem, replanner.step()));
  }
  lines.push_back(logLine(problem, replanner.executed()));
  expectNotProven(problem, lines, VerifyStatus::kUndecided, 3,
                  "the robot was measured off its motion: disc/y is 1.2");
}

TEST_F(VerifyLog, ProblemsThatNoExecutionTakesAreRefused) {
  const Lines lines = logOf(gate(), 2);
  Problem problem = gate();
  problem.goals.clear();
  EXPECT_THROW(verified(problem, lines), robots::InputError);
  problem = gate();
  problem.condition.accept = [](std::span<const double>) { return true; };
  EXPECT_THROW(verified(problem, lines), robots::InputError);
}

TEST_F(VerifyLog, NothingIsProvenWithoutPairsOrSteps) {
  Problem problem = gate();
  for (const Object& object : problem.world.objects)
    problem.contacts.allowed.emplace_back("disc", object.name);
  const Lines lines = logOf(problem);
  EXPECT_EQ(lines.size(), 1u);
  EXPECT_EQ(verified(problem, lines).status, VerifyStatus::kNothingChecked);
  EXPECT_EQ(Json::parse(lines[0])["status"], "nothing_checked");
  Replanner replanner(gate());
  EXPECT_EQ(verified(gate(), {logLine(gate(), replanner.executed())}).status,
            VerifyStatus::kUndecided);
}

/// The poses of the verifier are those of PoseMotion.
TEST_F(VerifyLog, ItsOwnPosesAgreeWithTheMotions) {
  Random random(80, 0);
  const auto number = [&](double most) { return random.uniform(-most, most); };
  const auto turn = [&] {
    return Eigen::Quaterniond(number(1), number(1), number(1), number(1))
        .normalized()
        .toRotationMatrix();
  };
  for (int k = 0; k < 200; ++k) {
    std::vector<PoseMotion::Key> keys;
    for (int i = 0; i < 4; ++i)
      keys.push_back({1.5 * i, {turn(), {number(2), number(2), number(2)}}});
    const auto poses = k % 2 == 0 ? PoseMotion::keys(keys)
                                  : PoseMotion::steady(keys[0], {number(1), number(1), number(1)},
                                                       {number(3), number(3), number(3)});
    const Object object = bar("bar", {.poses = poses});
    verification::MovingBody body(object, {});
    const verification::Sphere sphere{{0.1, 0.2, 0.3}, 0.5};
    for (int i = 0; i < 20; ++i) {
      const double time = random.uniform(-1, 6), half = random.uniform(0, 0.5);
      const verification::Place place = body.at(body.lookedAt(0), time, half, sphere);
      const robots::Pose expected = poses->pose(time);
      EXPECT_NEAR((place.X_WO.rotation - expected.rotation).norm(), 0, 1e-12);
      EXPECT_NEAR((place.X_WO.translation - expected.translation).norm(), 0, 1e-12);
      EXPECT_EQ(place.grown, 0);
      const Eigen::Vector3d p(0.1, 0.2, 0.8);
      for (const double end : {time - half, time + half})
        EXPECT_LE((poses->pose(end) * p - place.X_WO * p).norm(),
                  place.speed * half * (1 + 1e-9) + place.slack);
    }
  }
}

/// Regression: "status: reached is false; by the lines before it is true".
TEST_F(VerifyLog, AnExposedStepMayEndInTheGoal) {
  Problem problem = gate();
  problem.execution.step = 0.3;
  problem.world.objects.push_back(bar("bar", {.speed_bound = 0.1, .turn_bound = 0}));
  const robots::Pose far = posed(8, 8, 0);
  problem.world.objects.back().X_WO = far;
  const auto run = [&](int fast_step, double fast, Lines& lines) {
    Replanner replanner(problem);
    ReplanStep step;
    int k = 0;
    for (; k < 100 && !replanner.reached(); ++k) {
      replanner.setPose("bar", far, replanner.time(), k == fast_step ? fast : 0.1, 0);
      step = replanner.step();
      lines.push_back(logLine(problem, step));
    }
    lines.push_back(logLine(problem, replanner.executed()));
    return std::pair(k, step.exposed && step.reached);
  };
  Lines lines;
  const int steps = run(-1, 0, lines).first;
  bool found = false;
  for (int at = steps - 2; at < steps && !found; ++at)
    for (double fast = 2; fast < 200 && !found; fast *= 1.1) {
      lines.clear();
      found = run(at, fast, lines).second;
    }
  ASSERT_TRUE(found);
  const VerifyResult result = verified(problem, lines);
  EXPECT_EQ(result.status, VerifyStatus::kExposed) << result.line << ": " << result.reason;
  EXPECT_EQ(result.clearance_lower, 0);
}

/// The slow twin: random bars, one known by keys, one by its velocity, one that the program sees.
TEST_F(VerifyLog, RandomExecutionsAreProvenAndTheirClearanceHolds) {
  int steps = 0, certified = 0, exposed = 0;
  for (int seed = 0; seed < 16; ++seed) {
    SCOPED_TRACE(seed);
    Random random(81, static_cast<std::uint64_t>(seed));
    const auto randomPose = [&](double angle) {
      const double y = random.uniform(-1.2, 1.2), x = random.uniform(-0.9, 1.2);
      return posed(x, y, angle);
    };
    const auto randomKeys = [&] {
      std::vector<PoseMotion::Key> keys;
      double angle = random.uniform(-3, 3);
      for (int key = 0; key < 5; ++key) {
        keys.push_back({1.2 * key, randomPose(angle)});
        angle += random.uniform(-2.5, 2.5);
      }
      return PoseMotion::keys(keys);
    };
    Problem problem = test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0});
    problem.margins.common = 0.01;
    problem.limits.iterations = 300;
    problem.execution.step = 0.1;
    problem.seed = static_cast<std::uint64_t>(seed);
    if (seed % 3 == 2) problem.execution.foresight = Foresight::kSpeedBound;
    problem.world.objects.push_back(bar("keys", {.poses = randomKeys()}));
    problem.world.objects.push_back(
        bar("steady",
            {.poses = PoseMotion::steady({0, randomPose(0)},
                                         {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0},
                                         {0, 0, random.uniform(-1, 1)})}));
    const std::shared_ptr<const PoseMotion> unknown = randomKeys();
    Problem truth = problem;
    truth.world.objects.push_back(bar("bar", {.poses = unknown}));
    problem.world.objects.push_back(bar("bar", {.speed_bound = 0, .turn_bound = 0}));
    problem.world.objects.back().X_WO = unknown->pose(0);
    const Lines lines = logOfObserver(problem, *unknown, 40, seed % 2 == 0 ? 0 : 1e3);
    const VerifyResult result = verified(problem, lines);
    // The tightest bounds of a step may be wider than those of the step before: then it is unsafe.
    const std::string status = Json::parse(lines.back())["status"];
    if (status != "unsafe") {
      EXPECT_EQ(result.status,
                status == "exposed" ? VerifyStatus::kExposed : VerifyStatus::kCertified)
          << "line " << result.line << ": " << result.a << " " << result.b << " " << result.reason;
    }
    certified += result.status == VerifyStatus::kCertified ? 1 : 0;
    exposed += result.status == VerifyStatus::kExposed ? 1 : 0;
    if (result.status != VerifyStatus::kCertified) continue;
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
      std::vector<TimedPoint> motion;
      const Json line = Json::parse(lines[i]);
      for (const Json& row : line["motion"])
        motion.push_back({row["time"].get<double>(), row["position"].get<std::vector<double>>()});
      EXPECT_GE(test::denseClearance(truth, motion, 0.005, 1.0),
                std::min(1.0, result.clearance_lower) - 1e-9);
      ++steps;
    }
  }
  EXPECT_GE(certified, 4);
  EXPECT_GE(exposed, 1);
  EXPECT_GT(steps, 60);
}

}  // namespace
}  // namespace leeway::planner
