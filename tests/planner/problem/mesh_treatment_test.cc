// How meshes are read: `meshes` in problem files, and warnings of meshes that are not closed.
#include <gtest/gtest.h>

#include <string>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

// A unit cube whose top is a quarter of a micron above its sides.
constexpr const char* kCracked =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "v 0 0 1.00000025\nv 1 0 1.00000025\nv 1 1 1.00000025\nv 0 1 1.00000025\n"
    "f 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 9 10 11 12\n";

std::string withBall(const std::string& more) {
  return "leeway: 1\nbody: {name: ball, joint: floating, bounds: {lower: [-3, -3, -3], upper: [3, "
         "3, 3]}, "
         "shapes: [{sphere: {radius: 0.01}}]}\n"
         "start: {position: [0.5, 0.5, 0.5], rpy: [0, 0, 0]}\n"
         "goal: {position: [2, 0.5, 0.5], rpy: [0, 0, 0]}\n"
         "objects: [{name: cube, mesh: {file: cube.obj}}]\n" +
         more;
}

struct Loaded {
  Problem problem;
  Verdict start;
};

Loaded load(const Folder& folder, const std::string& text) {
  Loaded loaded;
  loaded.problem = loadProblem(folder.write("problem.yaml", text));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(loaded.problem));
  loaded.start = certifier.decide(loaded.problem.start);
  return loaded;
}

bool warnsOf(const Problem& problem, const std::string& words) {
  for (const std::string& warning : problem.warnings)
    if (warning.find(words) != std::string::npos) return true;
  return false;
}

TEST(MeshTreatment, AMeshThatIsNotClosedIsNamedOnce) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  const Loaded open = load(folder, withBall(""));
  EXPECT_EQ(open.start, Verdict::kFree);
  ASSERT_EQ(open.problem.warnings.size(), 1U);
  EXPECT_TRUE(warnsOf(open.problem,
                      "a mesh is not closed: cube (8 open edges); where it is open, "
                      "what is inside is not seen. The key `meshes: {cube: {solid: "
                      "hull}}` of a problem file, in Python the argument meshes, takes"))
      << open.problem.warnings[0];
}

/// Regression: what had left the world was named as before.
TEST(MeshTreatment, AMeshThatWasRemovedIsNamedNoMore) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  Problem problem = load(folder, withBall("")).problem;
  const Object cube = problem.world.objects.front();
  problem.world.objects.erase(problem.world.objects.begin());
  EXPECT_TRUE(problemWarnings(problem).empty());
  problem.world.objects.push_back(cube);
  EXPECT_EQ(problemWarnings(problem), problem.warnings);
}

TEST(MeshTreatment, AProgramsMeshThatIsNotClosedIsNamed) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  Problem problem = load(folder, withBall("")).problem;
  EXPECT_EQ(problemWarnings(problem), problem.warnings);
  problem.world.objects.push_back(problem.world.objects.front());
  problem.world.objects.back().name = "cub";  // within another's name
  ASSERT_EQ(problemWarnings(problem).size(), 2U);
  EXPECT_TRUE(problemWarnings(problem)[1].starts_with("a mesh is not closed: cub (8 open edges);"))
      << problemWarnings(problem)[1];
  problem.warnings.clear();
  ASSERT_EQ(problemWarnings(problem).size(), 1U);
  EXPECT_TRUE(problemWarnings(problem)[0].starts_with(
      "meshes are not closed: cube (8 open edges), cub (8 open edges);"))
      << problemWarnings(problem)[0];
  EXPECT_EQ(problemWarnings(problem)[0].find("key"), std::string::npos) << "no file has one";
}

TEST(MeshTreatment, WeldHullAndSurfaceDecide) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  for (const char* welded : {"meshes: {cube: {weld: 1.0e-6}}", "meshes: {cube: {solid: hull}}",
                             "meshes: {cube.obj: {solid: auto, weld: 1.0e-6}}"}) {
    const Loaded loaded = load(folder, withBall(welded));
    EXPECT_EQ(loaded.start, Verdict::kNotFree) << welded;
    EXPECT_TRUE(loaded.problem.warnings.empty()) << welded;
  }
  // Cracks that are wider stay, and have a warning.
  const Loaded wider = load(folder, withBall("meshes: {cube: {weld: 1.0e-7}}"));
  EXPECT_EQ(wider.start, Verdict::kFree);
  EXPECT_TRUE(warnsOf(wider.problem, "not closed"));
  const Loaded surface = load(folder, withBall("meshes: {cube: {solid: surface}}"));
  EXPECT_EQ(surface.start, Verdict::kFree);
  EXPECT_TRUE(surface.problem.warnings.empty());
}

TEST(MeshTreatment, LinksHaveIt) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  const std::string urdf = folder.write(
      "robot.urdf",
      "<robot name='r'><link name='base'><collision><geometry><mesh filename='cube.obj'/>"
      "</geometry></collision></link><link name='tip'><collision><geometry><sphere radius='0.01'/>"
      "</geometry></collision></link><joint name='j' type='prismatic'><parent link='base'/>"
      "<child link='tip'/><axis xyz='1 0 0'/><limit lower='-3' upper='3' velocity='1' effort='1'/>"
      "</joint></robot>");
  const auto open = robots::loadModel(urdf, "");
  ASSERT_EQ(open->warnings.size(), 1U);
  EXPECT_NE(open->warnings[0].find("a mesh is not closed: base (8 open edges)"), std::string::npos)
      << open->warnings[0];
  robots::LoadOptions options;
  options.meshes["base"] = {robots::MeshTreatment::Solid::kAuto, 1e-6};
  const auto closed = robots::loadModel(urdf, "", options);
  EXPECT_TRUE(closed->warnings.empty());
  EXPECT_EQ(closed->links[0].geometries[0].shape.mesh()->closedComponentCount(), 1);
  options.meshes = {{"bsae", {}}};
  try {
    robots::loadModel(urdf, "", options);
    FAIL();
  } catch (const robots::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("meshes names 'bsae'"), std::string::npos);
  }
}

/// Regression: where the owner's entry takes the place of its file's, the file was called unknown.
TEST(MeshTreatment, TheOwnersEntryComesBeforeItsFiles) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  const Loaded loaded =
      load(folder, withBall("meshes: {cube.obj: {solid: surface}, cube: {solid: hull}}"));
  EXPECT_EQ(loaded.start, Verdict::kNotFree);
  EXPECT_TRUE(loaded.problem.warnings.empty());
}

TEST(MeshTreatment, WrongEntriesAreRefused) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  const std::pair<const char*, const char*> cases[] = {
      {"meshes: {cbue: {solid: hull}}",
       "no link, object or file with a mesh is named 'cbue'; did "
       "you mean 'cube'?"},
      {"meshes: {cube: {solid: yes}}",
       "meshes.cube.solid is 'yes'; auto, hull or surface is "
       "expected"},
      {"meshes: {cube: {solid: hull, weld: 1}}", "stands beside solid: hull"},
      {"meshes: {cube: {weld: -1}}", "meshes.cube.weld"},
      {"meshes: {cube: {wled: 1}}", "wled"},
  };
  for (const auto& [text, message] : cases) {
    try {
      loadProblem(folder.write("problem.yaml", withBall(text)));
      ADD_FAILURE() << text;
    } catch (const robots::InputError& error) {
      EXPECT_EQ(error.line(), 6) << text;
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

/// Objects of MoveIt's scenes, by a problem file or by a program.
TEST(MeshTreatment, ObjectsOfMoveitsScenesHaveIt) {
  const Folder folder;
  folder.write("cube.obj", kCracked);
  const std::string urdf = folder.write(
      "r.urdf",
      "<robot name=\"r\"><link name=\"base\"/><link name=\"ball\"><collision><geometry><sphere "
      "radius=\"0.01\"/></geometry></collision></link><joint name=\"x\" type=\"prismatic\"><parent "
      "link=\"base\"/><child link=\"ball\"/><axis xyz=\"1 0 0\"/><limit lower=\"0\" upper=\"3\" "
      "effort=\"1\" velocity=\"1\"/></joint></robot>");
  const std::string srdf = folder.write(
      "r.srdf", "<robot name=\"r\"><group name=\"all\"><joint name=\"x\"/></group></robot>");
  const std::string scene = folder.write(
      "scene.yaml",
      "world:\n  collision_objects:\n    - id: cube\n      meshes: [{resource: cube.obj}]\n      "
      "mesh_poses: [{position: [0, -0.5, -0.5], orientation: [0, 0, 0, 1]}]\n");
  const std::string request = folder.write(
      "request.yaml",
      "group_name: all\nstart_state: {joint_state: {name: [x], position: [0.5]}}\n"
      "goal_constraints:\n  - joint_constraints: [{joint_name: x, position: 2, tolerance_above: "
      "0.01, tolerance_below: 0.01, weight: 1}]\n");
  const std::string file =
      "leeway: 1\nrobot: {urdf: r.urdf, srdf: r.srdf}\n"
      "moveit: {scene: scene.yaml, request: request.yaml}\n";
  EXPECT_EQ(load(folder, file).start, Verdict::kFree);
  EXPECT_EQ(load(folder, file + "meshes: {cube: {weld: 1.0e-6}}\n").start, Verdict::kNotFree);

  const auto model = robots::loadModel(urdf, srdf);
  ProblemOptions options;
  const auto openEdges = [&] {
    const Problem problem = loadMoveit(model, scene, request, options);
    return problem.world.objects.at(0).geometries.at(0).shape.mesh()->openEdgeCount();
  };
  EXPECT_EQ(openEdges(), 8U);
  options.load.meshes["cube"].weld = 1e-6;
  EXPECT_EQ(openEdges(), 0U);
  // A name that is not there is refused, wherever it comes in.
  options.load.meshes["cueb"].weld = 1e-6;
  const auto refused = [&](const auto& load) {
    try {
      load();
      ADD_FAILURE() << "was accepted";
    } catch (const robots::InputError& error) {
      EXPECT_NE(std::string(error.what())
                    .find("no link, object or file with a mesh is named "
                          "'cueb'; did you mean 'cube'?"),
                std::string::npos)
          << error.what();
    }
  };
  refused([&] { loadMoveit(model, scene, request, options); });
  const std::string own = folder.write("own.yaml", withBall(""));
  refused([&] { loadProblem(own, options); });
  options.load.meshes.erase("cueb");
  const Problem problem = loadProblem(own, options);
  EXPECT_EQ(problem.world.objects.at(0).geometries.at(0).shape.mesh()->openEdgeCount(), 0U);
}

// Two cubes of one file that share a facet, and a facet cut in two where the other solid's is not.
TEST(MeshTreatment, CubesThatTouchAreSolid) {
  const Folder folder;
  std::string text;
  for (int x = 0; x < 2; ++x)
    for (int i = 0; i < 8; ++i)
      text += "v " + std::to_string(x + (i & 1)) + ' ' + std::to_string((i >> 1) & 1) + ' ' +
              std::to_string(i >> 2) + '\n';
  for (int x = 0; x < 2; ++x)
    for (const auto& f : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
      text += 'f';
      for (const char* c = f; *c != 0; ++c)
        text += *c == ' ' ? "" : ' ' + std::to_string(*c - '0' + 8 * x);
      text += '\n';
    }
  folder.write("cube.obj", text);
  const Loaded loaded = load(folder, withBall(""));
  EXPECT_EQ(loaded.start, Verdict::kNotFree);
  EXPECT_TRUE(loaded.problem.warnings.empty());
}

}  // namespace
}  // namespace leeway::planner
