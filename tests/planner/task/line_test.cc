// Lines through poses: planned, proven, verified by other means, ended early, and refused.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/task.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/random.h"
#include "planner/task/line_way.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

using robots::Pose;

std::string arm(const std::string& name, const std::string& rest) {
  const std::string robot = leeway::sourceFolder() + "/robots/" + name + "/" + name + ".";
  return "leeway: 1\nrobot: {urdf: " + robot + "urdf, srdf: " + robot + "srdf, group: arm}\n" +
         rest;
}

std::vector<Pose> linksAt(const Problem& problem, const std::vector<double>& point) {
  std::vector<double> q = problem.start;
  for (std::size_t i = 0; i < point.size(); ++i)
    q[static_cast<std::size_t>(problem.robot.variables[i])] = point[i];
  std::vector<Pose> X_WL(problem.robot.model->links.size());
  robots::forwardKinematics(*problem.robot.model, q, X_WL);
  return X_WL;
}

std::vector<double> pointOf(const Problem& problem) {
  std::vector<double> point;
  for (const int v : problem.robot.variables)
    point.push_back(problem.start[static_cast<std::size_t>(v)]);
  return point;
}

double angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return 2 * std::asin(std::min(1.0, (a - b).norm() / std::sqrt(8)));
}

/// Samples of the first step: the frame as near to its place as the result says, and this within
/// the tolerances. `at`: the frame's pose at a place, computed by the test.
template <class At>
void expectFollows(const Problem& problem, const PlanResult& result, const At& at) {
  const auto& line = std::get<LineStep>(problem.steps[0].action);
  const PathStep& step = result.path.steps.at(0);
  ASSERT_EQ(step.places.size(), static_cast<std::size_t>(step.last - step.first) + 1);
  const LineWay way = lineWay(problem, line, linksAt(problem, result.path.positions.front()));
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  std::vector<double> q(static_cast<std::size_t>(space.size()));
  double off = 0, turn = 0;
  for (std::size_t i = 0; i + 1 < step.places.size(); ++i)
    for (int k = 0; k <= 400; ++k) {
      const double t = k / 400.0;
      space.interpolate(result.path.positions[i], result.path.positions[i + 1], t, q);
      const Pose X_WF = linksAt(problem, q)[static_cast<std::size_t>(way.link)] * way.X_LF;
      const Pose X_WP = at(step.places[i] + t * (step.places[i + 1] - step.places[i]));
      off = std::max(off, (X_WF.translation - X_WP.translation).norm());
      turn = std::max(turn, angleBetween(X_WF.rotation, X_WP.rotation));
    }
  EXPECT_LE(off, step.deviation);
  EXPECT_LE(turn, step.turn + 1e-7);  // rounding of the test's angle
  EXPECT_GT(off, 0.02 * step.deviation);
  EXPECT_LE(step.deviation, line.position_tolerance);
  EXPECT_LE(step.turn, line.angle_tolerance);
}

TEST(LineWay, ArcsGoThroughTheirPointAndTurnsAreConstant) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write(
      "way.yaml", arm("arm6", "start: ready\nwaypoints: {frame: tool, by: [0, 0, 1]}\n")));
  const std::vector<Pose> X_WL =
      linksAt(problem, std::vector<double>(problem.start.begin(), problem.start.end()));
  Random random(5);
  for (int c = 0; c < 2000; ++c) {
    const auto any = [&] {
      return Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    };
    double xyzw[4];
    random.quaternion(xyzw);
    LineStep line;
    line.frame = "tool";
    const Waypoint first{any()};
    Waypoint second{any()};
    second.rotation =
        Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).normalized().toRotationMatrix();
    second.via = any();
    line.poses = {first, second};
    LineWay way;
    try {
      way = lineWay(problem, line, X_WL);
    } catch (const std::invalid_argument&) {
      continue;  // half a turn
    }
    ASSERT_EQ(way.size(), 2);
    const Pose begin = way.at(1), end = way.at(2);
    EXPECT_LT((begin.translation - first.position).norm(), 1e-12);
    EXPECT_LT((end.translation - second.position).norm(), 1e-8);
    EXPECT_LT((end.rotation - *second.rotation).norm(), 1e-12);
    // Somewhere on the arc is the point that it goes through; all of it is as far from the centre.
    const WayStretch& arc = way.stretches[1];
    double nearest = 1e9, length = 0;
    Pose last = begin;
    for (int k = 1; k <= 2000; ++k) {
      const Pose X = way.at(1 + k / 2000.0);
      nearest = std::min(nearest, (X.translation - *second.via).norm());
      length += (X.translation - last.translation).norm();
      last = X;
    }
    EXPECT_LT(nearest, arc.length() / 2000);
    EXPECT_NEAR(length, arc.length(), 1e-5 * arc.length());
    // Bounds of the departure from chords.
    const double share = random.uniform(0, 0.9), part = random.uniform(0, 1 - share);
    const Pose a = arc.at(share), b = arc.at(share + part);
    const ChordDeparture bound = arc.departure(part);
    for (int k = 0; k <= 20; ++k) {
      const double t = k / 20.0;
      const Pose X = arc.at(share + t * part);
      EXPECT_LE((X.translation - (1 - t) * a.translation - t * b.translation).norm(),
                bound.origin + 1e-12);
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_LE((X.rotation.col(axis) - (1 - t) * a.rotation.col(axis) - t * b.rotation.col(axis))
                      .norm(),
                  bound.tips + 1e-12);
    }
    EXPECT_NEAR(angleBetween(way.at(1.25).rotation, way.at(1.5).rotation), arc.turn / 4, 1e-7);
  }
}

struct ArmWay {
  const char *name, *way;
};
void PrintTo(const ArmWay& way, std::ostream* out) { *out << way.name; }

constexpr ArmWay kWays[] = {{"arm6",
                             "start: ready\nwaypoints:\n  frame: tool\n  poses:\n"
                             "    - {position: [0.35, 0.2, 0.35], rpy: [-1.4, 0.1, 1.4]}\n"
                             "    - {position: [0.35, -0.05, 0.35]}\n"
                             "    - {position: [0.3, -0.05, 0.4], via: [0.3, -0.08, 0.36]}\n"
                             "    - {position: [0.35, 0.1, 0.4], rpy: [-1.7, 0, 1.7]}\n"},
                            {"arm7",
                             "start: ready\nwaypoints:\n  frame: hand\n  poses:\n"
                             "    - {position: [0.5, 0.1, 0.45], rpy: [3, 0.1, 3]}\n"
                             "    - {position: [0.5, -0.1, 0.45]}\n"
                             "    - {position: [0.45, -0.1, 0.45], via: [0.47, -0.13, 0.48]}\n"
                             "    - {position: [0.5, 0, 0.5], rpy: [2.9, 0, 2.6]}\n"}};

class Arms : public testing::TestWithParam<ArmWay> {};

TEST_P(Arms, GoThroughPosesWithArcsAndTurns) {
  const Folder folder;
  const Problem problem =
      loadProblem(folder.write("way.yaml", arm(GetParam().name, GetParam().way)));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_FALSE(result.line_end);
  EXPECT_TRUE(result.certificate.certified);
  const auto& line = std::get<LineStep>(problem.steps[0].action);
  const LineWay way = lineWay(problem, line, linksAt(problem, result.path.positions.front()));
  expectFollows(problem, result, [&](double place) { return way.at(place); });
  // Its poses are reached, to what kinematics give.
  const PathStep& step = result.path.steps[0];
  for (std::size_t k = 0; k < line.poses.size(); ++k) {
    const auto found =
        std::find(step.places.begin(), step.places.end(), static_cast<double>(k + 1));
    ASSERT_NE(found, step.places.end());
    const auto row = static_cast<std::size_t>(found - step.places.begin());
    const Pose X_WF =
        linksAt(problem, result.path.positions[row])[static_cast<std::size_t>(way.link)] * way.X_LF;
    EXPECT_LT((X_WF.translation - line.poses[k].position).norm(), 1e-7);
    if (line.poses[k].rotation) {
      EXPECT_LT((X_WF.rotation - *line.poses[k].rotation).norm(), 1e-7);
    }
  }
  EXPECT_EQ(planTask(problem).path.positions, result.path.positions);

  for (const char* ending : {"path.json", "path.yaml"}) {
    const std::string file = folder.write(ending, "");
    writePath(file, problem, result);
    const Path read = readPath(file, problem);
    EXPECT_EQ(read.steps.at(0).places, step.places);
    const VerifyResult verified = verify(problem, read);
    EXPECT_EQ(verified.status, VerifyStatus::kCertified) << verified.reason;
  }

  // Places that are missing, go back, pass a pose, or say another time: not certified.
  const auto status = [&](const auto& change) {
    Path path = result.path;
    change(path.steps[0].places);
    return verify(problem, path).status;
  };
  using Places = std::vector<double>;
  EXPECT_EQ(status([](Places& p) { p.clear(); }), VerifyStatus::kRefuted);
  EXPECT_EQ(status([](Places& p) { p[1] = -0.1; }), VerifyStatus::kRefuted);
  EXPECT_EQ(status([](Places& p) { p[0] = 0.1; }), VerifyStatus::kRefuted);
  EXPECT_EQ(status([](Places& p) { p[1] = std::nan(""); }), VerifyStatus::kRefuted);
  EXPECT_EQ(status([](Places& p) { p.back() = 5; }), VerifyStatus::kRefuted);
  EXPECT_EQ(status([](Places& p) { p.back() = 3.9; }), VerifyStatus::kRefuted);
  EXPECT_EQ(status([](Places& p) { *std::find(p.begin(), p.end(), 2.0) = 2.01; }),
            VerifyStatus::kRefuted);
  Path bent = result.path;
  const auto gone =
      std::find(step.places.begin(), step.places.end(), 1.0) - step.places.begin() - 1;
  bent.positions.erase(bent.positions.begin() + 1, bent.positions.begin() + 1 + gone);
  bent.steps[0].places.erase(bent.steps[0].places.begin() + 1,
                             bent.steps[0].places.begin() + 1 + gone);
  bent.steps[0].last -= static_cast<int>(gone);
  EXPECT_NE(verify(problem, bent).status, VerifyStatus::kCertified);
  Path moved = result.path;
  moved.positions[2][5] += 0.02;
  EXPECT_EQ(verify(problem, moved).status, VerifyStatus::kRefuted);
}

INSTANTIATE_TEST_SUITE_P(Shipped, Arms, testing::ValuesIn(kWays),
                         [](const auto& name) { return std::string(name.param.name); });

TEST(Line, TurnsInItsOwnAxesOrThoseOfTheWorld) {
  const Folder folder;
  for (const char* axes : {"", ", relative_to: world"})
    for (const char* by : {"by: [0, 0, 0.05], ", ""}) {
      const Problem problem = loadProblem(folder.write(
          "turn.yaml", arm("arm6", std::string("start: ready\nsteps:\n  - line: {frame: tool, ") +
                                       by + "rpy: [0.2, 0, 0.4]" + axes + "}\n")));
      const PlanResult result = planTask(problem);
      ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
      const auto link = static_cast<std::size_t>(problem.robot.model->findLink("tool"));
      const Pose first = linksAt(problem, result.path.positions.front())[link];
      const Pose last = linksAt(problem, result.path.positions.back())[link];
      const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
      const Eigen::Vector3d way(0, 0, *by == '\0' ? 0 : 0.05);
      const bool own = *axes == '\0';
      EXPECT_LT((last.rotation - (own ? first.rotation * turn : turn * first.rotation)).norm(),
                1e-7);
      EXPECT_LT((last.translation - first.translation - (own ? first.rotation * way : way)).norm(),
                1e-7);
      EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
    }
}

TEST(Line, RepeatedPosesStayWhereTheyAre) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write(
      "way.yaml", arm("arm6",
                      "start: ready\nwaypoints: {frame: tool, poses: [{position: [0.45, 0, 0.4]}, "
                      "{position: [0.45, 0, 0.4]}, {position: [0.45, 0.05, 0.4]}]}\n")));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
}

/// A line that cannot be had whole.
struct Short {
  const char* what;
  const char* problem;
  LineEnd::Why why;
  int waypoint;
};
void PrintTo(const Short& line, std::ostream* out) { *out << line.what; }

class EndsEarly : public testing::TestWithParam<Short> {};

TEST_P(EndsEarly, WithItsPartItsPlaceAndTheReason) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write("way.yaml", arm("arm6", GetParam().problem)));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kPartial) << result.reason;
  ASSERT_TRUE(result.line_end);
  const LineEnd& end = *result.line_end;
  EXPECT_EQ(end.why, GetParam().why) << end.text;
  EXPECT_EQ(end.waypoint, GetParam().waypoint) << end.text;
  EXPECT_EQ(end.step, static_cast<int>(result.path.steps.size()) - 1);
  EXPECT_NE(result.reason.find(end.text), std::string::npos);
  const PathStep& step = result.path.steps.back();
  EXPECT_EQ(step.places.back(), end.waypoint + end.share);
  EXPECT_EQ(step.last + 1, static_cast<int>(result.path.positions.size()));
  EXPECT_EQ(result.certificate.segments.size() + 1, result.path.positions.size());
  EXPECT_TRUE(result.certificate.certified);
  // The part is not the answer, but good as far as it goes.
  const VerifyResult verified = verify(problem, result.path);
  EXPECT_EQ(verified.status, VerifyStatus::kRefuted);
  EXPECT_NE(verified.reason.find("ends early"), std::string::npos) << verified.reason;
  EXPECT_NE(verified.reason.find("certified"), std::string::npos) << verified.reason;
  Path moved = result.path;
  moved.positions[at(step.first) + 1][5] += 0.05;
  EXPECT_EQ(verify(problem, moved).reason.find("ends early"), std::string::npos);
  // The same problem gives the same bytes.
  EXPECT_EQ(planTask(problem).path.positions, result.path.positions);
}

constexpr Short kShort[] = {
    {"Reach",
     "start: ready\nwaypoints: {frame: tool, poses: [{position: [0.45, 0.1, 0.4]}, {position: [2, "
     "0.1, 0.4]}]}\n",
     LineEnd::Why::kSingularity, 1},
    {"Collision",
     "objects: [{name: wall, position: [0.45, 0.35, 0.4], box: {size: [0.2, 0.02, 0.2]}}]\nstart: "
     "ready\nwaypoints: {frame: tool, poses: [{position: [0.45, 0, 0.4]}, {position: [0.45, 0.1, "
     "0.4]}, {position: [0.45, 0.5, 0.4]}]}\n",
     LineEnd::Why::kCollision, 2},
    {"Limit",
     "start: {pan_joint: 0, lift_joint: -1.9, elbow_joint: 1.9, wrist1_joint: -1.5708, "
     "wrist2_joint: -1.5708, wrist3_joint: 6}\nwaypoints: {frame: tool, rpy: [0, 0, 1]}\n",
     LineEnd::Why::kLimit, 0},
    {"BehindAMove",
     "start: home\nsteps:\n  - move: ready\n  - line: {frame: tool, poses: [{position: [0.45, 0.1, "
     "0.4]}, {position: [2, 0.1, 0.4]}]}\n  - move: home\n",
     LineEnd::Why::kSingularity, 1},
    {"BehindAMoveToAPose",
     "start: home\nsteps:\n  - move: {pose: {frame: tool, position: [0.45, 0.1, 0.4], rpy: "
     "[3.141592653589793, 0, 0]}}\n  - line: {frame: tool, by: [2, 0, 0], relative_to: world}\n",
     LineEnd::Why::kSingularity, 0},
};

INSTANTIATE_TEST_SUITE_P(Line, EndsEarly, testing::ValuesIn(kShort),
                         [](const auto& name) { return std::string(name.param.what); });

TEST(Line, GoesOnUntilJustBeforeAContact) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write("way.yaml", arm("arm6", kShort[1].problem)));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kPartial);
  // The gap to the wall is less than a thousandth of the way, which is 0.4 m long.
  EXPECT_LT(result.certificate.clearance.lower, 0.4e-3);
  EXPECT_GE(result.certificate.clearance.lower, 0);
}

TEST(Line, ThatCannotBeginLeavesNoPath) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write(
      "way.yaml",
      arm("arm6",
          "start: [0, -1.9, 1.9, -1.5708, -1.5708, 6.28319]\nwaypoints: {frame: tool, rpy: "
          "[0, 0, 1]}\n")));
  const PlanResult result = planTask(problem);
  EXPECT_EQ(result.status, PlanStatus::kUnsolved);
  ASSERT_TRUE(result.line_end);
  EXPECT_EQ(result.line_end->share, 0);
  EXPECT_EQ(result.line_end->why, LineEnd::Why::kLimit) << result.line_end->text;
  EXPECT_TRUE(result.path.positions.empty());
}

TEST(Line, StartsWhereItGoesOnLongest) {
  const Folder folder;
  // From the nearest joint values the wrist reaches its limit; a whole turn back it does not.
  const std::string text = arm(
      "arm6",
      "start: {pose: {frame: tool, position: [0.45, 0.1, 0.4], rpy: [3.141592653589793, 0, 0]}}\n"
      "waypoints:\n  frame: tool\n  poses:\n"
      "    - {position: [0.45, 0.1, 0.4], rpy: [3.141592653589793, 0, 2]}\n"
      "    - {position: [0.45, 0.1, 0.4], rpy: [3.141592653589793, 0, 4]}\n"
      "    - {position: [0.45, 0.1, 0.4], rpy: [3.141592653589793, 0, 6]}\n"
      "    - {position: [0.45, 0.1, 0.4], rpy: [3.141592653589793, 0, 8]}\n");
  const Problem problem = placeStart(loadProblem(folder.write("way.yaml", text)));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
}

// A seven-joint arm that keeps its elbow as it is gets no further than the wall of a limit; it may
// swing the elbow.
TEST(Line, MovesJointsThatItLeavesFree) {
  const Problem problem =
      placeStart(loadProblem(leeway::sourceFolder() + "/problems/constrained/wipe.yaml"));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
}

/// A line that is stopped is the part that there is by then, and says so.
TEST(Line, EndsWhereItsCallerSaysSo) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write(
      "way.yaml",
      arm("arm6",
          "start: ready\nwaypoints: {frame: tool, poses: [{position: [0.45, 0, 0.4]}, {position: "
          "[0.45, 0.1, 0.4]}, {position: [0.45, -0.1, 0.4]}, {position: [0.45, 0.1, 0.45]}]}\n")));
  int calls = 0;
  PlanOptions options;
  options.stop = [&] { return ++calls > 5; };
  const PlanResult result = planTask(problem, options);
  ASSERT_EQ(result.status, PlanStatus::kPartial) << result.reason;
  ASSERT_TRUE(result.line_end);
  EXPECT_EQ(result.line_end->why, LineEnd::Why::kStopped) << result.line_end->text;
  EXPECT_STREQ(toString(result.line_end->why), "stopped");
  EXPECT_NE(result.reason.find("the time limit was reached, or the search was stopped"),
            std::string::npos)
      << result.reason;
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_LT(calls, 20);
}

/// And so is the search for the start from which a line goes on longest.
TEST(Line, TheSearchForItsStartCanBeStopped) {
  const Problem problem = loadProblem(leeway::sourceFolder() + "/problems/constrained/wipe.yaml");
  int calls = 0;
  const Problem placed = placeStart(problem, [&] { return ++calls > 3; });
  EXPECT_TRUE(placed.start_poses.empty());
  EXPECT_LT(calls, 20);
}

/// On the trajectory the frame is never faster than the line's speed, and nearly as fast.
TEST(Line, KeepsItsSpeed) {
  const Folder folder;
  for (const char* speed : {"", "speed: 0.05, "}) {
    const Problem problem = loadProblem(folder.write(
        "way.yaml",
        arm("arm6", std::string("start: ready\nwaypoints: {") + speed +
                        "frame: tool, poses: [{position: [0.45, 0.1, 0.4]}, {position: [0.45, "
                        "-0.1, 0.4], via: [0.52, 0, 0.4]}]}\n")));
    const PlanResult result = planTask(problem);
    ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
    const Trajectory trajectory = trajectoryOf(problem, result.path);
    const auto link = static_cast<std::size_t>(problem.robot.model->findLink("tool"));
    double fastest = 0;
    const int samples = 20000;
    std::vector<double> q(6);
    Eigen::Vector3d last;
    for (int k = 0; k <= samples; ++k) {
      trajectory.configuration(trajectory.duration() * k / samples, q);
      const Eigen::Vector3d p = linksAt(problem, q)[link].translation;
      if (k > 0) fastest = std::max(fastest, (p - last).norm() * samples / trajectory.duration());
      last = p;
    }
    if (*speed == '\0') {
      EXPECT_GT(fastest, 0.1);
    } else {
      EXPECT_LE(fastest, 0.05 * (1 + 1e-9));
      EXPECT_GT(fastest, 0.045);
    }
  }
}

/// The trajectory of a line does not rest at its waypoints, is at no time farther from the line
/// than the tolerances, and keeps the limits at 20,000 times.
TEST(Line, IsFollowedWithoutStops) {
  for (const char* shipped : {"wipe", ""}) {
    const Folder folder;
    const std::string file =
        *shipped != '\0'
            ? leeway::sourceFolder() + "/problems/constrained/" + shipped + ".yaml"
            : folder.write("way.yaml",
                           arm("arm6",
                               "start: ready\nwaypoints: {speed: 0.2, frame: tool, poses: "
                               "[{position: [0.45, 0.1, 0.4]}, {position: [0.45, -0.1, 0.4], via: "
                               "[0.52, 0, 0.4]}], position_tolerance: 0.002}\n"));
    Problem problem = placeStart(loadProblem(file), {});
    for (const int v : problem.robot.variables)
      problem.execution.jerks[problem.robot.model->variables[static_cast<std::size_t>(v)].name] =
          40;
    const PlanResult result = planTask(problem);
    ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
    const Trajectory trajectory = trajectoryOf(problem, result.path);
    problem.execution.corners = Corners::kStop;
    const double stopping = trajectoryOf(problem, result.path).duration();
    const std::size_t corners = result.path.positions.size() - 2;
    EXPECT_GT(trajectory.cutCorners().size(), corners / 2) << file;
    EXPECT_TRUE(trajectory.cuts().left_out.empty());
    // A bound on the speed of the tool is kept on blends by a coarse bound.
    EXPECT_LT(trajectory.duration(), (*shipped != '\0' ? 0.65 : 0.95) * stopping) << file;
    const auto& line = std::get<LineStep>(problem.steps[0].action);
    const LineWay way = lineWay(problem, line, linksAt(problem, result.path.positions.front()));
    std::vector<Pose> places;
    constexpr int kParts = 2000;
    for (int k = 0; k <= kParts * static_cast<int>(way.size()); ++k)
      places.push_back(way.at(static_cast<double>(k) / kParts));
    const MotionLimits limits = motionLimits(problem);
    const int samples = 20000;
    const double h = trajectory.duration() / samples;
    std::vector<std::vector<double>> rows;
    std::size_t near = 0;  // the place nearest to the frame, which goes on with it
    double speed = 0;
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    for (int k = 0; k <= samples; ++k) {
      rows.emplace_back(limits.velocity.size());
      trajectory.configuration(k * h, rows.back());
      const Pose X_WF =
          linksAt(problem, rows.back())[static_cast<std::size_t>(way.link)] * way.X_LF;
      const auto off = [&](std::size_t i) {
        return (X_WF.translation - places[i].translation).norm() +
               0.1 * (X_WF.rotation - places[i].rotation).norm();
      };
      for (std::size_t i = near; i < std::min(places.size(), near + 40); ++i)
        if (off(i) < off(near)) near = i;
      // Places are up to 0.15 mm apart.
      EXPECT_LE((X_WF.translation - places[near].translation).norm(),
                line.position_tolerance + 2e-4);
      EXPECT_LE(angleBetween(X_WF.rotation, places[near].rotation), line.angle_tolerance + 1e-3);
      if (k > 0) speed = std::max(speed, (X_WF.translation - last).norm() / h);
      last = X_WF.translation;
    }
    EXPECT_EQ(near, places.size() - 1);
    EXPECT_LE(speed, line.speed * (1 + 1e-9));
    for (std::size_t i = 0; i < limits.velocity.size(); ++i)
      for (std::size_t k = 3; k < rows.size(); ++k) {
        const double a = rows[k - 3][i], b = rows[k - 2][i], c = rows[k - 1][i], d = rows[k][i];
        ASSERT_LE(std::abs(d - c) / h, limits.velocity[i] * (1 + 1e-9) + 4e-15 / h);
        ASSERT_LE(std::abs(d - 2 * c + b) / (h * h),
                  limits.acceleration[i] * (1 + 1e-9) + 8e-15 / (h * h));
        ASSERT_LE(std::abs(d - 3 * c + 3 * b - a) / (h * h * h),
                  limits.jerk[i] * (1 + 1e-9) + 2e-14 / (h * h * h));
      }
  }
}

/// A file of a line's trajectory is proven as it is executed; one that is damaged is not.
TEST(Line, ItsTrajectoryIsVerified) {
  const Folder folder;
  const std::string ways[] = {
      "speed: 0.05, frame: tool, poses: [{position: [0.45, 0.1, 0.4]}, {position: [0.45, -0.1, "
      "0.4], via: [0.52, 0, 0.4]}]",
      "speed: 0.2, frame: tool, poses: [{position: [0.45, 0.1, 0.4]}, {position: [0.45, -0.1, "
      "0.4]}, {position: [0.5, -0.1, 0.5]}], position_tolerance: 0.003",
      "frame: tool, by: [0, 0, -0.1], rpy: [0, 0, 0.8]"};
  for (const std::string& way : ways)
    for (const char* jerks : {"", "execution: {jerks: 40}\n"}) {
      const std::string text = std::string("start: ready\n") + jerks + "waypoints: {" + way + "}\n";
      const Problem problem = loadProblem(folder.write("way.yaml", arm("arm6", text)));
      const PlanResult result = planTask(problem);
      ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
      const Trajectory trajectory = trajectoryOf(problem, result.path);
      const VerifyResult proof = verify(problem, motionOf(trajectory));
      ASSERT_EQ(proof.status, VerifyStatus::kCertified) << text << proof.reason;
      EXPECT_LE(proof.clearance_lower, result.certificate.clearance.upper);
      Path read;
      for (const char* file : {"t.json", "t.yaml"}) {
        writeTrajectory(folder.write(file, ""), problem, result, trajectory, 0.01);
        read = readPath(folder.path(file), problem, {.cubics = true});
        const VerifyResult again = verify(problem, read);
        EXPECT_EQ(again.status, VerifyStatus::kCertified) << text << again.reason;
      }
      ASSERT_EQ(read.steps.size(), 1U);
      ASSERT_EQ(read.steps[0].places.size(), read.times.size());
      const auto expectNotProven = [&](const Path& damaged, const char* what, const char* reason) {
        const VerifyResult verdict = verify(problem, damaged);
        EXPECT_NE(verdict.status, VerifyStatus::kCertified) << what;
        EXPECT_NE(verdict.reason.find(reason), std::string::npos) << what << verdict.reason;
      };
      const std::size_t middle = read.times.size() / 2;
      Path aside = read;
      aside.positions[middle][0] += 0.02;
      expectNotProven(aside, "a row aside", "");
      Path early = read;  // the frame is where it should be some rows later
      for (std::size_t i = 0; i < middle; ++i) early.steps[0].places[i] *= 0.8;
      expectNotProven(early, "places that lag behind", "from its line");
      Path back = read;
      std::swap(back.steps[0].places[middle], back.steps[0].places[middle + 1]);
      expectNotProven(back, "places that go back", "do not go along its line");
      Path bare = read;
      bare.velocities.pop_back();
      expectNotProven(bare, "a row without velocities", "row");
      const auto& line = std::get<LineStep>(problem.steps[0].action);
      if (!std::isfinite(line.speed)) continue;
      Problem slower = problem;
      std::get<LineStep>(slower.steps[0].action).speed = 0.8 * line.speed;
      const VerifyResult fast = verify(slower, read);
      if (way[7] != '2') {  // blends keep theirs by a coarse bound
        EXPECT_EQ(fast.status, VerifyStatus::kRefuted);
        EXPECT_NE(fast.reason.find("faster than its speed"), std::string::npos) << fast.reason;
      }
      Path hasty = read;
      for (std::size_t i = 0; i < hasty.times.size(); ++i) {
        hasty.times[i] /= 1.5;
        for (double& v : hasty.velocities[i]) v *= 1.5;
      }
      Problem strong = problem;  // only the frame's speed is exceeded
      strong.execution.speed = 1;
      EXPECT_NE(verify(strong, hasty).status, VerifyStatus::kCertified);
    }
}

TEST(Line, FilesOfPoses) {
  const Folder folder;
  std::vector<std::string> warnings;
  const std::string rows = "0.45 0 0.4 1 0 0 0\n0.45 0.1 0.4 0.6 0.8 0 0\n";
  const std::string list =
      "[{\"position\": [0.45, 0, 0.4], \"orientation\": [1, 0, 0, 0]},\n {\"position\": [0.45, "
      "0.1, "
      "0.4], \"orientation\": [0.6, 0.8, 0, 0]}]";
  for (const auto& [name, text] :
       {std::pair<const char*, std::string>{"named.csv",
                                            "qx,qy,qz,qw,x,y,z\n1,0,0,0,0.45,0,0.4\r\n# note\n0.6,"
                                            "0.8,0,0,0.45,0.1,0.4\n"},
        {"plain.csv", rows},
        {"comment.csv",
         "# qw qx qy qz z y x\n# by hand\n0 1 0 0 0.4 0 0.45\n"
         "0 0.6 0.8 0 0.4 0.1 0.45\n"},
        {"list.json", list},
        {"list.yaml", list},
        {"map.yaml", "{frame: tool, poses: list.json}"}}) {
    const std::string file = folder.write(name, text);
    const LineStep line =
        loadWaypoints(file, std::string(name) == "map.yaml" ? "" : "tool", warnings);
    ASSERT_EQ(line.poses.size(), 2U) << name;
    EXPECT_EQ(line.frame, "tool");
    EXPECT_EQ(line.poses[1].position, Eigen::Vector3d(0.45, 0.1, 0.4)) << name;
    ASSERT_TRUE(line.poses[1].rotation) << name;
    EXPECT_LT(
        (*line.poses[1].rotation - Eigen::Quaterniond(0, 0.6, 0.8, 0).toRotationMatrix()).norm(),
        1e-15)
        << name;
  }
  EXPECT_TRUE(warnings.empty());
  EXPECT_FALSE(
      loadWaypoints(folder.write("xyz.csv", "x;y;z\n1;2;3\n"), "tool", warnings).poses[0].rotation);
  const LineStep turned = loadWaypoints(
      folder.write("rpy.csv", "x,y,z,roll,pitch,yaw\n1,2,3,0,0,1\n"), "tool", warnings);
  EXPECT_LT((*turned.poses[0].rotation -
             Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ()).toRotationMatrix())
                .norm(),
            1e-15);
  loadWaypoints(folder.write("long.csv", "1 2 3 1.00001 0 0 0\n"), "tool", warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("long.csv:1"), std::string::npos) << warnings[0];
  loadWaypoints(folder.write("open.csv", "x,y,z\n1,2,3\n1,2,3.2"), "tool", warnings);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[1].find("open.csv:3: the last line does not end"), std::string::npos);

  const struct {
    const char *name, *text, *frame;
    int line;
    const char* message;
  } bad[] = {
      {"a.csv", "", "tool", 0, "has no pose"},
      {"b.csv", "x,y,z\n", "tool", 0, "has no pose"},
      {"c.csv", "x,y,z\n1,2\n", "tool", 2, "the line has 2 columns; 3"},
      {"d.csv", "x,y,z\n1,2,nan\n", "tool", 2, "'nan' stands where a finite number is expected"},
      {"e.csv", "x,y,w\n1,2,3\n", "tool", 1, "the columns are x, y, w; x, y, z"},
      {"f.csv", "1 2 3 4\n", "tool", 1, "the row has 4 numbers"},
      {"g.csv", "1 2 3 1 1 0 0\n", "tool", 1, "a quaternion of length 1.414"},
      {"h.csv", "x,y,z,qx,qy,qz,qw,roll,pitch,yaw\n1,2,3,0,0,0,1,0,0,0\n", "tool", 1,
       "the columns are"},
      {"i.csv", "1 2 3\n", "", 0, "does not say which frame"},
      {"m.csv", "# poses: x, y, z, qw, qx, qy, qz\n1 2 3 1 0 0 0\n", "tool", 1, "seems to name"},
      {"n.csv", "#x,y,z,qw,qx,qy,qz [m]\n# made by hand\n1 2 3 1 0 0 0\n", "tool", 3,
       "the columns are"},
      {"o.csv", "# x y z qx qy qz w\n1 2 3 1 0 0 0\n", "tool", 2, "the columns are"},
      {"j.txt", "1 2 3\n", "tool", 0, "the ending '.txt' names no format of poses"},
      {"k.yaml", "[]", "tool", 1, "has no pose"},
      {"l.yaml", "[{position: [1, 2, 3], rpi: [0, 0, 0]}]", "tool", 1, "did you mean 'rpy'?"},
      {"m.yaml", "{frame: tool, poses: [{position: [1, 2, 3]}]}", "hand", 1,
       "the file names its frame itself"},
      {"n.yaml", "m.yaml", "tool", 1, "list"},
      {"o.csv", "x,x,y,z\n1,1,2,3\n", "tool", 1, "the columns are"},
  };
  for (const auto& c : bad) try {
      loadWaypoints(folder.write(c.name, c.text), c.frame, warnings);
      ADD_FAILURE() << "accepted: " << c.name;
    } catch (const robots::InputError& error) {
      EXPECT_EQ(error.line(), c.line) << error.what();
      EXPECT_NE(std::string(error.what()).find(c.message), std::string::npos) << error.what();
    }
}

TEST(Line, BadWaysAreRefusedWithTheirLine) {
  const Folder folder;
  const struct {
    const char* way;
    int line;
    const char* message;
  } bad[] = {
      {"waypoints: {frame: tool}\n", 4, "goes nowhere"},
      {"waypoints: {frame: tol, by: [0, 0, 1]}\n", 4, "did you mean 'tool'?"},
      {"waypoints: {frame: tool, by: [0, 0, 1], poses: [{position: [1, 0, 0]}]}\n", 4,
       "has 'poses' and 'by'"},
      {"waypoints: {frame: tool, rpy: [0, 0, 1], poses: [{position: [1, 0, 0]}]}\n", 4,
       "has 'poses' and 'a rotation'"},
      {"waypoints: {frame: tool, poses: []}\n", 4, "has no pose"},
      {"waypoints:\n  frame: tool\n  poses:\n    - {rpy: [0, 0, 1]}\n", 7, "'position'"},
      {"waypoints:\n  frame: tool\n  poses:\n    - {position: [1, 0, 0], orientation: [0, 0, 0, "
       "2]}\n",
       7, "length 2"},
      {"waypoints:\n  frame: tool\n  poses:\n    - {position: [1, 0, 0], vai: [0, 0, 0]}\n", 7,
       "did you mean 'via'?"},
      {"waypoints: {frame: tool, poses: [{position: [1e7, 0, 0]}]}\n", 4, "poses[0].position is"},
      {"waypoints: {frame: tool, poses: none.csv}\n", 0, "none.csv"},
      {"waypoints: {frame: tool, by: [0, 0, 1]}\ngoal: home\n", 4, "stands beside 'goal'"},
      {"steps: [{move: home}]\nwaypoints: {frame: tool, by: [0, 0, 1]}\n", 4,
       "stands beside 'waypoints'"},
      {"waypoints: {frame: tool, by: [0, 0, 0]}\n", 4, "is of no length"},
      {"waypoints: {frame: tool, relative_to: too, poses: [{position: [1, 0, 0]}]}\n", 4,
       "no object, link or frame 'too'"},
      // Half a turn has no axis that is nearest; an arc needs a point beside its chord.
      {"waypoints: {frame: tool, poses: [{position: [0.45, 0, 0.4], rpy: [3, 0, 0]}, {position: "
       "[0.45, 0.1, 0.4], rpy: [-0.14159265358979312, 0, 0]}]}\n",
       4, "poses[1] is half a turn"},
      {"waypoints: {frame: tool, poses: [{position: [0.45, 0, 0.4], rpy: [3, 0, 0]}, {position: "
       "[0.45, 0.1, 0.4]}, {position: [0.45, 0, 0.4], rpy: [-0.14159265358979312, 0, 0]}]}\n",
       4, "poses[2] is half a turn"},
      {"waypoints: {frame: tool, by: [0, 0, 0.1], rpy: [0, 3.141592653589793, 0]}\n", 4,
       "turn is half a turn"},
      {"waypoints: {frame: tool, poses: [{position: [0.45, 0, 0.4]}, {position: [0.45, 0.1, 0.4], "
       "via: [0.45, 0.05, 0.4]}]}\n",
       4, "poses[1]: via (0.45, 0.05, 0.4) is on one line"},
      {"steps: [{move: home}, {line: {frame: tool, poses: [{position: [0.45, 0, 0.4]}, {position: "
       "[0.45, 0.1, 0.4], via: [0.45, 0.05, 0.4]}]}}]\n",
       4, "poses[1]: via (0.45, 0.05, 0.4) is on one line"},
      {"waypoints: {frame: tool, by: [0, 0, 1], speed: 0}\n", 4, "speed is 0; a number above 0"},
      {"waypoints: {frame: tool, by: [0, 0, 1], sped: 1}\n", 4, "did you mean 'speed'?"},
  };
  for (const auto& c : bad) try {
      loadProblem(folder.write("way.yaml", arm("arm6", std::string("start: ready\n") + c.way)));
      ADD_FAILURE() << "accepted: " << c.way;
    } catch (const robots::InputError& error) {
      if (c.line > 0) {
        EXPECT_EQ(error.line(), c.line) << error.what();
      }
      EXPECT_NE(std::string(error.what()).find(c.message), std::string::npos) << error.what();
    }
  // Where a move ends is not known yet.
  EXPECT_NO_THROW(loadProblem(folder.write(
      "way.yaml",
      arm("arm6",
          "start: ready\nsteps: [{move: home}, {line: {frame: tool, poses: [{position: [0.45, 0, "
          "0.4], rpy: [0, 0, 0], via: [0.4, 0, 0.4]}]}}]\n"))));
}

TEST(Line, BadStepsOfAProgramAreRefused) {
  const Folder folder;
  const Problem good = loadProblem(folder.write(
      "way.yaml", arm("arm6", "start: ready\nwaypoints: {frame: tool, by: [0, 0, 0.1]}\n")));
  const auto message = [&](const auto& change) -> std::string {
    Problem problem = good;
    change(std::get<LineStep>(problem.steps[0].action));
    try {
      planTask(problem);
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  // The first stretch begins where the robot stands.
  const LineWay way =
      lineWay(good, std::get<LineStep>(good.steps[0].action), linksAt(good, pointOf(good)));
  const Pose X_WF = way.at(0);
  EXPECT_NE(message([&](LineStep& line) {
              line.by.setZero();
              line.poses = {{X_WF.translation + Eigen::Vector3d(0, 0, 0.2), {}, {}}};
              line.poses[0].via = X_WF.translation + Eigen::Vector3d(0, 0, 0.1);
            }).find("is on one line with the arc's ends"),
            std::string::npos);
  // Regression: rounding decided on the plane of an arc whose ends nearly coincide.
  EXPECT_NE(message([&](LineStep& line) {
              line.by.setZero();
              line.poses = {{X_WF.translation + Eigen::Vector3d(0, 1e-12, 0), {}, {}}};
              line.poses[0].via = X_WF.translation + Eigen::Vector3d(0.05, 0, 0);
            }).find("or two of the three points coincide"),
            std::string::npos);
  EXPECT_NE(message([&](LineStep& line) {
              line.by.setZero();
              line.poses = {{X_WF.translation + Eigen::Vector3d(0, 0, 0.2), {}, {}}};
              line.poses[0].rotation = X_WF.rotation * robots::rotationOf({std::numbers::pi, 0, 0});
            }).find("poses[0] is half a turn"),
            std::string::npos);
  const auto expect = [&](const char* text, const auto& change) {
    const std::string said = message(change);
    EXPECT_NE(said.find(text), std::string::npos) << said;
  };
  expect("both 'by' or a turn and 'poses'", [](LineStep& l) { l.poses = {{{1, 0, 0}}}; });
  expect("turn is at", [](LineStep& l) { l.turn *= 2; });
  expect("poses[0].position is", [](LineStep& l) {
    l.by.setZero();
    l.poses = {{{std::nan(""), 0, 0}}};
  });
  expect("poses[0].via is", [](LineStep& l) {
    l.by.setZero();
    l.poses = {{{1, 0, 0}, {}, Eigen::Vector3d(0, HUGE_VAL, 0)}};
  });
  expect("poses[0].rotation is at", [](LineStep& l) {
    l.by.setZero();
    l.poses = {{{1, 0, 0}, Eigen::Matrix3d::Zero()}};
  });
}

}  // namespace
}  // namespace leeway::planner
