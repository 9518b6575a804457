// Every problem file of the repository loads, its starts and goals are valid, and it shows what it
// is meant to show.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/task.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

const std::string kProblems = leeway::sourceFolder() + "/problems";

std::vector<std::string> problemFiles() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kProblems)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream stream(entry.path());
    for (std::string line; std::getline(stream, line);)
      if (line.rfind("leeway:", 0) == 0) {
        files.push_back(std::filesystem::relative(entry.path(), kProblems).string());
        break;
      }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string testName(const testing::TestParamInfo<std::string>& file) {
  std::string name = std::filesystem::path(file.param).replace_extension().string();
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

/// The ends and the middle of every range.
std::vector<std::vector<double>> goalPoints(const Goal& goal) {
  std::vector<std::vector<double>> points(3);
  for (const auto& [lower, upper] : goal.ranges) {
    points[0].push_back(lower);
    points[1].push_back(lower == upper ? lower : (lower + upper) / 2);
    points[2].push_back(upper);
  }
  return points;
}

class ShippedProblem : public testing::TestWithParam<std::string> {
 protected:
  Problem problem_ = placeStart(loadProblem(kProblems + "/" + GetParam()));
};

TEST_P(ShippedProblem, LoadsWithoutAWarning) {
  EXPECT_EQ(problem_.warnings, std::vector<std::string>());
  EXPECT_EQ(problem_.robot.model->warnings, std::vector<std::string>());
}

TEST_P(ShippedProblem, StartAndGoalsAreValid) {
  const auto scene = std::make_shared<const CompiledScene>(problem_);
  EdgeCertifier certifier(scene);
  const auto expectValid = [&](const std::string& what, const std::vector<double>& point) {
    EXPECT_TRUE(scene->space().withinLimits(point)) << what;
    const StateCheck check = certifier.clearance(point, 1e-5);
    EXPECT_EQ(check.verdict, collision::Verdict::kFree) << what;
    EXPECT_GT(check.clearance.lower, problem_.margins.common) << what;
  };
  expectValid("start", startPoint(problem_));
  for (const Goal& goal : problem_.goals) {
    if (!goal.poses.empty()) continue;  // the search finds its joint values: IsSolved...
    for (const auto& point : goalPoints(goal)) expectValid(goal.name, point);
  }
}

TEST_P(ShippedProblem, IsSolvedUnlessItHasNoSolution) {
  const bool solvable = GetParam().rfind("unsolvable/", 0) != 0;
  // Limits work instead of time: the outcome must not depend on the machine.
  problem_.limits.time = 300;
  problem_.limits.iterations = solvable ? 200000 : 2000;
  problem_.planner.simplify = false;
  const PlanResult result = solve(problem_);
  EXPECT_EQ(std::string(toString(result.status)), solvable ? "solved" : "unsolved");
  if (!solvable) return;
  EXPECT_TRUE(result.certificate.certified);
  ASSERT_GE(result.path.positions.size(), 2U);
  EXPECT_EQ(result.path.positions.front(), startPoint(problem_));
}

INSTANTIATE_TEST_SUITE_P(Files, ShippedProblem, testing::ValuesIn(problemFiles()), testName);

TEST(ShippedProblems, CoverWhatTheReadmePromises) {
  const std::vector<std::string> files = problemFiles();
  for (const char* file :
       {"shelf/reach.yaml",       "table/posts.yaml",       "bin/pick.yaml",
        "dual_arm/swap.yaml",     "snake/clutter.yaml",     "bodies/window.yaml",
        "bodies/piano.yaml",      "bodies/hooks.yaml",      "mesh/tote.yaml",
        "unsolvable/sealed.yaml", "moveit/table.yaml",      "deforming/curtain.yaml",
        "pick_place/can.yaml",    "pick_place/carton.yaml", "constrained/wipe.yaml",
        "deforming/heap.yaml",    "deforming/figure.yaml",  "constrained/glass.yaml",
        "constrained/wheel.yaml", "sensed/table.yaml",      "moving/conveyor.yaml",
        "moving/walker.yaml"})
    EXPECT_EQ(std::count(files.begin(), files.end(), file), 1) << file;
}

/// Examples of problems/README.md, in order: a whole file, a goal of poses, constraints, a body, a
/// deforming obstacle, MoveIt's files, a point cloud, objects that move.
std::vector<std::string> readmeExamples() {
  std::ifstream stream(kProblems + "/README.md");
  std::vector<std::string> examples;
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (line == "```yaml") {
      examples.emplace_back();
      inside = true;
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      examples.back() += line + "\n";
    }
  }
  return examples;
}

TEST(ShippedProblems, ExamplesOfTheReadmeLoad) {
  const Folder own;
  const std::filesystem::path folder = own.path();
  std::filesystem::create_directories(folder / "problems" / "example");
  std::filesystem::create_directories(folder / "problems" / "my_robot");
  std::filesystem::create_directory_symlink(leeway::sourceFolder() + "/robots", folder / "robots");
  for (const char* data : {"mesh", "sensed"})
    std::filesystem::create_directory_symlink(kProblems + "/" + data, folder / "problems" / data);
  for (const char* name : {"scene0001.yaml", "request0001.yaml"})
    std::filesystem::copy_file(kProblems + "/moveit/" + name,
                               folder / "problems" / "example" / name);
  const std::vector<std::string> examples = readmeExamples();
  EXPECT_EQ(examples.size(), 11U);
  for (std::string example : examples) {
    if (example.rfind("leeway:", 0) != 0) example = "leeway: 1\n" + example;
    const std::string file = (folder / "problems" / "example" / "problem.yaml").string();
    std::ofstream(file) << example;
    EXPECT_NO_THROW(EXPECT_TRUE(loadProblem(file).warnings.empty())) << example;
  }
  std::filesystem::remove_all(folder);
}

/// Concavity matters: the tote's hull would contain the start.
TEST(ShippedProblems, ConcaveMeshesMatter) {
  Problem problem = loadProblem(kProblems + "/mesh/tote.yaml");
  for (Object& object : problem.world.objects)
    for (collision::Geometry& geometry : object.geometries)
      if (const collision::TriangleMesh* mesh = geometry.shape.mesh(); mesh != nullptr) {
        EXPECT_EQ(mesh->componentCount(), 1);
        EXPECT_EQ(mesh->closedComponentCount(), 1);
        geometry.shape = collision::Shape::convexHull(mesh->vertices());
      }
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(certifier.decide(startPoint(problem)), collision::Verdict::kNotFree);
  EXPECT_EQ(certifier.decide(goalPoints(problem.goals[0])[0]), collision::Verdict::kNotFree);
}

/// The arms of the swap conflict: the straight edge is not free, and the contact is between arms.
TEST(ShippedProblems, ArmsOfTheSwapAreInEachOthersWay) {
  Problem problem = loadProblem(kProblems + "/dual_arm/swap.yaml");
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(certifier.certify(startPoint(problem), goalPoints(problem.goals[0])[0]).verdict,
            collision::Verdict::kNotFree);
  for (const char* left : {"left_upper_arm", "left_forearm", "left_wrist1", "left_wrist2",
                           "left_wrist3", "left_tool_body"})
    for (const char* right : {"right_upper_arm", "right_forearm", "right_wrist1", "right_wrist2",
                              "right_wrist3", "right_tool_body"})
      problem.contacts.allowed.emplace_back(left, right);
  problem.world.objects.clear();
  EdgeCertifier alone(std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(alone.certify(startPoint(problem), goalPoints(problem.goals[0])[0]).verdict,
            collision::Verdict::kFree);
}

}  // namespace
}  // namespace leeway::planner
