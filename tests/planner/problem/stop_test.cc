// Reading and compiling end where their caller says so, and leave nothing half done.

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/stopped.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/random_model.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using robots::Stop;
using robots::Stopped;

/// Asks `work(stop)` to stop at its first question, at its last, at some between, and never.
/// Returns how many questions it has.
template <class Work>
int expectStops(const Work& work) {
  int asked = 0;
  work([&asked] { return ++asked < 0; });
  EXPECT_GT(asked, 0);
  for (const int last : std::set<int>{1, 2, asked / 3, asked / 2, asked - 1, asked}) {
    if (last < 1 || last > asked) continue;
    int count = 0;
    EXPECT_THROW(work([&] { return ++count == last; }), Stopped) << last << " of " << asked;
    EXPECT_EQ(count, last) << "asked again";
  }
  int count = 0;
  work([&] { return ++count > asked; });
  EXPECT_EQ(count, asked);
  return asked;
}

std::string boxes(int count) {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += "  - {name: box_" + std::to_string(i) + ", position: [" + std::to_string(2 + i) +
            ", 0, 0], box: {size: [1, 1, 1]}}\n";
  return text;
}

TEST(Stop, ReadingObjects) {
  const Folder folder;
  const std::string file = folder.write("many.yaml", R"(leeway: 1
body: {name: dot, joint: floating, bounds: {lower: [-1, -1, -1], upper: [1, 1, 1]}, shapes: [{sphere: {radius: 0.1}}]}
start: {position: [0, 0, 0]}
goal: {position: [0.5, 0, 0]}
objects:
)" + boxes(2000));
  const int asked = expectStops([&](const Stop& stop) {
    ProblemOptions options;
    options.load.stop = stop;
    EXPECT_EQ(loadProblem(file, options).world.objects.size(), 2000U);
  });
  EXPECT_GT(asked, 2000);
}

TEST(Stop, ReadingARobot) {
  const std::string folder = leeway::sourceFolder() + "/problems";
  const int asked = expectStops([&](const Stop& stop) {
    ProblemOptions options;
    options.load.stop = stop;
    EXPECT_FALSE(loadProblem(folder + "/table/posts.yaml", options).world.objects.empty());
  });
  EXPECT_GT(asked, 5);
}

/// Meshes of links are read by several threads; the caller's alone asks.
TEST(Stop, ReadingTheMeshesOfARobot) {
  const Folder folder;
  std::string urdf = "<robot name=\"stack\"><link name=\"link0\"/>\n";
  for (int i = 1; i <= 12; ++i) {
    const std::string name = "link" + std::to_string(i), mesh = name + ".obj";
    folder.write(mesh, "v 0 0 " + std::to_string(i) +
                           "\nv 1 0 0\nv 0 1 0\nv 0 0 -1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    urdf += "<link name=\"" + name + "\"><collision><geometry><mesh filename=\"" + mesh +
            "\"/></geometry></collision></link>\n<joint name=\"joint" + std::to_string(i) +
            "\" type=\"fixed\"><parent link=\"link0\"/><child link=\"" + name + "\"/></joint>\n";
  }
  const std::string file = folder.write("stack.urdf", urdf + "</robot>\n");
  robots::LoadOptions options;
  options.stop = [] { return true; };
  EXPECT_THROW(robots::loadModel(file, "", options), Stopped);
  // It says how much is left, and what.
  int asked = 0;
  options.stop = [&] { return ++asked > 1; };
  try {
    robots::loadModel(file, "", options);
  } catch (const Stopped& stopped) {
    const std::string what = stopped.what();
    EXPECT_TRUE(what.find("link") != std::string::npos || what.ends_with("were read")) << what;
  }
  options.stop = []() -> bool { throw std::logic_error("the caller's"); };
  EXPECT_THROW(robots::loadModel(file, "", options), std::logic_error);
  options.stop = [] { return false; };
  EXPECT_EQ(robots::loadModel(file, "", options)->links.size(), 13U);
}

/// A large mesh is left in the middle: what is asked is answered while it is made.
TEST(Stop, ReadingALargeMesh) {
  const Folder folder;
  std::string obj;
  constexpr int kSide = 300;
  for (int i = 0; i <= kSide; ++i)
    for (int j = 0; j <= kSide; ++j)
      obj += "v " + std::to_string(i) + ' ' + std::to_string(j) + ' ' +
             std::to_string((i * 7919 + j * 104729) % 97) + '\n';
  for (int i = 1; i <= kSide; ++i)
    for (int j = 1; j <= kSide; ++j) {
      const int a = (i - 1) * (kSide + 1) + j;
      obj += "f " + std::to_string(a) + ' ' + std::to_string(a + 1) + ' ' +
             std::to_string(a + kSide + 1) + '\n';
    }
  const std::string mesh = folder.write("large.obj", obj);
  const std::string urdf =
      folder.write("large.urdf",
                   "<robot name=\"large\"><link name=\"a\"><collision><geometry><mesh filename=\"" +
                       mesh + "\"/></geometry></collision></link></robot>\n");
  for (const int last : {1, 2, 4}) {
    robots::LoadOptions options;
    int asked = 0;
    options.stop = [&] { return ++asked == last; };
    const Eigen::Vector3d scale = Eigen::Vector3d::Ones();
    EXPECT_THROW(robots::loadMesh(mesh, scale, urdf, 1, options), Stopped);
    EXPECT_EQ(asked, last);
    asked = 0;
    EXPECT_THROW(robots::loadModel(urdf, "", options), Stopped);
    EXPECT_EQ(asked, last);
    options.stop = [&]() -> bool { throw std::logic_error("the caller's"); };
    EXPECT_THROW(robots::loadMesh(mesh, scale, urdf, 1, options), std::logic_error);
  }
}

TEST(Stop, ReadingAMesh) {
  const Folder folder;
  const std::string file = folder.write("arch.yaml", R"(leeway: 1
body: {name: dot, joint: floating, bounds: {lower: [-1, -1, -1], upper: [1, 1, 1]}, shapes: [{sphere: {radius: 0.1}}]}
start: {position: [0, 0, 0]}
goal: {position: [0.5, 0, 0]}
objects: [{name: arch, mesh: {file: )" + leeway::sourceFolder() +
                                                         "/problems/mesh/meshes/arch.stl}}]\n");
  expectStops([&](const Stop& stop) {
    ProblemOptions options;
    options.load.stop = stop;
    EXPECT_FALSE(loadProblem(file, options).world.objects.empty());
  });
}

TEST(Stop, ReadingMoveit) {
  const std::string folder = leeway::sourceFolder() + "/problems/moveit";
  const auto model = loadProblem(folder + "/table.yaml").robot.model;
  expectStops([&](const Stop& stop) {
    ProblemOptions options;
    options.load.stop = stop;
    const Problem problem =
        loadMoveit(model, folder + "/scene0001.yaml", folder + "/request0001.yaml", options);
    EXPECT_FALSE(problem.world.objects.empty());
  });
}

TEST(Stop, CompilingManyObjects) {
  Problem problem =
      test::problemOf(test::flyingBox(), {0, 0, 0, 0, 0, 0, 1}, {0.5, 0, 0, 0, 0, 0, 1});
  for (int i = 0; i < 5000; ++i)
    problem.world.objects.push_back(test::box("box " + std::to_string(i), {1, 1, 1}, 2 + i, 0, 3));
  const int asked = expectStops([&](const Stop& stop) {
    EXPECT_EQ(CompiledScene(problem, stop).scene().pairs().size(), 5000U);
  });
  EXPECT_GT(asked, 4);
}

/// A robot without an SRDF, whose links are proven apart; what was proven before a stop is not kept
/// with the model as if it were all.
TEST(Stop, CompilingARobot) {
  robots::RobotDescription arm = robots::testing::chain(
      6, robots::JointType::kRevolute, 0.3, [](int i, robots::Link& link, robots::Joint& joint) {
        link.geometries.push_back({collision::Shape::sphere(0.05), test::at(0, 0, 0.1), link.name});
        joint.axis = Eigen::Vector3d::UnitY();
        if (i > 0) joint.X_PJ = test::at(0, 0, 0.3);
      });
  std::optional<std::size_t> pairs;
  expectStops([&](const Stop& stop) {
    // A new model each time: what is prepared is kept with it.
    const auto model = std::make_shared<robots::Model>(robots::RobotDescription(arm));
    const std::vector<double> q = model->defaultConfiguration();
    const Problem problem = test::problemOf(model, q, q);
    try {
      const CompiledScene scene(problem, stop);
      if (!pairs) pairs = scene.scene().pairs().size();
      EXPECT_EQ(scene.scene().pairs().size(), *pairs);
    } catch (const Stopped&) {
      EXPECT_EQ(CompiledScene(problem).scene().pairs().size(), *pairs);
      throw;
    }
  });
}

/// A plan whose problem is not compiled was not tried.
TEST(Stop, APlanSaysThatNothingWasCompiled) {
  const Problem problem = test::wallProblem();
  PlanOptions options;
  options.stop = [] { return true; };
  std::set<std::string> phases;
  options.progress = [&](const std::string& phase, double) { phases.insert(phase); };
  const PlanResult result = plan(problem, options);
  EXPECT_EQ(result.status, PlanStatus::kNotCompiled);
  EXPECT_STREQ(toString(result.status), "not_compiled");
  EXPECT_EQ(result.reason, "the problem was not compiled before it was stopped");
  EXPECT_TRUE(result.path.positions.empty());
  EXPECT_FALSE(result.certificate.certified);
  EXPECT_EQ(phases, std::set<std::string>{"compile"});
  EXPECT_EQ(result.planner, problem.planner.name);
  EXPECT_EQ(result.seed, problem.seed);
}

}  // namespace
}  // namespace leeway::planner
