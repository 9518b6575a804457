// Lengths beyond 1,000 m, bounds of joints that are not planned, and paths of files in problems.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/verify.h"
#include "planner/validate/checks.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

void expectFault(const Folder& folder, const std::string& text, int line,
                 const std::string& message) {
  SCOPED_TRACE(text);
  const std::string file = folder.write("wrong.yaml", text);
  robots::expectInputError([&] { loadProblem(file); }, file, line, {message});
}

/// A rail of 9 km with a trolley that lifts its arm, and a free joint of one axis.
constexpr const char* kRail = R"(<robot name="rail"><link name="ground"/>
<link name="trolley"><collision><geometry><box size="1 0.5 0.2"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 1"/></geometry></collision></link>
<joint name="drive" type="prismatic"><parent link="ground"/><child link="trolley"/><axis xyz="1 0 0"/><limit lower="-9000" upper="90000" effort="1" velocity="10"/></joint>
<joint name="lift" type="revolute"><parent link="trolley"/><child link="arm"/><origin xyz="0 0 0.2"/><axis xyz="0 1 0"/><limit lower="-1.6" upper="1.6" effort="1" velocity="1"/></joint></robot>
)";

std::string rail(const std::string& start, const std::string& goal, const std::string& more = "") {
  return "leeway: 1\nrobot: {urdf: rail.urdf}\nstart: " + start + "\ngoal: " + goal + "\n" + more;
}

TEST(FarAway, APrismaticJointIsPlannedAndVerified) {
  const Folder folder;
  folder.write("rail.urdf", kRail);
  // A beam across, under which the arm passes only lowered.
  const Problem problem = loadProblem(
      folder.write("rail.yaml", rail("[7000, 0]", "[7020, 0]",
                                     "margin: 0.01\nbounds: {drive: [6990, 7030]}\nobjects: "
                                     "[{name: beam, position: [7010, 0, 1.5], box: "
                                     "{size: [0.2, 4, 1.6]}}]\n")));
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
  Path straight = result.path;
  straight.positions = {{7000, 0}, {7020, 0}};
  EXPECT_EQ(verify(problem, straight).status, VerifyStatus::kRefuted);
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(certifier.certify(straight.positions[0], straight.positions[1]).verdict,
            collision::Verdict::kNotFree);
}

TEST(FarAway, Beyond10KilometresNothingIsCertified) {
  const Folder folder;
  folder.write("rail.urdf", kRail);
  const Problem problem = loadProblem(folder.write("rail.yaml", rail("[7000, 0]", "[7020, 0]")));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const std::vector<double> near = {9999, 0}, far = {10001, 0};
  EXPECT_EQ(certifier.certify(near, near).verdict, collision::Verdict::kFree);
  EXPECT_EQ(certifier.certify(near, far).verdict, collision::Verdict::kUndecided);
}

TEST(FarAway, APlanarBodyIsPlannedAndVerified) {
  const Folder folder;
  const Problem problem = loadProblem(folder.write(
      "body.yaml",
      "leeway: 1\nbody: {joint: planar, bounds: {lower: [1500, -2600], upper: [1520, -2580]}, "
      "shapes: [{box: {size: [1, 0.5, 0.5]}}]}\nstart: {position: [1502, -2590]}\ngoal: {position: "
      "[1518, -2590]}\nobjects: [{name: wall, position: [1510, -2590, 0], box: {size: [0.5, 8, "
      "1]}}]\n"));
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
  Path straight = result.path;
  straight.positions = {straight.positions.front(), straight.positions.back()};
  EXPECT_EQ(verify(problem, straight).status, VerifyStatus::kRefuted);
}

TEST(FarAway, TheLimitIsNamed) {
  const Folder folder;
  folder.write("rail.urdf", kRail);
  expectFault(folder, rail("[10001, 0]", "[7020, 0]"), 3,
              "start has joint 'drive' at 10001; at most 10000 m is expected");
  expectFault(folder, rail("[0, 0]", "[[9990, 10001], 0]"), 4,
              "goal has joint 'drive' at 10001; at most 10000 m is expected");
  expectFault(folder, rail("[0, 0]", "[any, 0]"), 4,
              "the limits of joint 'drive' are -9000 to 90000, beyond +-10000");
  expectFault(folder, rail("[0, 0]", "[[0, 90000], 0]"), 4,
              "joint 'drive' at 90000, which is its limit; at most 10000 m is expected");
}

TEST(FarAway, OutsideItsLimitsALengthIsCertifiedUpTo1000) {
  const Folder folder;
  folder.write("rail.urdf", kRail);
  const Problem problem = loadProblem(
      folder.write("rail.yaml", rail("[0, 0]", "[5, 0]", "bounds: {drive: [-10, 10]}\n")));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const auto verdict = [&](double x) {
    const std::vector<double> point = {x, 0};
    return certifier.certify(point, point).verdict;
  };
  EXPECT_EQ(verdict(10), verdict(-10));
  EXPECT_EQ(verdict(1001), collision::Verdict::kUndecided);
}

/// Bounds hold for joints that are not planned, too, and what they name exists.
TEST(Bounds, HoldForJointsThatAreNotPlanned) {
  const Folder folder;
  folder.write("rail.urdf", kRail);
  folder.write("rail.srdf",
               "<robot name=\"rail\"><group name=\"arm\"><joint name=\"lift\"/></group><group "
               "name=\"base\"><joint name=\"drive\"/></group><group_state name=\"far\" "
               "group=\"base\"><joint name=\"drive\" value=\"50\"/></group_state></robot>");
  const auto with = [](const std::string& start, const std::string& more) {
    return "leeway: 1\nrobot: {urdf: rail.urdf, srdf: rail.srdf, group: arm}\nstart: " + start +
           "\ngoal: [1]\n" + more;
  };
  const auto accepts = [&](const std::string& text) {
    return loadProblem(folder.write("good.yaml", text)).start[0];
  };
  EXPECT_EQ(accepts(with("[0]", "joints: {drive: 4}\nbounds: {drive: [3, 5]}\n")), 4);
  EXPECT_EQ(accepts(with("[0]", "bounds: {drive: [3, 5]}\n")), 3) << "the nearest to zero";
  EXPECT_EQ(accepts(with("[0]", "joints: {drive: -9001}\n")), -9001) << "the robot's own limits";
  Problem beyond = loadProblem(folder.path("good.yaml"));
  const std::string off =
      "joint 'drive' at -9001, outside its limits of -9000 to 90000; it is not planned and stays "
      "there";
  EXPECT_EQ(beyond.warnings,
            std::vector<std::string>{folder.path("good.yaml") + ":5: joints has " + off});
  EXPECT_EQ(problemWarnings(beyond), beyond.warnings);
  beyond.warnings.clear();
  EXPECT_EQ(problemWarnings(beyond), std::vector<std::string>{"start has " + off});
  const std::string bound = ", outside its limits; 3 to 5 is expected, because of bounds.drive";
  expectFault(folder, with("[0]", "joints: {drive: 6}\nbounds: {drive: [3, 5]}\n"), 5,
              "joints has joint 'drive' at 6" + bound);
  expectFault(folder, with("[0]", "joints: far\nbounds: {drive: [3, 5]}\n"), 5,
              "group state 'far' has joint 'drive' at 50" + bound);
  expectFault(folder, with("{drive: 2, lift: 0}", "bounds: {drive: [3, 5]}\n"), 3,
              "start has joint 'drive' at 2" + bound);
  Problem problem =
      loadProblem(folder.write("good.yaml", with("[0]", "bounds: {drive: [3, 5]}\n")));
  problem.start[0] = 7;
  EXPECT_THROW(validate(problem), robots::InputError);
  expectFault(folder, with("[0]", "bounds: {drve: {}}\n"), 5,
              "bounds.drve: no joint is named 'drve'; did you mean 'drive'?");
  expectFault(folder, with("[0]", "bounds: {drive: {}}\n"), 5,
              "bounds.drive: joint 'drive' has no bounds; a lower and an upper bound are expected");
  expectFault(folder, with("[0]", "bounds: {drive: }\n"), 5,
              "bounds.drive is nothing; [lower, upper]");
}

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// Meshes of objects are found as those of a URDF.
TEST(Packages, OfMeshesOfObjects) {
  const Folder folder;
  folder.write("parts/meshes/t.obj", kTetrahedron);
  folder.write("elsewhere/t.obj", kTetrahedron);
  folder.write("p/rail.urdf", kRail);
  const auto with = [](const std::string& robot, const std::string& more) {
    return "leeway: 1\nrobot: {urdf: rail.urdf" + robot + "}\nstart: [0, 0]\ngoal: [1, 0]\n" + more;
  };
  const auto object = [](const std::string& shape) {
    return "objects:\n- name: t\n  position: [0, 50, 0]\n  " + shape + "\n";
  };
  const auto load = [&](const std::string& text) {
    return loadProblem(folder.write("p/good.yaml", text));
  };
  for (const char* uri :
       {"package://parts/meshes/t.obj", "model://parts/meshes/t.obj", "../parts/meshes/t.obj"}) {
    const std::string file = std::string("{file: '") + uri + "'}";
    for (const char* word : {"mesh", "convex_hull"})
      EXPECT_EQ(load(with("", object(word + (": " + file)))).world.objects.size(), 1U) << uri;
    EXPECT_EQ(load(with("", "deforming: [{name: d, position: [0, 90, 0], mesh: " + file + "}]\n"))
                  .world.deforming.size(),
              1U)
        << uri;
  }
  EXPECT_EQ(
      load(with(", packages: {mine: ../elsewhere}", object("mesh: {file: 'package://mine/t.obj'}")))
          .world.objects.size(),
      1U);
  const auto expect = [&](const std::string& text, int line, const std::string& message) {
    SCOPED_TRACE(text);
    const std::string file = folder.write("p/wrong.yaml", text);
    robots::expectInputError([&] { loadProblem(file); }, file, line, {message});
  };
  expect(with("", object("mesh: {file: 'package://nobody/t.obj'}")), 8,
         "there is no package \"nobody\"");
  expect(with("", object("mesh: {file: 'http://nobody/t.obj'}")), 8,
         "has a scheme that is not known");
  expect(with("", object("cloud: {file: 'package://parts/t.xyz', radius: 1}")), 8,
         "objects[0].cloud.file is 'package://parts/t.xyz'; a path is expected");
  expect(with("", object("mesh: {file: ''}")), 8,
         "objects[0].mesh.file is empty; the path of a file");
  expect(with(", srdf: ''", ""), 2, "robot.srdf is empty; the path of a file is expected");
  expect(with(", srdf: ", ""), 2, "robot.srdf is empty; the path of a file is expected");
  expect(with(", srdf: .", ""), 2, "which is a folder; an existing file is expected");
}

}  // namespace
}  // namespace leeway::planner
