// Meshes of public bug reports that were certified or refuted against wrong triangles, by their own
// numbers.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/verify.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

/// A ball that moves from `start` to `goal` beside an object of a mesh.
class ReportedMeshes : public testing::Test {
 protected:
  void load(const std::string& mesh, const std::string& contents, const std::string& radius,
            const std::string& start, const std::string& goal) {
    folder_.write(mesh, contents);
    problem_ = loadProblem(folder_.write(
        "problem.yaml",
        "leeway: 1\nbody: {name: ball, joint: floating, bounds: {lower: [-20, -20, -20], upper: "
        "[20, 20, 20]}, shapes: [{sphere: {radius: " +
            radius + "}}]}\nstart: {position: [" + start +
            "], rpy: [0, 0, 0]}\ngoal: {position: [" + goal +
            "], rpy: [0, 0, 0]}\nobjects: [{name: thing, mesh: {file: " + mesh + "}}]\n"));
  }
  Verdict decide(const std::vector<double>& at) const {
    return EdgeCertifier(std::make_shared<const CompiledScene>(problem_)).decide(at);
  }
  std::vector<double> goal() const {
    std::vector<double> at;
    for (const auto& [lower, upper] : problem_.goals[0].ranges) at.push_back(lower);
    return at;
  }
  VerifyResult straight() const {
    Path path;
    for (const robots::Variable& v : problem_.robot.model->variables) path.names.push_back(v.name);
    path.positions = {problem_.start, goal()};
    return verify(problem_, path);
  }

  Folder folder_;
  Problem problem_;
};

/// A panel with three windows, one polygon of 25 corners; a ball of 1 m went straight through.
TEST_F(ReportedMeshes, APanelWithWindowsIsWhole) {
  load("hole_1.obj",
       "v 5 0 0\nv 1 0 0\nv 1 1 0\nv 3 1 0\nv 3 4 0\nv 1 4 0\nv 1 1 0\nv 1 0 0\nv 0 0 0\nv 0 8 0\n"
       "v 13 8 0\nv 13 0 0\nv 9 0 0\nv 9 2 0\nv 10 2 0\nv 10 4 0\nv 9 4 0\nv 9 2 0\nv 9 0 0\n"
       "v 5 0 0\nv 5 2 0\nv 6 2 0\nv 6 3 0\nv 5 3 0\nv 5 2 0\n"
       "f 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25\n",
       "1", "9.655, 5.28, 3", "9.655, 5.28, -3");
  EXPECT_EQ(straight().status, VerifyStatus::kRefuted);
  EXPECT_EQ(decide({9.655, 5.28, 0, 0, 0, 0, 1}), Verdict::kNotFree);
  const PlanResult around = plan(problem_);
  EXPECT_EQ(around.status, PlanStatus::kSolved);
  EXPECT_GT(around.path.positions.size(), 2U);
  EXPECT_EQ(verify(problem_, around.path).status, VerifyStatus::kCertified);
}

/// A plate whose faces have 15 corners got too few triangles; a goal inside it was valid.
TEST_F(ReportedMeshes, AGoalInsideAPlateIsNotValid) {
  const char* const corners[] = {"5 3", "5 4", "1 5", "1 4", "2 3", "0 2", "2 2", "3 2",
                                 "2 1", "0 0", "5 0", "4 2", "3 3", "3 4", "5 2"};
  constexpr int kCorners = 15;
  std::string text, below = "f", above = "f", sides;
  for (const char* height : {" 0.0\n", " 0.1\n"})
    for (const char* corner : corners) text += std::string("v ") + corner + height;
  for (int i = 1; i <= kCorners; ++i) {
    const int next = i % kCorners + 1;
    below += " " + std::to_string(kCorners + 1 - i);
    above += " " + std::to_string(kCorners + i);
    sides += "f";
    for (const int v : {i, next, next + kCorners, i + kCorners}) sides += " " + std::to_string(v);
    sides += "\n";
  }
  load("hole_8_plate.obj", text + below + "\n" + above + "\n" + sides, "0.04", "2.53, 2.53, 3",
       "2.53, 2.53, 0.05");
  EXPECT_TRUE(problem_.warnings.empty());
  EXPECT_EQ(decide(problem_.start), Verdict::kFree);
  EXPECT_EQ(decide(goal()), Verdict::kNotFree);
  EXPECT_EQ(plan(problem_).status, PlanStatus::kInvalidGoal);
}

/// Triangles in the notch of a bracket refuted a free path.
TEST_F(ReportedMeshes, TheNotchOfABracketIsFree) {
  const std::string corners =
      "v 0 -1 0.0\nv 2 -1 0.0\nv 2 0 0.0\nv 1 0 0.0\nv 1 1 0.0\nv 0 1 0.0\n"
      "v 0 -1 1.0\nv 2 -1 1.0\nv 2 0 1.0\nv 1 0 1.0\nv 1 1 1.0\nv 0 1 1.0\n";
  const std::string sides =
      "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";
  for (const char* ends :
       {"f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n",
        "f 4 2 1\nf 4 3 2\nf 6 4 1\nf 6 5 4\nf 7 8 10\nf 8 9 10\nf 7 10 12\nf 10 11 12\n"}) {
    load("bracket.obj", corners + ends + sides, "0.01", "1.2, 0.2, 2", "1.2, 0.2, -1");
    const VerifyResult result = straight();
    EXPECT_EQ(result.status, VerifyStatus::kCertified) << ends;
    EXPECT_NEAR(result.clearance_lower, 0.19 / 2, 1e-4) << ends;
  }
}

/// Four cubes in one file share faces and edges; a ball inside one of them was certified.
TEST_F(ReportedMeshes, TheInsideOfCubesThatTouchIsSolid) {
  // The corners of the faces of a unit cube, x + 2 y + 4 z, outward.
  const int faces[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                            {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  std::string facets;
  std::uint32_t count = 0;
  const auto add = [](const auto& value, std::string& text) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    text.append(bytes, sizeof value);
  };
  for (int cube = 0; cube < 4; ++cube)
    for (const auto& face : faces) {
      facets.append(12, '\0');
      for (const int corner : face) {
        add(static_cast<float>(corner % 2 + cube / 2), facets);
        add(static_cast<float>(corner / 2 % 2 + cube % 2), facets);
        add(static_cast<float>(corner / 4), facets);
      }
      facets.append(2, '\0');
      ++count;
    }
  std::string stl = "my mesh" + std::string(73, ' ');
  add(count, stl);
  load("pallet.stl", stl + facets, "0.01", "0.5, 0.5, 0.5", "0.7, 0.5, 0.5");
  EXPECT_TRUE(problem_.warnings.empty());
  EXPECT_EQ(decide(problem_.start), Verdict::kNotFree);
  EXPECT_EQ(decide({1.5, 1.5, 0.5, 0, 0, 0, 1}), Verdict::kNotFree);
  EXPECT_EQ(decide({2.5, 1.5, 0.5, 0, 0, 0, 1}), Verdict::kFree);
  const PlanResult result = plan(problem_);
  EXPECT_EQ(result.status, PlanStatus::kInvalidStart);
  EXPECT_NEAR(result.offending.clearance.upper, -0.51, 1e-6);
}

}  // namespace
}  // namespace leeway::planner
