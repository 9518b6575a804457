// Meaning of valid problem files.
#include "leeway/planner/problem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "leeway/collision/convex_hull.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/did_you_mean.h"
#include "planner/validate/format_keys.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

using collision::ShapeType;

constexpr double kPi = 3.14159265358979323846;

Problem load(const std::string& text) { return loadProblem(Folder().write("problem.yaml", text)); }

std::string robot(const std::string& name, const std::string& group) {
  const std::string path = sourceFolder() + "/robots/" + name + "/" + name;
  return "leeway: 1\nrobot: {urdf: " + path + ".urdf, srdf: " + path + ".srdf, group: " + group +
         "}\n";
}

const std::string kArm6Ends = "start: home\ngoal: ready\n";

TEST(Problem, TakesStartsInEveryForm) {
  const std::vector<double> expected = {0.5, -1.5, 0.25, -1.0, 0.1, -0.2};
  for (const std::string form : {"[0.5, -1.5, 0.25, -1.0, 0.1, -0.2]",
                                 "{pan_joint: +0.5, elbow_joint: .25, lift_joint: -15e-1, "
                                 "wrist1_joint: -1, wrist3_joint: -0.2, wrist2_joint: 0.1}"})
    EXPECT_EQ(load(robot("arm6", "arm") + "start: " + form + "\ngoal: home\n").start, expected)
        << form;
  const Problem named = load(robot("arm6", "arm") + kArm6Ends);
  EXPECT_EQ(named.start[1], -1.5708);
  EXPECT_EQ(named.goals[0].name, "ready");
  EXPECT_EQ(named.goals[0].ranges[2], std::make_pair(1.9, 1.9));
}

TEST(Problem, TakesGoalsInEveryForm) {
  const Problem problem = load(robot("arm6", "arm") +
                               "start: home\ngoals:\n  - ready\n  - [0, [-1, 1], any, 0, 0, 0]\n" +
                               "  - {pan_joint: 1, lift_joint: [-1, -0.5], elbow_joint: any, "
                               "wrist1_joint: 0, wrist2_joint: 0, wrist3_joint: 0}\n");
  ASSERT_EQ(problem.goals.size(), 3U);
  EXPECT_EQ(problem.goals[0].name, "ready");
  EXPECT_EQ(problem.goals[1].name, "goal 2");
  EXPECT_EQ(problem.goals[1].ranges[1], std::make_pair(-1.0, 1.0));
  EXPECT_NEAR(problem.goals[1].ranges[2].second, kPi, 1e-5);
  EXPECT_EQ(problem.goals[2].ranges[1], std::make_pair(-1.0, -0.5));
}

TEST(Problem, PassiveJointsComeFromTheFile) {
  const std::string ends = "start: [0, 0, 0, 0, 0, 0, 0]\ngoal: ready\n";
  const auto finger = [](const Problem& problem) {
    return problem
        .start[static_cast<std::size_t>(problem.robot.model->findVariable("finger_joint"))];
  };
  EXPECT_EQ(finger(load(robot("arm7", "arm") + ends)), 0);
  EXPECT_EQ(finger(load(robot("arm7", "arm") + ends + "joints: {finger_joint: 0.04}\n")), 0.04);
  // Mimic and fixed joints may be named, as drivers do, but have no coordinate: a warning says so.
  const Problem follower =
      load(robot("arm7", "arm") + ends + "joints: {finger_right_joint: 0.04}\n");
  ASSERT_EQ(follower.warnings.size(), 1U);
  EXPECT_NE(follower.warnings[0].find("joint 'finger_right_joint' follows another joint"),
            std::string::npos);
}

TEST(Problem, BodiesStandWhereTheirPosesSay) {
  const std::string floating =
      "leeway: 1\nbody: {name: b, joint: floating, bounds: {lower: [-1, -1, -1], upper: [1, 1, "
      "1]}, shapes: [{sphere: {radius: 0.1}}]}\n";
  for (const std::string pose :
       {"{position: [0.1, 0.2, 0.3], rpy: [0, 0, 1.5707963267948966]}",
        "{position: [0.1, 0.2, 0.3], orientation: [0, 0, 0.70710678118654757, "
        "0.70710678118654757]}",
        "{b: {position: [0.1, 0.2, 0.3], rpy: [0, 0, 1.5707963267948966]}}",
        "[0.1, 0.2, 0.3, 0, 0, 0.70710678118654757, 0.70710678118654757]"}) {
    const Problem problem = load(floating + "start: " + pose + "\ngoal: {position: [0, 0, 0]}\n");
    const std::vector<double> expected = {0.1, 0.2, 0.3, 0, 0, std::sqrt(0.5), std::sqrt(0.5)};
    ASSERT_EQ(problem.start.size(), 7U);
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_NEAR(problem.start[i], expected[i], 1e-15) << pose << " " << i;
    EXPECT_EQ(problem.goals[0].ranges[6], std::make_pair(1.0, 1.0));
  }
  const Problem planar = load(
      "leeway: 1\nbody: {joint: planar, bounds: {lower: [-1, -1], upper: [1, 1]}, shapes: "
      "[{sphere: {radius: 0.1}}]}\n"
      "start: {position: [0.1, 0.2], angle: 7}\ngoal: {position: [any, [0, 0.5]], angle: any}\n");
  EXPECT_EQ(planar.start, (std::vector<double>{0.1, 0.2, 7}));
  EXPECT_EQ(planar.goals[0].ranges,
            (std::vector<std::pair<double, double>>{{-1, 1}, {0, 0.5}, {-kPi, kPi}}));
}

TEST(Problem, EveryWordForAShapeHasAReader) {
  const std::map<std::string_view, std::pair<ShapeType, std::string>> shapes = {
      {"box", {ShapeType::kBox, "{size: [1, 1, 1]}"}},
      {"sphere", {ShapeType::kSphere, "{radius: 1}"}},
      {"cylinder", {ShapeType::kCylinder, "{radius: 1, length: 1}"}},
      {"capsule", {ShapeType::kCapsule, "{radius: 1, length: 1}"}},
      {"cone", {ShapeType::kCone, "{radius: 1, height: 1}"}},
      {"ellipsoid", {ShapeType::kEllipsoid, "{semi_axes: [1, 1, 1]}"}},
      {"half_space", {ShapeType::kHalfSpace, "{}"}},
      {"mesh", {ShapeType::kMesh, "{file: " + sourceFolder() + "/problems/mesh/meshes/tote.obj}"}},
      {"convex_hull",
       {ShapeType::kConvexHull, "{points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}"}},
  };
  for (const std::string_view word : shapeWords()) {
    if (word == "height_field") continue;  // a file of heights; HeightField's tests read them
    ASSERT_TRUE(shapes.contains(word)) << word;
    const auto& [type, sizes] = shapes.at(word);
    const Problem problem = load(robot("arm6", "arm") + kArm6Ends + "objects: [{name: it, " +
                                 std::string(word) + ": " + sizes + "}]\n");
    EXPECT_EQ(problem.world.objects[0].geometries[0].shape.type(), type) << word;
  }
}

TEST(Problem, ShapesHaveTheSizesTheyName) {
  const Problem problem =
      load(robot("arm6", "arm") + kArm6Ends + R"(
objects:
  - {name: box, box: {size: [1, 2, 3]}}
  - {name: sphere, sphere: {radius: 0.5}}
  - {name: cylinder, cylinder: {radius: 0.5, length: 3}}
  - {name: capsule, capsule: {radius: 0.5, length: 3}}
  - {name: cone, cone: {radius: 0.5, height: 3}}
  - {name: ellipsoid, ellipsoid: {semi_axes: [1, 2, 3]}}
  - {name: floor, half_space: {}}
  - {name: hull, convex_hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}}
  - {name: tote, mesh: {file: )" +
           sourceFolder() + R"(/problems/mesh/meshes/tote.obj, scale: 2}}
  - {name: tote_hull, convex_hull: {file: )" +
           sourceFolder() + R"(/problems/mesh/meshes/tote.obj, scale: [1, 1, 2]}}
  - name: two
    position: [1, 0, 0]
    rpy: [0, 0, 1.5707963267948966]
    shapes:
      - {name: left, box: {size: [1, 1, 1]}, position: [0, 1, 0]}
      - {sphere: {radius: 1}}
)");
  const auto shape = [&](std::size_t i) { return problem.world.objects[i].geometries[0].shape; };
  ASSERT_EQ(problem.world.objects.size(), 11U);
  EXPECT_EQ(shape(0).halfExtents(), Eigen::Vector3d(0.5, 1, 1.5));
  EXPECT_EQ(shape(1).radius(), 0.5);
  for (std::size_t i = 2; i < 5; ++i) {
    EXPECT_EQ(shape(i).radius(), 0.5);
    EXPECT_EQ(shape(i).halfLength(), 1.5);
  }
  EXPECT_EQ(shape(2).type(), ShapeType::kCylinder);
  EXPECT_EQ(shape(3).type(), ShapeType::kCapsule);
  EXPECT_EQ(shape(4).type(), ShapeType::kCone);
  EXPECT_EQ(shape(5).halfExtents(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(shape(6).type(), ShapeType::kHalfSpace);
  EXPECT_EQ(shape(7).type(), ShapeType::kConvexHull);
  EXPECT_EQ(shape(8).type(), ShapeType::kMesh);
  EXPECT_NEAR(shape(8).boundingRadius(), 2 * 0.3448, 0.02);
  EXPECT_EQ(shape(9).type(), ShapeType::kConvexHull);
  const Object& two = problem.world.objects[10];
  EXPECT_EQ(two.geometries[0].name, "left");
  EXPECT_EQ(two.geometries[1].name, "two");
  const Eigen::Vector3d middle = two.X_WO * two.geometries[0].X_BG.translation;
  EXPECT_LT((middle - Eigen::Vector3d(0, 0, 0)).norm(), 1e-15);
}

TEST(Problem, SettingsHaveDefaultsAndAreTaken) {
  const Problem plain = load(robot("arm6", "arm") + kArm6Ends);
  EXPECT_EQ(plain.planner.name, "Connect");
  EXPECT_TRUE(std::holds_alternative<MinimumLength>(plain.objective));
  EXPECT_TRUE(plain.planner.simplify);
  EXPECT_EQ(plain.limits.time, 5);
  EXPECT_EQ(plain.limits.iterations, 0);
  EXPECT_EQ(plain.seed, 1U);
  EXPECT_EQ(plain.margins.common, 0);
  const Problem all = load(robot("arm6", "arm") + kArm6Ends + R"(
name: everything
objects: [{name: o, sphere: {radius: 0.1}}]
planner: {name: BITstar, parameters: {samples_per_batch: 50, use_k_nearest: false}}
objective: clearance
simplify: false
limits: {time: 2.5, iterations: 1000}
seed: 9007199254740993
margin: -0.001
margins: [{between: [o, tool_body], margin: 0.02}]
allowed: [[o, base]]
)");
  EXPECT_EQ(all.name, "everything");
  EXPECT_EQ(all.planner.name, "BITstar");
  EXPECT_EQ(all.planner.parameters, (std::map<std::string, std::string>{
                                        {"samples_per_batch", "50"}, {"use_k_nearest", "false"}}));
  EXPECT_TRUE(std::holds_alternative<MaximumClearance>(all.objective));
  EXPECT_FALSE(all.planner.simplify);
  EXPECT_EQ(all.limits.time, 2.5);
  EXPECT_EQ(all.limits.iterations, 1000);
  EXPECT_EQ(all.seed, 9007199254740993ULL);  // beyond double's integers
  EXPECT_EQ(all.margins.common, -0.001);
  ASSERT_EQ(all.margins.pairs.size(), 1U);
  EXPECT_EQ(all.margins.pairs[0].margin, 0.02);
  EXPECT_EQ(all.contacts.allowed,
            (std::vector<std::pair<std::string, std::string>>{{"o", "base"}}));
}

TEST(Problem, AGroupBesideItselfStandsForThePairsWithinIt) {
  const std::string base = robot("arm6", "arm") + kArm6Ends + R"(
objects: [{name: o, sphere: {radius: 0.1}}]
groups: {one: [o], ends: [tool_body, base]}
)";
  const Problem problem = load(base + "margins: [{between: [robot, robot], margin: 0.003}]\n");
  ASSERT_EQ(problem.margins.pairs.size(), 1U) << "the word stays, for what it takes hold of later";
  EXPECT_EQ(problem.margins.pairs[0].a + " " + problem.margins.pairs[0].b, "robot robot");
  const Problem ends = load(base + "margins: [{between: [ends, ends], margin: 0.003}]\n");
  ASSERT_EQ(ends.margins.pairs.size(), 1U);
  EXPECT_LT(ends.margins.pairs[0].a, ends.margins.pairs[0].b);
  for (const char* wrong : {"[one, one]", "[o, o]"})
    EXPECT_THROW(load(base + "margins: [{between: " + wrong + ", margin: 0.1}]\n"),
                 robots::InputError)
        << wrong;
}

/// A cart in the plane, a drone and an arm on one robot, in a folder of its own.
std::string cart(const Folder& folder, const std::string& keys) {
  folder.write("cart.urdf", R"(<robot name="cart"><link name="odom"/>
<link name="base"><collision><geometry><box size="0.6 0.4 0.2"/></geometry></collision></link>
<link name="drone"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry>
</collision></link>
<joint name="wheels" type="planar"><parent link="odom"/><child link="base"/><axis xyz="0 0 1"/></joint>
<joint name="flight" type="floating"><parent link="odom"/><child link="drone"/></joint>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>
<origin xyz="0 0 0.5"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>)");
  return folder.write("problem.yaml", "leeway: 1\nrobot: {urdf: cart.urdf}\n" + keys);
}

const std::string kCartEnds = R"(
start: {wheels: {position: [1, 2]}, flight: {position: [0, 0, 2]}, elbow: 0}
goal: {wheels: {position: [0, 0]}, flight: {position: [0, 0, 3]}, elbow: 0.5}
)";

TEST(Problem, BoundsOfPlanarAndFloatingJoints) {
  const Folder folder;
  const Problem problem = loadProblem(cart(
      folder, "bounds: {wheels: {x: [-5, 4], y: [-1, 3]}, flight: {z: [0, 3]}, elbow: [0, 1]}" +
                  kCartEnds));
  const robots::Model& model = *problem.robot.model;
  const auto bounds = [&](const std::string& name) {
    const robots::Variable& v = model.variables[static_cast<std::size_t>(model.findVariable(name))];
    return std::pair(v.lower, v.upper);
  };
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(bounds("wheels/x"), std::pair(-5.0, 4.0));
  EXPECT_EQ(bounds("wheels/y"), std::pair(-1.0, 3.0));
  EXPECT_EQ(bounds("wheels/theta"), std::pair(-kInfinite, kInfinite));
  EXPECT_EQ(bounds("flight/x"), std::pair(-kInfinite, kInfinite)) << "not named: as it was";
  EXPECT_EQ(bounds("flight/z"), std::pair(0.0, 3.0));
  EXPECT_EQ(bounds("elbow"), std::pair(0.0, 1.0));
}

TEST(Problem, BoundsWidenLimitsWhereTheySaySo) {
  const Folder folder;
  const Problem problem = loadProblem(
      cart(folder,
           "bounds: {elbow: {range: [-2, 3], widen: true}, wheels: {x: [-5, 4], y: [-1, "
           "3]}}" +
               kCartEnds));
  const robots::Model& model = *problem.robot.model;
  const auto& elbow = model.variables[static_cast<std::size_t>(model.findVariable("elbow"))];
  EXPECT_EQ(std::pair(elbow.lower, elbow.upper), std::pair(-2.0, 3.0));
  EXPECT_EQ(elbow.narrowed_by, "bounds.elbow (" + folder.path("problem.yaml") + ":3)");
}

/// Returns the message about a wrong file.
std::string messageOf(const std::string& file) {
  try {
    loadProblem(file);
  } catch (const robots::InputError& error) {
    return error.what();
  }
  return "loaded";
}

TEST(Problem, WrongBoundsAreRefusedWhereTheyStand) {
  const std::pair<std::string, std::string> wrong[] = {
      {"{wheel: {x: [0, 1]}}",
       ":3: bounds.wheel.x: no joint is named 'wheel'; did you mean 'wheels'?"},
      {"{elbow: {x: [0, 1]}}",
       "bounds.elbow.x: axis 'x' is not known; a lower and an upper bound are expected"},
      {"{elbow: [-2, 1]}",
       ":3: bounds.elbow: the bounds of joint 'elbow' are -2 to 1, outside its own limits"},
      {"{elbow: {range: [-2, 1], widen: false}}",
       "a range within -1 to 1, or 'widen', is expected"},
      {"{elbow: {range: [-2, 1], x: [0, 1]}}", "key 'x' stands beside 'range' in bounds.elbow"},
      {"{elbow: {widen: true}}", "bounds.elbow.widen has no 'range' beside it"},
      {"{elbow: {range: [0, 1], widen: 3}}", "bounds.elbow.widen"},
      {"{elbow: [0]}", "bounds.elbow is a list of 1; [lower, upper] is expected"},
      {"{wheels: [0, 1]}",
       "bounds.wheels: joint 'wheels' is planar; bounds of x and y are expected"},
      {"{elbow: [-0.5, 0.4]}",
       "joint 'elbow' at 0.5, outside its limits; -0.5 to 0.4 is expected, because of "
       "bounds.elbow"},
      {"{wheels: {z: [0, 1]}}", "axis 'z' is not known; x or y is expected"},
      {"{wheels: {theta: [0, 1]}}", "unknown key 'theta'"},
      {"{wheels: {x: [1, 0]}}", "the lower bound 1 of joint 'wheels/x' is above the upper bound 0"},
      {"{wheels: {x: [0, 1e300]}}", "coordinates up to"},
      {"{wheels: {x: [0]}}", "is a list of 1; [lower, upper] is expected"},
      {"{wheels: {x: 3}}", "bounds.wheels.x"},
      {"{wheels: {x: [2, 5]}}", "joint 'wheels/x' at 1, outside its limits; 2 to 5 is expected"},
  };
  for (const auto& [bounds, words] : wrong) {
    const Folder folder;
    const std::string message = messageOf(cart(folder, "bounds: " + bounds + kCartEnds));
    EXPECT_NE(message.find(words), std::string::npos) << bounds << '\n' << message;
  }
  EXPECT_NE(messageOf(Folder().write("body.yaml", R"(leeway: 1
body: {joint: planar, bounds: {lower: [0, 0], upper: [1, 1]}, shapes: [{sphere: {radius: 0.1}}]}
bounds: {body: {x: [0, 1]}}
start: {position: [0, 0]}
goal: {position: [1, 1]}
)"))
                .find(":3: key 'bounds' stands beside 'body'"),
            std::string::npos);
}

TEST(Problem, ARobotStandsWhereTheFileSaysIt) {
  const auto urdf = sourceFolder() + "/robots/arm6/arm6.urdf";
  const auto at = [&](const std::string& pose) {
    return load("leeway: 1\nrobot: {urdf: " + urdf + pose +
                "}\nstart: [0, -1, 1, 0, 0.3, 0]\ngoal: [0.5, -1, 1, 0, 0.3, 0]\n");
  };
  const Problem moved = at(", position: [1, 2, 0.5], rpy: [0, 0, 1.5707963267948966]");
  const Problem fixed = at("");
  const std::size_t links = fixed.robot.model->links.size();
  std::vector<robots::Pose> X_WL(links), X_BL(links);
  robots::forwardKinematics(*moved.robot.model, moved.start, X_WL);
  robots::forwardKinematics(*fixed.robot.model, fixed.start, X_BL);
  for (std::size_t l = 0; l < links; ++l) {
    const Eigen::Vector3d& p = X_BL[l].translation;
    EXPECT_LT((X_WL[l].translation - Eigen::Vector3d(1 - p.y(), 2 + p.x(), 0.5 + p.z())).norm(),
              1e-12)
        << l;
  }
  const Problem turned = at(", orientation: [0, 0, 1, 0]");
  EXPECT_NEAR(turned.robot.model->joints[0].X_PJ.rotation(0, 0), -1, 1e-15);
  const Folder folder;
  const std::string file =
      folder.write("free.yaml", "leeway: 1\nrobot:\n  urdf: " + urdf + "\n  position: [1, 2]\n" +
                                    "start: [0, -1, 1, 0, 0.3, 0]\ngoal: [0, -1, 1, 0, 0.3, 0]\n");
  EXPECT_NE(messageOf(file).find("free.yaml:4: robot.position"), std::string::npos)
      << messageOf(file);
}

/// Names of the values that a state of every robot has, and of states of joints that are not
/// planned.
TEST(Problem, EveryRobotHasTheStatesZeroAndMiddle) {
  const Folder folder;
  folder.write("two.urdf",
               R"(<robot name="two"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="x" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="0.5" upper="2.5" effort="1" velocity="1"/></joint>
<joint name="y" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint>
<joint name="grip" type="prismatic"><parent link="c"/><child link="d"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.08" effort="1" velocity="1"/></joint></robot>)");
  folder.write("two.srdf",
               R"(<robot name="two"><group name="arm"><joint name="x"/><joint name="y"/></group>
<group name="hand"><joint name="grip"/></group><group name="also"><joint name="grip"/></group>
<group_state name="open" group="hand"><joint name="grip" value="0.07"/></group_state>
<group_state name="shut" group="hand"><joint name="grip" value="0"/></group_state>
<group_state name="shut" group="also"><joint name="grip" value="0.01"/></group_state>
<group_state name="home" group="arm"><joint name="x" value="1"/><joint name="y" value="1"/></group_state>
</robot>)");
  const auto file = [&](const std::string& keys) {
    return folder.write("problem.yaml",
                        "leeway: 1\nrobot: {urdf: two.urdf, srdf: two.srdf, group: arm}\n" + keys);
  };
  const std::string ends = "start: zero\ngoal: middle\n";
  const Problem problem = loadProblem(file("joints: open\n" + ends));
  EXPECT_EQ(problem.start, (std::vector<double>{0.5, 0, 0.07}));
  EXPECT_EQ(problem.goals[0].ranges, (std::vector<std::pair<double, double>>{{1.5, 1.5}, {0, 0}}));
  EXPECT_EQ(problem.goals[0].name, "middle");
  EXPECT_EQ(loadProblem(file("joints: middle\n" + ends)).start[2], 0.04);
  const std::pair<std::string, std::string> wrong[] = {
      {"opn", ":3: no group state 'opn' for joints that are not planned; did you mean 'open'?"},
      {"home", ":3: no group state 'home' for joints that are not planned"},
      {"shut", ":3: the groups 'hand' and 'also' both have a state 'shut'"}};
  for (const auto& [name, words] : wrong) {
    const std::string message = messageOf(file("joints: " + name + "\n" + ends));
    EXPECT_NE(message.find(words), std::string::npos) << message;
  }
  // A name that the SRDF gives is the SRDF's.
  std::string srdf = readText(folder.path("two.srdf"));
  srdf.replace(srdf.find("\"home\""), 6, "\"zero\"");
  folder.write("two.srdf", srdf);
  EXPECT_EQ(loadProblem(file(ends)).start, (std::vector<double>{1, 1, 0}));
}

TEST(Problem, AWholeRobotAndTheWholeWorldInMargins) {
  const std::string base = robot("arm6", "arm") + kArm6Ends + R"(
objects: [{name: o, sphere: {radius: 0.1}}, {name: p, sphere: {radius: 0.1}}]
groups: {things: [tool_body, base]}
)";
  const auto pairs = [&](const std::string& between) {
    return load(base + "margins: [{between: " + between + ", margin: 0.05}]\n").margins.pairs;
  };
  ASSERT_EQ(pairs("[robot, world]").size(), 1U);
  EXPECT_EQ(pairs("[robot, world]")[0].a, "robot");
  EXPECT_EQ(pairs("[world, robot]")[0].a, "world");
  EXPECT_EQ(pairs("[world, tool_body]").size(), 1U);
  ASSERT_EQ(pairs("[things, world]").size(), 2U);
  EXPECT_EQ(pairs("[things, world]")[1].b, "world");
  const std::pair<std::string, std::string> wrong[] = {
      {"margins: [{between: [world, world], margin: 0.1}]", "'world' stands twice"},
      {"margins: [{between: [tol_body, world], margin: 0.1}]",
       "no link or object is named 'tol_body'; did you mean 'tool_body'?"},
      {"margins: [{between: [robot, world], wish: 0.1}]", "in margins only"},
      {"allowed: [[robot, world]]", "in margins only"},
  };
  for (const auto& [key, words] : wrong) {
    const std::string message = messageOf(Folder().write("problem.yaml", base + key + "\n"));
    EXPECT_NE(message.find(words), std::string::npos) << key << '\n' << message;
  }
  const std::string named = messageOf(Folder().write(
      "problem.yaml", robot("arm6", "arm") + kArm6Ends +
                          "objects: [{name: world, sphere: {radius: 0.1}, position: [9, 0, 0]}]\n"
                          "margins: [{between: [robot, world], margin: 0.1}]\n"));
  EXPECT_NE(named.find("'world' stands for the world and for all objects; another name"),
            std::string::npos)
      << named;
}

TEST(Problem, AJointHasItsValueOnce) {
  const std::string text = robot("arm7", "arm") + R"(joints: {finger_joint: 0.03}
goal: ready
start: {joint1: 0, joint2: 0, joint3: 0, joint4: -1.6, joint5: 0, joint6: 1, joint7: 0)";
  EXPECT_NO_THROW(load(text + "}\n"));
  const std::string message =
      messageOf(Folder().write("problem.yaml", text + ", finger_joint: 0}\n"));
  EXPECT_NE(message.find("start gives joint 'finger_joint', which has a value under 'joints'"),
            std::string::npos)
      << message;
}

TEST(Problem, GroupsStandForTheirMembersAndObjectivesSayMore) {
  const std::string base = robot("arm6", "arm") + kArm6Ends + R"(
objects: [{name: o, sphere: {radius: 0.1}}, {name: p, sphere: {radius: 0.1}}]
groups: {things: [o, p]}
)";
  const Problem problem = load(base + R"(
margins: [{between: [robot, things], margin: 0.02}, {between: [tool_body, p], margin: 0.01}]
allowed: [[things, base]]
objective: {length: {clearance: 0.03}}
push: false
)");
  std::vector<std::string> pairs;
  for (const PairMargin& pair : problem.margins.pairs) pairs.push_back(pair.a + " " + pair.b);
  EXPECT_EQ(pairs, (std::vector<std::string>{"robot o", "robot p", "tool_body p"}));
  EXPECT_EQ(problem.contacts.allowed,
            (std::vector<std::pair<std::string, std::string>>{{"o", "base"}, {"p", "base"}}));
  ASSERT_TRUE(std::holds_alternative<MinimumLength>(problem.objective));
  EXPECT_EQ(std::get<MinimumLength>(problem.objective).clearance, 0.03);
  EXPECT_FALSE(problem.planner.push);
  const Problem wide = load(base + "objective: {clearance: {of: all}}\n");
  ASSERT_TRUE(std::holds_alternative<MaximumClearance>(wide.objective));
  EXPECT_EQ(std::get<MaximumClearance>(wide.objective).of, Pairs::kAll);
  EXPECT_EQ(std::get<MaximumClearance>(wide.objective).at_most_longer,
            std::numeric_limits<double>::infinity());
  const Problem limited = load(base + "objective: {clearance: {at_most_longer: 0.2}}\n");
  EXPECT_EQ(std::get<MaximumClearance>(limited.objective).at_most_longer, 0.2);
  for (const char* wrong :
       {"objective: {length: {clearance: -1}}\n", "objective: {clearance: {of: me}}\n",
        "objective: {clearance: {at_most_longer: -0.1}}\n", "objective: {}\n",
        "objective: {length: {}, clearance: {}}\n",
        "margins: [{between: [robot, thing], margin: 0}]\n"})
    EXPECT_THROW(load(base + wrong), robots::InputError) << wrong;
  for (const char* wrong :
       {"groups: {o: [p]}\n", "groups: {robot: [p]}\n", "groups: {a: []}\n", "groups: {a: [q]}\n"})
    EXPECT_THROW(load(robot("arm6", "arm") + kArm6Ends +
                      "objects: [{name: o, sphere: {radius: 0.1}}, {name: p, sphere: {radius: "
                      "0.1}}]\n" +
                      wrong),
                 robots::InputError)
        << wrong;
}

TEST(Problem, WishesAndCostsAreTaken) {
  const std::string base = robot("arm6", "arm") + kArm6Ends + R"(
objects: [{name: o, sphere: {radius: 0.1}}, {name: p, sphere: {radius: 0.1}}]
groups: {things: [o, p]}
margin: 0.01
)";
  const Problem problem = load(base + R"(
margins: [{between: [robot, things], margin: 0.02, wish: 0.1, weight: 3}, {between: [tool_body, p], wish: 0.2}]
objective: {weighted: {length: 1, integral: [{hinge: 0.1, weight: 5}, {inverse: 0.02, of: self}], worst: {hinge: 0.05, of: all, weight: 2}}}
)");
  const std::size_t links = problem.robot.model->links.size();
  EXPECT_EQ(problem.margins.pairs.size(), 2U) << "a wish alone is no margin";
  ASSERT_EQ(problem.margins.wishes.size(), 2U);
  const Wish& wish = problem.margins.wishes[0];
  EXPECT_EQ(wish.name, "robot and things");
  EXPECT_EQ(wish.pairs.size(), 2 * links);
  EXPECT_EQ(wish.clearance, 0.1);
  EXPECT_EQ(wish.weight, 3);
  EXPECT_EQ(problem.margins.wishes[1].weight, 1);
  ASSERT_TRUE(std::holds_alternative<MinimumCost>(problem.objective));
  const auto& cost = std::get<MinimumCost>(problem.objective);
  EXPECT_STREQ(toString(problem.objective), "weighted");
  EXPECT_EQ(cost.length, 1);
  ASSERT_EQ(cost.terms.size(), 3U);
  EXPECT_EQ(cost.terms[0].weight, 5);
  EXPECT_EQ(cost.terms[1].nearness.kind, Nearness::Kind::kInverse);
  EXPECT_EQ(cost.terms[1].of, Pairs::kSelf);
  EXPECT_FALSE(cost.terms[1].worst);
  EXPECT_TRUE(cost.terms[2].worst);
  EXPECT_EQ(cost.terms[2].of, Pairs::kAll);
  const Problem integral = load(base + "objective: {integral: {hinge: 0.1}}\n");
  EXPECT_STREQ(toString(integral.objective), "integral");
  EXPECT_EQ(std::get<MinimumCost>(integral.objective).length, 0);
  for (const char* wrong :
       {"objective: {integral: {hinge: 0}}\n", "objective: {integral: {}}\n",
        "objective: {integral: {hinge: 0.1, inverse: 0.1}}\n",
        "objective: {integral: {hinge: 0.1, weight: 1}}\n", "objective: {weighted: {}}\n",
        "objective: {weighted: {length: 0}}\n", "objective: {weighted: {length: -1}}\n",
        "objective: {weighted: {integral: {hinge: 0.1, weight: 0}}}\n",
        "objective: {integral: {hinge: 0.1, of: us}}\n",
        "objective: {length: {}, integral: {hinge: 0.1}}\n", "objective: integral\n",
        "margins: [{between: [o, tool_body], wish: 0.005}]\n",
        "margins: [{between: [o, tool_body], margin: 0.2, wish: 0.2}]\n",
        "margins: [{between: [o, tool_body], wish: 0.1, weight: 0}]\n",
        "margins: [{between: [o, tool_body], margin: 0.1, weight: 1}]\n",
        "margins: [{between: [o, tool_body]}]\n",
        "margins: [{between: [o, tool_body], wish: 0.1}]\nobjective: clearance\n"})
    EXPECT_THROW(load(base + wrong), robots::InputError) << wrong;
}

TEST(Problem, NumbersAreReadExactly) {
  const Problem problem = load(
      robot("arm6", "arm") +
      "start: [0.1, 1e-300, 0.30000000000000004, 4.9406564584124654e-324, 1, -0.0]\ngoal: home\n");
  EXPECT_EQ(problem.start, (std::vector<double>{0.1, 1e-300, 0.30000000000000004, 5e-324, 1, 0}));
  EXPECT_TRUE(std::signbit(problem.start[5]));
}

// ---- Attached objects ----

/// Pose of an object in the world at the robot's start.
robots::Pose worldPose(const Problem& problem, const std::string& name) {
  for (const Object& object : problem.world.objects)
    if (object.name == name) return object.X_WO;
  std::vector<robots::Pose> X_WL(problem.robot.model->links.size());
  robots::forwardKinematics(*problem.robot.model, problem.start, X_WL);
  for (const Attachment& attachment : problem.robot.attachments)
    if (attachment.object.name == name)
      return X_WL[static_cast<std::size_t>(attachment.link)] * attachment.X_LO;
  throw std::logic_error("no such object");
}

double difference(const robots::Pose& a, const robots::Pose& b) {
  return (a.rotation - b.rotation).norm() + (a.translation - b.translation).norm();
}

TEST(AttachedObjects, AreReadInTheFrameOfTheirLink) {
  const Problem problem = loadProblem(sourceFolder() + "/problems/bin/pick.yaml");
  ASSERT_EQ(problem.robot.attachments.size(), 1U);
  const Attachment& can = problem.robot.attachments[0];
  EXPECT_EQ(can.object.name, "can");
  EXPECT_EQ(problem.robot.model->links[static_cast<std::size_t>(can.link)].name, "tool");
  EXPECT_EQ(can.X_LO.translation, Eigen::Vector3d(0, 0, 0.02));
  EXPECT_EQ(can.touch_links.size(), 3U);
}

TEST(AttachedObjects, StayWhereTheyAreWhenPutDownAndTakenUp) {
  const Problem held = loadProblem(sourceFolder() + "/problems/bin/pick.yaml");
  const robots::Pose before = worldPose(held, "can");
  const Problem down = detachObject(held, "can");
  EXPECT_TRUE(down.robot.attachments.empty());
  EXPECT_EQ(down.world.objects.size(), held.world.objects.size() + 1);
  EXPECT_LT(difference(worldPose(down, "can"), before), 1e-15);
  const Problem again = attachObject(down, "can", "tool", {"hand", "finger_left", "finger_right"});
  EXPECT_EQ(again.world.objects.size(), held.world.objects.size());
  ASSERT_EQ(again.robot.attachments.size(), 1U);
  EXPECT_LT(difference(worldPose(again, "can"), before), 1e-14);
  EXPECT_LT(difference(again.robot.attachments[0].X_LO, held.robot.attachments[0].X_LO), 1e-14);
  EXPECT_EQ(again.robot.attachments[0].touch_links, held.robot.attachments[0].touch_links);
  EXPECT_EQ(held.robot.attachments.size(), 1U);  // the argument is unchanged
}

TEST(AttachedObjects, CanBePutDownElsewhere) {
  const Problem held = loadProblem(sourceFolder() + "/problems/bin/pick.yaml");
  std::vector<double> goal = held.start;
  for (std::size_t i = 0; i < held.robot.variables.size(); ++i)
    goal[static_cast<std::size_t>(held.robot.variables[i])] = held.goals[0].ranges[i].first;
  const Problem down = detachObject(held, "can", goal);
  // In the other box, 0.32 m to the left.
  EXPECT_NEAR(worldPose(down, "can").translation.y(), 0.32, 0.01);
  EXPECT_NEAR(worldPose(down, "can").translation.x(), 0.52, 0.01);
}

/// A held object may touch the links named for it, and collides with all else.
TEST(AttachedObjects, MayTouchOnlyWhatIsNamed) {
  const Problem held = loadProblem(sourceFolder() + "/problems/bin/pick.yaml");
  const auto verdict = [](const Problem& problem) {
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    std::vector<double> start;
    for (const int v : problem.robot.variables)
      start.push_back(problem.start[static_cast<std::size_t>(v)]);
    return certifier.decide(start);
  };
  EXPECT_EQ(verdict(held), collision::Verdict::kFree);
  // A pin along the hand's axis into link6; joint7 turns it there.
  Problem pin = held;
  pin.robot.attachments[0].object.geometries[0].shape = collision::Shape::cylinder(0.01, 0.12);
  pin.robot.attachments[0].X_LO.translation.z() = -0.125;
  EXPECT_EQ(verdict(pin), collision::Verdict::kNotFree);
  pin.robot.attachments[0].touch_links.push_back(pin.robot.model->findLink("link6"));
  EXPECT_EQ(verdict(pin), collision::Verdict::kFree);
  // Detached, it is an obstacle to all of them.
  EXPECT_EQ(verdict(detachObject(pin, "can")), collision::Verdict::kNotFree);
}

TEST(AttachedObjects, UnknownNamesAreRefused) {
  const Problem held = loadProblem(sourceFolder() + "/problems/bin/pick.yaml");
  EXPECT_THROW(attachObject(held, "can", "tool"), std::invalid_argument);  // already held
  EXPECT_THROW(attachObject(held, "box_a", "tol"), std::invalid_argument);
  EXPECT_THROW(attachObject(held, "box_a", "tool", {"hnd"}), std::invalid_argument);
  EXPECT_THROW(detachObject(held, "box_a"), std::invalid_argument);
  EXPECT_THROW(detachObject(held, "can", std::vector<double>{1, 2}), std::invalid_argument);
  EXPECT_EQ(attachObject(held, "box_a", "tool").robot.attachments.size(), 2U);
}

// ---- Without a file ----

TEST(ProblemFromStates, TakesGroupStates) {
  const auto model = robots::loadModel(sourceFolder() + "/robots/arm6/arm6.urdf",
                                       sourceFolder() + "/robots/arm6/arm6.srdf");
  const Problem problem = problemFromStates(model, "arm", "home", "ready");
  EXPECT_EQ(problem.robot.variables.size(), 6U);
  EXPECT_EQ(problem.start[1], -1.5708);
  EXPECT_EQ(problem.goals[0].name, "ready");
  EXPECT_TRUE(problem.world.objects.empty());
  const auto message = [&](const char* group, const char* start) -> std::string {
    try {
      problemFromStates(model, group, start, "ready");
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message("amr", "home"),
            "robot 'arm6' has no group or joint 'amr'; did you mean 'arm'?");
  EXPECT_EQ(message("arm", "hoem"),
            "no group state 'hoem' for the planned joints; did you mean 'home'?");
  const Problem values = problemFromStates(model, "arm", "0 -1.5, 1.5,0 0 0", "1 0 0 0 0 6.2");
  EXPECT_EQ(values.start[1], -1.5);
  EXPECT_EQ(values.goals[0].name, "goal");
  EXPECT_EQ(values.goals[0].ranges[5], std::pair(6.2, 6.2));
  EXPECT_EQ(message("arm", "0,,0,0,0,0,0"),
            "value 2 of start '0,,0,0,0,0,0' is empty; 6 numbers are expected, of pan_joint, "
            "lift_joint, elbow_joint, wrist1_joint, wrist2_joint, wrist3_joint");
  EXPECT_EQ(message("arm", "0,0,0,0,0,0, ").substr(0, 41),
            "value 7 of start '0,0,0,0,0,0, ' is empty");
  EXPECT_EQ(message("arm", "0 1"),
            "start '0 1' is 2 numbers; 6 are expected, of pan_joint, lift_joint, elbow_joint, "
            "wrist1_joint, wrist2_joint, wrist3_joint");
  EXPECT_EQ(
      message("arm", "0 0 0 0 0 7"),
      "start has joint 'wrist3_joint' at 7, outside its limits; -6.28319 to 6.28319 is expected");
}

// ---- The robots ----

/// Our descriptions disable only neighbouring pairs, and the two fingers of one hand.
TEST(ShippedRobots, DisableOnlyNeighbours) {
  for (const std::string name : {"arm6", "arm7", "dual_arm", "snake10"}) {
    const std::string path = sourceFolder() + "/robots/" + name + "/" + name;
    const auto model = robots::loadModel(path + ".urdf", path + ".srdf");
    EXPECT_TRUE(model->warnings.empty()) << name;
    EXPECT_GE(model->disabled_pairs.size(), 6U) << name;
    for (const robots::DisabledPair& pair : model->disabled_pairs) {
      const int a = pair.link_a, b = pair.link_b;
      const auto parent = [&](int link) {
        return model->joints[static_cast<std::size_t>(link)].parent_link;
      };
      EXPECT_TRUE(parent(a) == b || parent(b) == a || (name == "arm7" && parent(a) == parent(b)))
          << name << ": " << model->links[static_cast<std::size_t>(a)].name << " and "
          << model->links[static_cast<std::size_t>(b)].name;
    }
  }
}

TEST(ShippedRobots, HaveThePublishedReach) {
  const auto reach = [](const std::string& name, const std::string& link,
                        const std::vector<double>& q) {
    const std::string path = sourceFolder() + "/robots/" + name + "/" + name;
    const auto model = robots::loadModel(path + ".urdf", path + ".srdf");
    std::vector<double> all = model->defaultConfiguration();
    std::copy(q.begin(), q.end(), all.begin());
    std::vector<robots::Pose> X_WL(model->links.size());
    robots::forwardKinematics(*model, all, X_WL);
    return X_WL[static_cast<std::size_t>(model->findLink(link))].translation;
  };
  EXPECT_LT((reach("arm7", "hand", {}) - Eigen::Vector3d(0, 0, 0.36 + 0.42 + 0.40 + 0.126)).norm(),
            1e-12);
  EXPECT_LT((reach("arm6", "tool_body", {}) -
             Eigen::Vector3d(0.425 + 0.3922, 0.1333 + 0.0996, 0.1625 - 0.0997))
                .norm(),
            1e-12);
  EXPECT_LT((reach("snake10", "link10", {}) - Eigen::Vector3d(9 * 0.12, 0, 0.03)).norm(), 1e-12);
}

TEST(DidYouMean, HelpsOnlyWhenNear) {
  EXPECT_EQ(didYouMean("forarm", {"base", "forearm"}), "; did you mean 'forearm'?");
  EXPECT_EQ(didYouMean("ofrearm", {"base", "forearm"}), "; did you mean 'forearm'?");
  EXPECT_EQ(didYouMean("FOREARM", {"base", "forearm"}), "; did you mean 'forearm'?");
  EXPECT_EQ(didYouMean("gripper", {"base", "forearm"}), "; known: base, forearm");
  EXPECT_EQ(didYouMean("x", {}), "; there is none");
}

}  // namespace
}  // namespace leeway::planner
