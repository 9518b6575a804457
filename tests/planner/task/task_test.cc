// Tasks of several steps: planned, proven, verified by other means, and refused.
#include "leeway/planner/task.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "leeway/planner/path_io.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

using robots::Pose;

std::string shipped(const char* name) {
  return leeway::sourceFolder() + "/problems/pick_place/" + name;
}

Pose frameAt(const Problem& problem, const std::string& name, const std::vector<double>& q) {
  std::vector<double> all = problem.start;
  for (std::size_t i = 0; i < q.size(); ++i)
    all[static_cast<std::size_t>(problem.robot.variables[i])] = q[i];
  std::vector<Pose> X_WL(problem.robot.model->links.size());
  robots::forwardKinematics(*problem.robot.model, all, X_WL);
  for (const Frame& frame : problem.robot.frames)
    if (frame.name == name) return X_WL[static_cast<std::size_t>(frame.link)] * frame.X_LF;
  ADD_FAILURE() << name;
  return {};
}

/// Ten thousand points of each line: as near to it, and as little turned, as the step asks and the
/// result says.
void expectStraight(const Problem& problem, const Path& path) {
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  std::vector<double> q(static_cast<std::size_t>(space.size()));
  int lines = 0;
  for (std::size_t s = 0; s < problem.steps.size(); ++s) {
    const auto* line = std::get_if<LineStep>(&problem.steps[s].action);
    // Of a held object's frame the pose comes from where it was taken: not known here.
    if (line == nullptr || line->frame == "can" || line->frame == "carton") continue;
    ++lines;
    const PathStep& step = path.steps[s];
    const auto row = [&](int i) { return path.positions[static_cast<std::size_t>(i)]; };
    const Pose first = frameAt(problem, line->frame, row(step.first));
    const Eigen::Vector3d along =
        line->relative_to.empty() ? Eigen::Vector3d(first.rotation * line->by) : line->by;
    double off = 0, turn = 0;
    for (int k = 0; k <= 10000; ++k) {
      const double place = k / 10000.0 * (step.last - step.first);
      const int edge = std::min(static_cast<int>(place), step.last - step.first - 1);
      space.interpolate(row(step.first + edge), row(step.first + edge + 1), place - edge, q);
      const Pose X_WF = frameAt(problem, line->frame, q);
      const Eigen::Vector3d from = X_WF.translation - first.translation;
      off = std::max(off, (from - from.dot(along) / along.squaredNorm() * along).norm());
      turn = std::max(turn, 2 * std::asin((X_WF.rotation - first.rotation).norm() / std::sqrt(8)));
    }
    EXPECT_LE(off, step.deviation) << step.name;
    EXPECT_LE(turn, step.turn) << step.name;
    EXPECT_LE(step.deviation, line->position_tolerance) << step.name;
    EXPECT_LE(step.turn, line->angle_tolerance) << step.name;
    EXPECT_LT(
        (frameAt(problem, line->frame, row(step.last)).translation - first.translation - along)
            .norm(),
        1e-7)
        << step.name;
  }
  EXPECT_GE(lines, 2);
}

/// Regression: where the joints go on in one line, the trajectory passed the place at which an
/// object is attached at full speed.
TEST(Task, TheRobotRestsBetweenSteps) {
  const Folder folder;
  folder.write("slide.urdf", R"(<robot name="s"><link name="base"/>
<link name="car"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/><limit lower="0" upper="2" velocity="1" effort="1"/></joint>
</robot>)");
  const Problem problem = loadProblem(
      folder.write("task.yaml",
                   "leeway: 1\nrobot: {urdf: slide.urdf}\nstart: [0]\nsteps:\n  - move: [0.5]\n"
                   "  - attach: {object: can, link: car}\n  - move: [1]\nobjects:\n"
                   "  - {name: can, position: [0.5, 0.2, 0], box: {size: [0.05, 0.05, 0.05]}}\n"
                   "  - {name: wall, position: [5, 0, 0], box: {size: [0.1, 1, 1]}}\n"));
  PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  const Trajectory trajectory = trajectoryOf(problem, result.path);
  const auto taken = static_cast<std::size_t>(result.path.steps[1].last);
  std::vector<double> x(1);
  trajectory.configuration(trajectory.times()[taken], x);
  EXPECT_EQ(x[0], 0.5);
  trajectory.velocity(trajectory.times()[taken], x);
  EXPECT_EQ(x[0], 0);
  // From rest to rest twice: half a second of each at 2 m/s^2.
  EXPECT_NEAR(trajectory.times()[taken], 1, 1e-9);
  EXPECT_NEAR(trajectory.duration(), 2, 1e-9);
  writePath(folder.path("path.json"), problem, result);
  EXPECT_NE(readText(folder.path("path.json"))
                .find("[0.5], \"time_from_start\": {\"sec\": 1, \"nanosec\": 0}"),
            std::string::npos);
  // Where the steps are not known, neither is where it rests.
  result.path.steps.clear();
  EXPECT_THROW(trajectoryOf(problem, result.path), std::invalid_argument);
}

/// Regressions: a margin of the robot did not hold for what it took hold of where its only link is
/// named "robot", and one of a deforming obstacle where any link is.
TEST(Task, MarginsOfALinkNamedRobotHoldForWhatItHolds) {
  const Folder folder;
  const auto planned = [&](const std::string& margin) {  // the wall is 150 mm from the can's way
    return planTask(loadProblem(folder.write(
                        "task.yaml",
                        "leeway: 1\nbody: {name: robot, joint: planar, bounds: {lower: [-2, -2], "
                        "upper: [2, 2]}, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}\n"
                        "start: [0, 0, 0]\nsteps:\n  - attach: {object: can, link: robot}\n"
                        "  - move: [1, 0, 0]\nobjects:\n"
                        "  - {name: can, position: [0, 0.3, 0], box: {size: [0.05, 0.05, 0.05]}}\n"
                        "  - {name: wall, position: [1, 0.5, 0], box: {size: [0.05, 0.05, 0.05]}}\n"
                        "margins: [{between: [robot, wall], margin: " +
                            margin + "}]\n")))
        .status;
  };
  EXPECT_EQ(planned("0.1"), PlanStatus::kSolved);
  EXPECT_NE(planned("0.2"), PlanStatus::kSolved);
  folder.write("r.urdf", R"(<robot name="s"><link name="base"/>
<link name="robot"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="robot"/><axis xyz="1 0 0"/><limit lower="0" upper="2" velocity="1" effort="1"/></joint>
</robot>)");
  const std::string file =
      folder.write("margin.yaml",
                   "leeway: 1\nrobot: {urdf: r.urdf}\nstart: [0]\ngoal: [1]\ndeforming:\n"
                   "  - {name: curtain, position: [0, 3, 0], grid: {size: [1, 1], cells: [2, 2]}, "
                   "margin: 0.1}\n");
  robots::expectInputError([&] { loadProblem(file); }, file, 6, {"'robot' is the name of a link"});
}

class Shipped : public testing::TestWithParam<const char*> {};

TEST_P(Shipped, IsSolvedCertifiedStraightAndVerified) {
  const Problem problem = loadProblem(shipped(GetParam()));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_TRUE(result.certificate.certified);
  ASSERT_EQ(result.path.steps.size(), problem.steps.size());
  EXPECT_EQ(result.certificate.segments.size() + 1, result.path.positions.size());
  const Certificate& proof = result.certificate;
  for (const PathClearance* part : {&proof.world, &proof.self}) {
    EXPECT_GE(part->clearance.lower, proof.clearance.lower);
    EXPECT_LE(part->clearance.lower, part->clearance.upper);
    ASSERT_GE(part->closest_segment, 0);
    EXPECT_LT(part->closest_segment, static_cast<int>(proof.segments.size()));
  }
  EXPECT_EQ(proof.clearance.upper,
            std::min(proof.world.clearance.upper, proof.self.clearance.upper));
  expectStraight(problem, result.path);
  EXPECT_EQ(planTask(problem).path.positions, result.path.positions);

  const Folder folder;
  for (const char* ending : {"path.json", "path.yaml"}) {
    const std::string file = folder.write(ending, "");
    writePath(file, problem, result);
    const Path read = readPath(file, problem);
    const VerifyResult verified = verify(problem, read);
    EXPECT_EQ(verified.status, VerifyStatus::kCertified) << verified.reason;
  }

  // So is the motion, alone and in a file.
  const Trajectory trajectory = trajectoryOf(problem, result.path);
  const std::string file = folder.write("trajectory.json", "");
  writeTrajectory(file, problem, result, trajectory, 0.02);
  for (const Path& motion : {motionOf(trajectory), readPath(file, problem, {.cubics = true})}) {
    const VerifyResult verified = verify(problem, motion);
    EXPECT_EQ(verified.status, VerifyStatus::kCertified) << verified.reason;
    ASSERT_EQ(motion.steps.size(), problem.steps.size());
    Path hasty = motion;  // the steps flow into each other
    for (std::size_t s = 1; s < hasty.steps.size(); ++s)
      if (hasty.steps[s].last > hasty.steps[s].first + 2 && hasty.steps[s].places.empty()) {
        ++hasty.steps[s].first;
        ++hasty.steps[s - 1].last;
        EXPECT_EQ(verify(problem, hasty).status, VerifyStatus::kRefuted);
        break;
      }
  }

  // Regression: rows between steps, at times in whole nanoseconds, moved where ramps are short.
  Problem sharp = problem;
  for (const int v : problem.robot.variables) {
    const std::string& name = problem.robot.model->variables[static_cast<std::size_t>(v)].name;
    sharp.execution.velocities[name] = 0.05;
    sharp.execution.accelerations[name] = 1000;
  }
  Path motion = motionOf(trajectoryOf(sharp, result.path));
  EXPECT_EQ(verify(sharp, motion).status, VerifyStatus::kCertified) << verify(sharp, motion).reason;
  motion.times.clear();
  EXPECT_EQ(verify(sharp, motion).status, VerifyStatus::kRefuted) << "velocities without times";

  // A path without its steps, and one that leaves a line, are refuted.
  Path bare = result.path;
  bare.steps.clear();
  EXPECT_EQ(verify(problem, bare).status, VerifyStatus::kRefuted);
  Path bent = result.path;
  const PathStep& line = bent.steps[1];
  bent.positions.erase(bent.positions.begin() + line.first + 1, bent.positions.begin() + line.last);
  const int gone = line.last - line.first - 1;
  for (std::size_t s = 1; s < bent.steps.size(); ++s) {
    bent.steps[s].last -= gone;
    if (s > 1) bent.steps[s].first -= gone;
  }
  if (gone > 0) {
    EXPECT_NE(verify(problem, bent).status, VerifyStatus::kCertified);
  }
}

INSTANTIATE_TEST_SUITE_P(PickPlace, Shipped, testing::Values("can.yaml", "carton.yaml"),
                         [](const auto& name) {
                           const std::string file = name.param;
                           return file.substr(0, file.find('.'));
                         });

std::string text(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string withSteps(const std::string& steps) {
  const std::string robot = leeway::sourceFolder() + "/robots/arm6/arm6.";
  return "leeway: 1\nrobot: {urdf: " + robot + "urdf, srdf: " + robot +
         "srdf, group: arm}\nobjects: [{name: can, position: [0.4, 0, 0.2], cylinder: {radius: "
         "0.03, length: 0.1}}]\nstart: ready\nsteps:\n" +
         steps;
}

/// Later steps fail with the first solutions of an earlier one: others are tried.
TEST(Task, EarlierStepsTryOtherSolutions) {
  const Folder folder;
  // The flange may stand at any turn, but the line goes along its own x axis into a wall for most.
  const Problem problem = loadProblem(folder.write(
      "task.yaml",
      withSteps(
          "  - move: {pose: {frame: tool, position: [0.35, -0.25, 0.4], rpy: [1.570796326794897, "
          "0, any]}}\n"
          "  - line: {frame: tool, by: [0.12, 0, 0]}\n"
          "  - move: {pose: {frame: tool, position: [[0.30, 0.40], [-0.14, -0.10], 0.4], rpy: "
          "[1.570796326794897, 0, any]}}\n")));
  const PlanResult result = planTask(problem);
  EXPECT_EQ(result.status, PlanStatus::kSolved) << result.reason;
}

// Most SRDFs put the robot into the world with a virtual joint, which nothing limits and no plan
// moves.
TEST(Task, LinesOfARobotOnAFloatingVirtualJoint) {
  const Folder folder;
  std::string srdf = text(leeway::sourceFolder() + "/robots/arm6/arm6.srdf");
  srdf.insert(srdf.find("<group "),
              "<virtual_joint name=\"place\" type=\"floating\" parent_frame=\"world\" "
              "child_link=\"base\"/>\n  ");
  const std::string file = folder.write("floating.srdf", srdf);
  std::string task =
      withSteps("  - move: ready\n  - line: {frame: tool, by: [0, 0, 0.05], relative_to: world}\n");
  const std::string old = leeway::sourceFolder() + "/robots/arm6/arm6.srdf";
  task.replace(task.find(old), old.size(), file);
  const Problem problem = loadProblem(folder.write("task.yaml", task));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved) << result.reason;
  EXPECT_LT(result.path.steps.at(1).deviation, 1e-3);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
}

/// Writes slide.urdf: a ball "car" of 5 cm that slides along x, from 0 to 2 m at up to 1 m/s.
void writeSlide(const Folder& folder) {
  folder.write(
      "slide.urdf",
      "<robot name=\"slide\"><link name=\"base\"/><link name=\"car\"><collision><geometry>"
      "<sphere radius=\"0.05\"/></geometry></collision></link><joint name=\"x\" "
      "type=\"prismatic\"><parent link=\"base\"/><child link=\"car\"/><axis xyz=\"1 0 0\"/>"
      "<limit lower=\"0\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint></robot>");
}

/// A car takes hold of a can and passes a wall at 10 mm.
TEST(Task, MarginsOfTheRobotHoldForWhatItTakesHoldOf) {
  const Folder folder;
  writeSlide(folder);
  const auto statusWith = [&](const std::string& margins) {
    return solve(loadProblem(folder.write(
                     "task.yaml",
                     "leeway: 1\nrobot: {urdf: slide.urdf}\nstart: {x: 0}\nobjects:\n"
                     "  - {name: can, position: [0, 0.2, 0], box: {size: [0.05, 0.1, 0.05]}}\n"
                     "  - {name: wall, position: [0.25, 0.31, 0], box: {size: [0.1, 0.1, 0.1]}}\n"
                     "margins: [" +
                         margins +
                         "]\nsteps: [{attach: {object: can, link: car}}, {move: {x: 0.5}}]\n")))
        .status;
  };
  EXPECT_EQ(statusWith("{between: [robot, wall], margin: 0.005}"), PlanStatus::kSolved);
  EXPECT_NE(statusWith("{between: [robot, wall], margin: 0.1}"), PlanStatus::kSolved);
}

/// Regressions: a path that begins elsewhere was certified where the first step takes hold of
/// something, and a task in which nothing moves was certified inside a wall.
TEST(Task, BeginsAtTheStartAndMoves) {
  const Folder folder;
  writeSlide(folder);
  const auto task = [&](const std::string& start, const std::string& move) {
    return loadProblem(folder.write(
        "task.yaml",
        "leeway: 1\nrobot: {urdf: slide.urdf}\nstart: [" + start +
            "]\nsteps: [{attach: {object: can, link: car}}" + move +
            "]\nobjects:\n"
            "  - {name: can, position: [0, 0.2, 0], box: {size: [0.05, 0.05, 0.05]}}\n"
            "  - {name: wall, position: [0.5, 0, 0], box: {size: [0.1, 0.1, 0.1]}}\n"));
  };
  const std::string move = ", {move: [1]}";
  const PlanResult right = planTask(task("0.7", move));
  ASSERT_EQ(right.status, PlanStatus::kSolved);
  EXPECT_EQ(verify(task("0.7", move), right.path).status, VerifyStatus::kCertified);
  const VerifyResult elsewhere = verify(task("0", move), right.path);
  EXPECT_EQ(elsewhere.status, VerifyStatus::kRefuted);
  EXPECT_NE(elsewhere.reason.find("step 1 (attach): the first waypoint is not the start"),
            std::string::npos)
      << elsewhere.reason;
  const PlanResult still = planTask(task("0.5", ""));
  EXPECT_EQ(still.status, PlanStatus::kNothingChecked);
  EXPECT_EQ(still.reason, "no step moves the robot");
}

/// Regression: the times of a path's file passed a line of 0.1 m/s at the joints' limits.
TEST(Task, TimesOfAPathKeepTheSpeedOfLines) {
  const Folder folder;
  writeSlide(folder);
  const Problem problem = loadProblem(
      folder.write("task.yaml",
                   "leeway: 1\nrobot: {urdf: slide.urdf}\nstart: [0]\n"
                   "steps: [{line: {frame: car, by: [1, 0, 0], speed: 0.1}}]\nobjects:\n"
                   "  - {name: wall, position: [0, 1, 0], box: {size: [0.1, 0.1, 0.1]}}\n"));
  const PlanResult result = planTask(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  const std::string file = folder.path("path.csv");
  writePath(file, problem, result);
  std::ifstream rows(file);
  std::string row, last;
  while (std::getline(rows, row)) last = row;
  EXPECT_GE(std::stod(last), 10) << last;
}

TEST(Task, SaysWhichStepGotNoFurther) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write(
      "task.yaml",
      withSteps("  - move: home\n  - {name: far, line: {frame: tool, by: [3, 0, 0]}}\n")));
  const PlanResult result = planTask(problem);
  EXPECT_EQ(result.status, PlanStatus::kUnsolved);
  EXPECT_NE(result.reason.find("step 2 (far): "), std::string::npos) << result.reason;
}

TEST(Task, BadStepsAreRefusedWithTheirLine) {
  const Folder folder;
  const struct {
    const char* steps;
    int line;
    const char* message;
  } cases[] = {
      {"  - {move: home, detach: can}\n", 6, "has both 'move' and 'detach'; one is expected"},
      {"  - {name: idle}\n", 6, "does nothing; move, line, attach or detach is expected"},
      {"  - detach: can\n", 6, "no attached object 'can' to detach"},
      {"  - attach: {object: cn, link: tool}\n", 6,
       "no object 'cn' to attach; did you mean 'can'?"},
      {"  - attach: {object: can, link: tol}\n", 6, "unknown link 'tol'; did you mean 'tool'?"},
      {"  - attach: {object: can, link: tool}\n  - attach: {object: can, link: tool}\n", 7,
       "object 'can' is held already"},
      {"  - attach: {object: can, link: tool}\n  - move: {pose: {frame: tool, relative_to: can, "
       "position: [0, 0, 0.1]}}\n",
       7, "'can' moves with the planned joints"},
      {"  - move: {pose: {frame: can, position: [0, 0, 0.1]}}\n", 6,
       "no frame, link or attached object 'can'"},
      {"  - line: {frame: tool, by: [0, 0, 0]}\n", 6, "is of no length"},
      {"  - line: {frame: tol, by: [0, 0, 1]}\n", 6, "did you mean 'tool'?"},
      {"  - line: {frame: tool, by: [0, 0, 1], position_tolerance: 1e-9}\n", 6,
       "position_tolerance is 1e-09; at least 1e-07 is expected"},
      {"  - {attach: {object: can, link: tool}, allowed: [[can, tool]]}\n", 6,
       "nothing moves in this step"},
      {"  - {move: home, allowed: [[can, cup]]}\n", 6, "no link or object is named 'cup'"},
      {"  - {move: hom}\n", 6, "no group state 'hom'"},
      {"  - {name: go, move: home}\n  - {name: go, detach: can}\n", 7, "two steps are named 'go'"},
      {"  - move: home\n  - {name: move, line: {frame: tool, by: [0, 0, 1]}}\n", 7,
       "two steps are named 'move'"},
  };
  for (const auto& c : cases) try {
      loadProblem(folder.write("task.yaml", withSteps(c.steps)));
      ADD_FAILURE() << "accepted: " << c.steps;
    } catch (const robots::InputError& error) {
      EXPECT_EQ(error.line(), c.line) << error.what();
      EXPECT_NE(std::string(error.what()).find(c.message), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace leeway::planner
