// Goals that are poses: loaded, reached, refused, and verified by independent kinematics.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "leeway/planner/plan.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

using robots::Pose;

std::string arm6(const std::string& goal, const std::string& more = "",
                 const std::string& start = "ready") {
  const std::string folder = leeway::sourceFolder() + "/robots/arm6/arm6.";
  return "leeway: 1\nrobot: {urdf: " + folder + "urdf, srdf: " + folder +
         "srdf, group: arm}\nframes: {tip: {link: tool, position: [0, 0, 0.02]}}\nstart: " + start +
         "\ngoal: " + goal + "\n" + more;
}

Problem load(const std::string& text) {
  const Folder folder;
  return loadProblem(folder.write("problem.yaml", text));
}

/// The pose of a link at a configuration of the planned variables.
Pose linkAt(const Problem& problem, const std::string& link, const std::vector<double>& q) {
  std::vector<double> all = problem.start;
  for (std::size_t i = 0; i < q.size(); ++i)
    all[static_cast<std::size_t>(problem.robot.variables[i])] = q[i];
  std::vector<Pose> X_WL(problem.robot.model->links.size());
  robots::forwardKinematics(*problem.robot.model, all, X_WL);
  return X_WL[static_cast<std::size_t>(problem.robot.model->findLink(link))];
}

TEST(PoseGoal, ExactPoseIsReachedAndVerified) {
  const Problem problem =
      load(arm6("{pose: {frame: tip, position: [0.3, 0.4, 0.3], rpy: [3.1416, 0, 0.5]}}"));
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_EQ(result.goal, 0);
  const Pose X_WT = linkAt(problem, "tool", result.path.positions.back()) *
                    Pose{Eigen::Matrix3d::Identity(), {0, 0, 0.02}};
  EXPECT_LT((X_WT.translation - Eigen::Vector3d(0.3, 0.4, 0.3)).norm(), 1.1e-9);
  const Eigen::Matrix3d wanted = (Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(3.1416, Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
  EXPECT_LT((X_WT.rotation - wanted).norm(), 3e-9);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);

  Path off = result.path;
  off.positions.back()[0] += 1e-6;
  const VerifyResult refuted = verify(problem, off);
  EXPECT_EQ(refuted.status, VerifyStatus::kRefuted);
  EXPECT_NE(refuted.reason.find("none of the problem's goals"), std::string::npos);
}

/// "world" means the world in goals, lines and constraints; objects and frames may not have the
/// name.
TEST(PoseGoal, WorldIsTheWorld) {
  const std::string pose = "{pose: {frame: tip, relative_to: world, position: [0.3, 0.4, 0.3]}}";
  EXPECT_TRUE(load(arm6(pose)).goals[0].poses[0].X_WR.translation.isZero(0));
  const std::string line =
      "steps:\n  - {line: {frame: tip, by: [0, 0, 0.01], relative_to: world}}\n";
  const std::string limit =
      "constraints:\n  - {frame: tip, relative_to: world, axis: [0, 0, 1], angle: 3}\n";
  const std::string named = "objects:\n  - {name: world, box: {size: [1, 1, 1]}, position: ";
  const auto withFrame = [](std::string text) {
    const std::string frames = "frames: {";
    return text.insert(text.find(frames) + frames.size(),
                       "world: {link: base, rpy: [0, 0, 1.57]}, ");
  };
  const std::string steps = arm6("none", line);
  const std::string of_steps = std::string(steps).replace(steps.find("goal: none\n"), 11, "");
  EXPECT_NO_THROW(load(of_steps));
  EXPECT_NO_THROW(load(arm6("stretched", limit)));
  for (const std::string& text :
       {withFrame(arm6(pose)), withFrame(of_steps), withFrame(arm6("stretched", limit)),
        arm6(pose, named + "[5, 0, 0]}\n")}) {
    try {
      load(text);
      ADD_FAILURE() << text;
    } catch (const robots::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("'world' stands for the world and for all objects"),
                std::string::npos)
          << error.what();
    }
  }
}

/// A joint that mimics another is as far out as a planned one may be, at most.
TEST(PoseGoal, JointsThatMimicStayWhereNumbersHaveDigits) {
  const auto urdf = [](const std::string& mimic) {
    return "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"><collision><geometry><sphere "
           "radius=\"0.1\"/></geometry></collision></link><link name=\"c\"><collision><origin "
           "xyz=\"0.5 0 0\"/><geometry><sphere "
           "radius=\"0.1\"/></geometry></collision></link><joint "
           "name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 "
           "1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint><joint "
           "name=\"k\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/><axis xyz=\"0 0 "
           "1\"/><mimic joint=\"j\" " +
           mimic + "/></joint></robot>";
  };
  const auto problem = [&](const std::string& mimic) {
    const Folder folder;
    folder.write("r.urdf", urdf(mimic));
    return loadProblem(folder.write("problem.yaml",
                                    "leeway: 1\nrobot: {urdf: r.urdf, group: [j]}\nstart: [0.4]\n"
                                    "goal: [-0.4]\nobjects:\n  - {name: o, box: {size: [1, 1, 1]}, "
                                    "position: [0, 5, 0]}\n"));
  };
  EXPECT_TRUE(plan(problem("offset=\"900\"")).certificate.certified);
  EXPECT_TRUE(plan(problem("multiplier=\"-2000\"")).certificate.certified);
  for (const char* mimic :
       {"offset=\"1e15\"", "offset=\"-1000\"", "multiplier=\"1e15\"", "multiplier=\"3000\""}) {
    try {
      problem(mimic);
      ADD_FAILURE() << mimic;
    } catch (const robots::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("too"), std::string::npos) << error.what();
    }
  }
}

TEST(PoseGoal, RelativeToAnObjectAnyTurnAboutItsAxis) {
  const std::string goal =
      "{pose: {frame: tip, relative_to: can, position: [0, 0, [0.10, 0.12]], rpy: [3.1416, 0, "
      "any]}}";
  const Problem problem =
      load(arm6(goal,
                "objects:\n  - {name: can, position: [0.4, -0.3, 0.1], rpy: [0, "
                "0, 1], cylinder: {radius: 0.03, length: 0.12}}\n"));
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  const Pose X_WT = linkAt(problem, "tool", result.path.positions.back());
  EXPECT_NEAR(X_WT.translation.x(), 0.4, 1e-5);
  EXPECT_NEAR(X_WT.translation.y(), -0.3, 1e-5);
  EXPECT_GE(X_WT.translation.z(), 0.1 + 0.10 + 0.02 - 1e-8);
  EXPECT_LE(X_WT.translation.z(), 0.1 + 0.12 + 0.02 + 1e-8);
  EXPECT_NEAR(X_WT.rotation(2, 2), -1, 1e-9);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
  EXPECT_EQ(plan(problem).path.positions, result.path.positions);
}

// Further solutions are drawn at the searches' request: the same for any number of threads.
TEST(PoseGoal, DrawnGoalsDoNotDependOnThreads) {
  Problem problem = load(
      arm6("{pose: {frame: tip, position: [0.1, 0.55, [0.25, 0.3]], rpy: [3.1416, 0, any]}}",
           "objects:\n  - {name: wall, position: [0.45, 0.2, 0.4], box: {size: [0.7, 0.02, 0.8]}}\n"
           "  - {name: post, position: [0.05, 0.38, 0.5], box: {size: [0.1, 0.1, 1]}}\n"
           "planner: {name: Connect}\n",
           "{pan_joint: -0.6, lift_joint: -1.2, elbow_joint: 1.4, wrist1_joint: -0.2, "
           "wrist2_joint: 0, wrist3_joint: 0}"));
  problem.limits.time = 200;  // no time limit applies
  std::uint64_t most = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    problem.seed = seed;
    problem.planner.parameters = {{"workers", "5"}, {"threads", "1"}, {"range", "0.02"}};
    const PlanResult alone = plan(problem);
    ASSERT_EQ(alone.status, PlanStatus::kSolved) << alone.reason;
    EXPECT_EQ(verify(problem, alone.path).status, VerifyStatus::kCertified);
    most = std::max(most, alone.iterations);
    for (const char* threads : {"2", "5"}) {
      problem.planner.parameters["threads"] = threads;
      const PlanResult result = plan(problem);
      EXPECT_EQ(result.path.positions, alone.path.positions) << threads;
      EXPECT_EQ(result.iterations, alone.iterations);
      EXPECT_EQ(result.states, alone.states);
      EXPECT_EQ(result.edges, alone.edges);
      EXPECT_EQ(result.distance_queries, alone.distance_queries);
    }
  }
  EXPECT_GT(most, 32u) << "nothing was drawn";
}

TEST(PoseGoal, OutOfReachIsProven) {
  const Problem problem = load(arm6("{pose: {frame: tip, position: [3, 0, 0.3]}}"));
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kInvalidGoal);
  EXPECT_TRUE(result.unreachable);
  EXPECT_NE(result.reason.find("out of reach: proven"), std::string::npos) << result.reason;
}

TEST(PoseGoal, FoundOnesThatCollideNameWhatIsInTheWay) {
  const Problem problem = load(
      arm6("{pose: {frame: tip, position: [0.4, 0, 0.3], rpy: [3.1416, 0, 0]}}",
           "objects: [{name: block, position: [0.4, 0, 0.3], box: {size: [0.2, 0.2, 0.2]}}]\n"));
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kInvalidGoal);
  EXPECT_FALSE(result.unreachable);
  EXPECT_TRUE(result.reason.empty());
  EXPECT_TRUE(result.offending_a == "block" || result.offending_b == "block");
}

TEST(PoseGoal, EveryPlannerTakesThem) {
  Problem problem = load(
      arm6("{pose: {frame: tip, position: [0.3, 0.4, 0.3], rpy: [3.1416, 0, any]}}",
           "objects: [{name: post, position: [0.45, 0.2, 0.5], box: {size: [0.05, 0.05, 1]}}]\n"));
  for (const char* planner : {"RRTConnect", "KPIECE1", "PRM"}) {
    problem.planner.name = planner;
    const PlanResult result = plan(problem);
    ASSERT_EQ(result.status, PlanStatus::kSolved) << planner;
    EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified) << planner;
  }
}

TEST(PoseGoal, AStartIsAPoseToo) {
  Problem problem = load(arm6("ready", "",
                              "{pose: {frame: tool, position: [0.3, 0.3, 0.4], rpy: "
                              "[3.1416, 0, any]}}"));
  EXPECT_THROW(plan(problem), robots::InputError);
  problem = placeStart(problem);
  std::vector<double> start;
  for (const int v : problem.robot.variables)
    start.push_back(problem.start[static_cast<std::size_t>(v)]);
  EXPECT_LT((linkAt(problem, "tool", start).translation - Eigen::Vector3d(0.3, 0.3, 0.4)).norm(),
            1.1e-9);
  EXPECT_EQ(plan(problem).status, PlanStatus::kSolved);
}

TEST(PoseGoal, TwoArmsAtOnce) {
  const std::string folder = leeway::sourceFolder() + "/robots/dual_arm/dual_arm.";
  const std::string head = "leeway: 1\nrobot: {urdf: " + folder + "urdf, srdf: " + folder +
                           "srdf, group: both}\nstart: up\n";
  Problem problem = load(head + "goal: up\n");
  std::vector<double> q;
  for (const auto& range : problem.goals[0].ranges) q.push_back(range.first);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += 0.2;
  Goal goal{"both", {}, {}};
  for (const char* link : {"left_tool", "right_tool"}) {
    const int index = problem.robot.model->findLink(link);
    ASSERT_GE(index, 0) << link;
    goal.poses.push_back(
        robots::PoseRegion::exact(index, Pose(), Pose(), linkAt(problem, link, q)));
  }
  problem.goals = {goal};
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
}

}  // namespace
}  // namespace leeway::planner
