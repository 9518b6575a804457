#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <set>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/random.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

/// A robot of two arms whose description splits one link's geometry, as some real ones do: torso_2
/// is fixed to torso and unknown to every matrix. `knob` is fixed to the torso as well, but is
/// separate.
constexpr const char* kUrdf = R"(<robot name="twins">
  <link name="torso"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="torso_2"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="knob"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="left"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="left_tip"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="right"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="torso_2_joint" type="fixed"><parent link="torso"/><child link="torso_2"/></joint>
  <joint name="knob_joint" type="fixed"><parent link="torso"/><child link="knob"/></joint>
  <joint name="left_joint" type="revolute"><parent link="torso"/><child link="left"/><axis xyz="0 0 1"/>
    <origin xyz="0 1 0"/><limit lower="-3.14159" upper="3.14159" velocity="1" effort="1"/></joint>
  <joint name="left_tip_joint" type="continuous"><parent link="left"/><child link="left_tip"/><axis xyz="0 0 1"/><origin xyz="1 0 0"/></joint>
  <joint name="right_joint" type="prismatic"><parent link="torso"/><child link="right"/><axis xyz="0 0 1"/>
    <origin xyz="0 -1 0"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint>
</robot>)";

constexpr const char* kSrdf = R"(<robot name="twins">
  <group name="both"><joint name="left_joint"/><joint name="left_tip_joint"/><joint name="right_joint"/></group>
  <group name="left"><joint name="left_joint"/><joint name="left_tip_joint"/></group>
  <virtual_joint name="base_joint" type="floating" parent_frame="world" child_link="torso"/>
  <disable_collisions link1="knob" link2="right" reason="Never"/>
  <disable_collisions link1="left" link2="right" reason="Never"/>
</robot>)";

constexpr const char* kMatrix = R"(
allowed_collision_matrix:
  entry_names: [left, torso, left_tip, can, ghost]
  entry_values:
    - [false, true, true, false, false]
    - [true, false, false, false, false]
    - [true, false, false, true, false]
    - [false, false, true, false, false]
    - [false, false, false, false, false]
)";

constexpr const char* kObjects = R"(
world:
  collision_objects:
    - primitive_poses: [{orientation: [0, 0, 0, 1], position: [0, 0, 5]}]
      primitives: [{dimensions: [1, 0.5], type: cylinder}]
      id: can
      pose: {orientation: [0, 0, 0.70710678118654757, 0.70710678118654757], position: [10, 0, 0]}
    - id: box
      header: {frame_id: ""}
      primitives: [{type: box, dimensions: [1, 2, 3]}, {type: sphere, dimensions: [4]}, {type: cone, dimensions: [5, 6]}]
      primitive_poses: [{position: [20, 0, 0]}, {position: [30, 0, 0], orientation: [0, 0, 0, 1]}, {}]
)";

constexpr const char* kRequest = R"(
group_name: both
planner_id: NoSuchPlanner
allowed_planning_time: 0
start_state:
  joint_state: {position: [0.5, 7, 0.25, 9], name: [right_joint, left_tip_joint, left_joint, no_such_joint]}
  multi_dof_joint_state: {joint_names: [base_joint], transforms: [{rotation: [0, 0, 0, 1], translation: [0, 0, 0]}], twist: [], wrench: []}
goal_constraints:
  - joint_constraints:
      - {position: -3.14159265, joint_name: left_joint}
      - {joint_name: right_joint, position: 1}
      - {joint_name: left_tip_joint, position: -0.5}
)";

class MoveitImport : public testing::Test {
 protected:
  MoveitImport() {
    model_ =
        robots::loadModel(folder_.write("twins.urdf", kUrdf), folder_.write("twins.srdf", kSrdf));
  }
  Problem load(const std::string& scene, const std::string& request) const {
    return loadMoveit(model_, folder_.write("scene.yaml", scene),
                      folder_.write("request.yaml", request));
  }
  /// The message without the folder.
  std::string messageOf(const std::string& scene, const std::string& request) const {
    try {
      load(scene, request);
    } catch (const robots::InputError& error) {
      return std::string(error.what()).substr(folder_.path().size() + 1);
    }
    return "accepted";
  }
  static bool warns(const Problem& problem, const std::string& what) {
    return std::any_of(problem.warnings.begin(), problem.warnings.end(), [&](const auto& warning) {
      return warning.find(what) != std::string::npos;
    });
  }
  double start(const Problem& problem, const std::string& variable) const {
    return problem.start[static_cast<std::size_t>(model_->findVariable(variable))];
  }

  Folder folder_;
  std::shared_ptr<const robots::Model> model_;
};

const std::string kScene =
    std::string("name: s\nfixed_frame_transforms: []\n") + kMatrix + kObjects;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t place = text.find(what);
  EXPECT_NE(place, std::string::npos) << what;
  return text.replace(place, what.size(), by);
}

/// As MotionBenchMaker's own library writes meshes: a file and its scale.
TEST_F(MoveitImport, MeshesMayBeFiles) {
  folder_.write("props/tip.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  const auto withMesh = [&](const std::string& mesh) {
    return replaced(
        kScene, "id: box\n",
        "id: box\n      mesh_poses: [{position: [0, 0, 7]}]\n      meshes: [" + mesh + "]\n");
  };
  for (const char* resource : {"package://props/tip.obj", "props/tip.obj"}) {
    const Problem problem = load(
        withMesh(std::string("{resource: '") + resource + "', dimensions: [2, 3, 4]}"), kRequest);
    const robots::Geometry& mesh = problem.world.objects[1].geometries.back();
    ASSERT_NE(mesh.shape.mesh(), nullptr);
    double highest = 0;
    for (const Eigen::Vector3d& v : mesh.shape.mesh()->vertices())
      highest = std::max(highest, (mesh.X_BG * v).z());
    EXPECT_EQ(highest, 11);
  }
  const std::string own = "vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]";
  EXPECT_NE(messageOf(withMesh("{resource: props/tip.obj, " + own + "}"), kRequest)
                .find("vertices stands beside 'resource'"),
            std::string::npos);
  EXPECT_NE(messageOf(withMesh("{dimensions: [10, 10, 10], " + own + "}"), kRequest)
                .find("dimensions is the scale of a 'resource', which is missing"),
            std::string::npos);
  const std::string lost = messageOf(withMesh("{resource: 'package://lost/can.stl'}"), kRequest);
  EXPECT_EQ(lost.rfind("scene.yaml:21: the mesh \"package://lost/can.stl\" was not found", 0), 0U)
      << lost;
  EXPECT_NE(lost.find("--package lost=FOLDER"), std::string::npos) << lost;
  ProblemOptions options;
  options.load.packages = {{"lost", folder_.path("props")}};
  const Problem found = loadMoveit(
      model_, folder_.write("scene.yaml", withMesh("{resource: 'package://lost/tip.obj'}")),
      folder_.write("request.yaml", kRequest), options);
  EXPECT_NE(found.world.objects[1].geometries.back().shape.mesh(), nullptr);
}

TEST_F(MoveitImport, ObjectsHaveFullEdgesHeightBeforeRadiusAndBothPoses) {
  const Problem problem = load(kScene, kRequest);
  ASSERT_EQ(problem.world.objects.size(), 2U);
  const Object& can = problem.world.objects[0];
  EXPECT_EQ(can.name, "can");
  EXPECT_EQ(can.geometries[0].shape.type(), collision::ShapeType::kCylinder);
  EXPECT_EQ(can.geometries[0].shape.halfLength(), 0.5);
  EXPECT_EQ(can.geometries[0].shape.radius(), 0.5);
  const robots::Pose X_WG = can.X_WO * can.geometries[0].X_BG;
  EXPECT_LT((X_WG.translation - Eigen::Vector3d(10, 0, 5)).norm(), 1e-14);
  EXPECT_LT((X_WG.rotation.col(0) - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  const Object& box = problem.world.objects[1];
  ASSERT_EQ(box.geometries.size(), 3U);
  EXPECT_EQ(box.geometries[0].shape.halfExtents(), Eigen::Vector3d(0.5, 1, 1.5));
  EXPECT_EQ(box.geometries[1].shape.radius(), 4);
  EXPECT_EQ(box.geometries[2].shape.halfLength(), 2.5);
  EXPECT_EQ(box.geometries[2].shape.radius(), 6);
  EXPECT_EQ((box.X_WO * box.geometries[0].X_BG).translation, Eigen::Vector3d(20, 0, 0));
}

TEST_F(MoveitImport, JointsGoByNameNotByPlace) {
  const Problem problem = load(kScene, kRequest);
  ASSERT_EQ(problem.robot.variables.size(), 3U);
  EXPECT_EQ(start(problem, "left_joint"), 0.25);
  EXPECT_EQ(start(problem, "left_tip_joint"), 7);
  EXPECT_EQ(start(problem, "right_joint"), 0.5);
  ASSERT_EQ(problem.goals.size(), 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string& name =
        model_->variables[static_cast<std::size_t>(problem.robot.variables[i])].name;
    // Pi, truncated to six digits in the robot's limit, maps to the limit.
    const double expected = name == "left_joint" ? -3.14159 : name == "right_joint" ? 1 : -0.5;
    EXPECT_EQ(problem.goals[0].ranges[i], std::make_pair(expected, expected)) << name;
  }
}

TEST_F(MoveitImport, OtherGroupsJointsArePassive) {
  std::string request = replaced(kRequest, "group_name: both", "group_name: left");
  EXPECT_NE(messageOf(kScene, request)
                .find("goal names joint 'right_joint', which is not planned; planned are "
                      "left_joint, left_tip_joint"),
            std::string::npos)
      << messageOf(kScene, request);
  request = replaced(request, "      - {joint_name: right_joint, position: 1}\n", "");
  request =
      replaced(request, "[0.5, 7",
               "[1.5, 7");  // outside its limits, but unplanned: kept, like MoveIt's open fingers
  const Problem problem = load(kScene, request);
  EXPECT_EQ(problem.robot.variables.size(), 2U);
  EXPECT_EQ(start(problem, "right_joint"), 1.5);
}

TEST_F(MoveitImport, MatrixStandsInForTheSrdfWhereItKnowsTheLinks) {
  const Problem problem = load(kScene, kRequest);
  EXPECT_TRUE(problem.contacts.replace_srdf);
  std::set<std::set<std::string>> allowed;
  for (const auto& [a, b] : problem.contacts.allowed) allowed.insert({a, b});
  EXPECT_EQ(allowed, (std::set<std::set<std::string>>{
                         {"left", "torso"},
                         {"left", "left_tip"},  // from the matrix
                         {"left", "torso_2"},   // a part of the torso, unknown to the matrix
                         {"knob", "right"},
                         {"left", "right"},       // the matrix lacks right: the SRDF decides
                         {"can", "left_tip"}}));  // an object
  std::string all;
  for (const std::string& warning : problem.warnings) all += warning + "\n";
  EXPECT_NE(all.find("the matrix names 'ghost', which is no link and no object"), std::string::npos)
      << all;
  EXPECT_NE(all.find("link 'torso_2' is not in the matrix, may touch what 'torso' may touch"),
            std::string::npos)
      << all;
  EXPECT_NE(all.find("the robot has no joint 'no_such_joint', its position 9 is not used"),
            std::string::npos)
      << all;
  EXPECT_NE(all.find("joint 'left_joint' at -3.14159265 is moved onto its limit -3.14159"),
            std::string::npos)
      << all;
  EXPECT_EQ(problem.warnings.size(), 4U) << all;
}

TEST_F(MoveitImport, FalseInTheMatrixOutweighsTheSrdf) {
  const std::string matrix =
      "\nallowed_collision_matrix:\n  entry_names: [left, right]\n  entry_values: [[false, false], "
      "[false, false]]\n";
  const Problem problem = load(matrix + kObjects, kRequest);
  EXPECT_EQ(problem.contacts.allowed,
            (std::vector<std::pair<std::string, std::string>>{{"knob", "right"}}));
  // An asymmetric entry allows nothing.
  const Problem half =
      load(replaced(matrix, "[[false, false]", "[[false, true]") + kObjects, kRequest);
  EXPECT_EQ(half.contacts.allowed, problem.contacts.allowed);
  const auto isTold = [](const Problem& of) {
    return std::any_of(of.warnings.begin(), of.warnings.end(), [](const std::string& warning) {
      return warning.find("the matrix has both true and false for 'left' and 'right': ") !=
             std::string::npos;
    });
  };
  EXPECT_TRUE(isTold(half));
  EXPECT_FALSE(isTold(problem));
}

/// MoveIt checks neighbours, too, unless the matrix allows them: false is enable_collisions.
TEST_F(MoveitImport, FalseInTheMatrixHasNeighboursChecked) {
  const auto adjacentOf = [&](const Problem& problem) {
    std::set<std::set<std::string>> pairs;
    for (const CompiledScene::Dropped& dropped : CompiledScene(problem).dropped())
      if (dropped.why == Unchecked::kAdjacent) pairs.insert({dropped.a, dropped.b});
    return pairs;
  };
  const auto matrix = [&](const std::string& flag) {
    return "\nallowed_collision_matrix:\n  entry_names: [left, left_tip]\n  entry_values: "
           "[[true, " +
           flag + "], [" + flag + ", true]]\n" + kObjects;
  };
  const std::set<std::string> tip = {"left", "left_tip"};
  const Problem checked = load(matrix("false"), kRequest);
  EXPECT_EQ(adjacentOf(checked).count(tip), 0U);
  EXPECT_EQ(checked.contacts.checked,
            (std::vector<std::pair<std::string, std::string>>{{"left", "left_tip"}}));
  EXPECT_EQ(checked.robot.model, model_) << "problems share it";
  EXPECT_EQ(adjacentOf(checked).size(), 2U) << "those that the matrix does not name stay";
  EXPECT_EQ(adjacentOf(load(matrix("true"), kRequest)).count(tip), 1U);
  // The verifier agrees.
  Path path;
  for (const int v : checked.robot.variables)
    path.names.push_back(model_->variables[static_cast<std::size_t>(v)].name);
  path.positions = {startPoint(checked), goalPoint(checked, checked.goals.at(0))};
  EXPECT_EQ(toString(verify(checked, path).unchecked),
            toString(countUnchecked(CompiledScene(checked).dropped())));
}

/// As in MoveIt, shapes without a pose, the last ones, stand at the object's.
TEST_F(MoveitImport, ShapesBeyondThePosesStandAtTheObject) {
  const Problem problem =
      load(replaced(kScene,
                    "{position: [20, 0, 0]}, {position: [30, 0, 0], orientation: [0, 0, 0, "
                    "1]}, {}]",
                    "{position: [20, 0, 0]}]"),
           kRequest);
  const std::vector<collision::Geometry>& shapes = problem.world.objects[1].geometries;
  ASSERT_EQ(shapes.size(), 3U);
  EXPECT_EQ(shapes[0].X_BG.translation, Eigen::Vector3d(20, 0, 0));
  for (const std::size_t i : {1U, 2U})
    EXPECT_EQ(shapes[i].X_BG.translation, Eigen::Vector3d::Zero());
  EXPECT_TRUE(warns(problem,
                    "object 'box' has 3 primitives and 1 primitive_poses: the last 2 stand at the "
                    "object's pose"));
}

/// Pairs that the matrix does not hold go by the defaults of their names, both of which must allow.
TEST_F(MoveitImport, DefaultsOfTheMatrixHoldForPairsWithoutAnEntry) {
  const auto allowedBy = [&](const std::string& matrix) {
    const Problem problem = load("\nallowed_collision_matrix:\n" + matrix + kObjects, kRequest);
    std::set<std::set<std::string>> allowed;
    for (const auto& [a, b] : problem.contacts.allowed) allowed.insert({a, b});
    return allowed;
  };
  using Pairs = std::set<std::set<std::string>>;
  std::vector<std::string> links;
  for (const robots::Link& link : model_->links) links.push_back(link.name);
  // The SRDF's own pairs stay.
  Pairs of_can = {{"left", "right"}, {"knob", "right"}};
  for (const std::string& link : links) of_can.insert({"can", link});
  EXPECT_EQ(allowedBy("  entry_names: []\n  entry_values: []\n  default_entry_names: [can]\n"
                      "  default_entry_values: [true]\n"),
            of_can);
  Pairs of_both = of_can;
  for (const std::string& link : links) of_both.insert({"box", link});
  EXPECT_EQ(allowedBy("  default_entry_names: [can, box]\n  default_entry_values: [true, true]\n"),
            of_both);
  // A link's default is for links, those split off it and objects; false holds against the other's
  // true.
  Pairs of_link = {{"left", "right"}, {"knob", "right"}, {"left", "can"}};
  for (const std::string& link : links)
    if (link != "left" && link.rfind("torso", 0) != 0) of_link.insert({"left", link});
  EXPECT_EQ(allowedBy("  default_entry_names: [left, box, torso]\n  default_entry_values: [true, "
                      "false, false]\n"),
            of_link);
  // An entry outweighs defaults, and false defaults outweigh the SRDF.
  Pairs but_entry = of_can;
  but_entry.erase({"can", "left"});
  EXPECT_EQ(allowedBy("  entry_names: [left, can]\n  entry_values: [[false, false], [false, "
                      "false]]\n  default_entry_names: [can]\n  default_entry_values: [true]\n"),
            but_entry);
  EXPECT_EQ(allowedBy("  default_entry_names: [right]\n  default_entry_values: [false]\n"),
            Pairs{});
}

TEST_F(MoveitImport, DefaultsThatDoNotFitAreRefused) {
  const auto refused = [&](const std::string& matrix) {
    return messageOf("\nallowed_collision_matrix:\n" + matrix + kObjects, kRequest);
  };
  EXPECT_EQ(refused("  default_entry_names: [can]\n  default_entry_values: []\n"),
            "scene.yaml:4: 0 default_entry_values for 1 default_entry_names; equally many are "
            "expected");
  EXPECT_EQ(refused("  default_entry_names: [can]\n"),
            "scene.yaml:3: 0 default_entry_values for 1 default_entry_names; equally many are "
            "expected");
  EXPECT_EQ(refused("  default_entry_names: [can, can]\n  default_entry_values: [true, false]\n"),
            "scene.yaml:3: 'can' stands twice in allowed_collision_matrix.default_entry_names; "
            "once is expected");
  const Problem problem = load(
      "\nallowed_collision_matrix:\n  default_entry_names: [ghost]\n  default_entry_values: "
      "[true]\n" +
          std::string(kObjects),
      kRequest);
  EXPECT_EQ(std::count_if(problem.warnings.begin(), problem.warnings.end(),
                          [](const std::string& warning) {
                            return warning.find("the matrix names 'ghost'") != std::string::npos;
                          }),
            1);
}

/// Shapes without poses of their own stand at the object's.
TEST_F(MoveitImport, ShapesWithoutPosesStandAtTheObjects) {
  const std::string scene =
      "name: s\nworld:\n  collision_objects:\n"
      "    - id: a\n"
      "      pose: {position: {x: 1, y: 0.5, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}\n"
      "      primitives: [{type: box, dimensions: [1, 2, 3]}, {type: sphere, dimensions: [4]}]\n"
      "      meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]}]\n"
      "      planes: [{coef: [0, 0, 1, -2]}]\n";
  const Problem problem = load(scene, kRequest);
  const Object& a = problem.world.objects.at(0);
  EXPECT_EQ(a.X_WO.translation, Eigen::Vector3d(1, 0.5, 0));
  ASSERT_EQ(a.geometries.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(a.geometries[i].X_BG.translation, Eigen::Vector3d::Zero()) << i;
  EXPECT_EQ(a.geometries[3].X_BG.translation, Eigen::Vector3d(0, 0, 2));
  const auto said = [](const Problem& of) {
    return std::any_of(of.warnings.begin(), of.warnings.end(), [](const std::string& warning) {
      return warning.find("stands at the origin of its frame") != std::string::npos;
    });
  };
  EXPECT_FALSE(said(problem));
  // An object without any pose stands at its frame's origin, with a warning.
  EXPECT_TRUE(
      said(load("name: s\nworld:\n  collision_objects:\n    - id: a\n      primitives: "
                "[{type: sphere, dimensions: [4]}]\n",
                kRequest)));
  // Held things, too.
  const std::string request = replaced(
      kRequest, "start_state:\n",
      "start_state:\n  attached_collision_objects:\n    - {link_name: left, object: {id: cup, "
      "header: {frame_id: left}, pose: {position: [0.5, 0, 0]}, primitives: [{type: sphere, "
      "dimensions: [0.1]}]}}\n");
  const Problem held = load(kScene, request);
  ASSERT_EQ(held.robot.attachments.size(), 1U);
  EXPECT_EQ(held.robot.attachments[0].X_LO.translation, Eigen::Vector3d(0.5, 0, 0));
  EXPECT_EQ(held.robot.attachments[0].object.geometries[0].X_BG.translation,
            Eigen::Vector3d::Zero());
}

TEST_F(MoveitImport, WithoutAMatrixTheSrdfHolds) {
  const Problem problem = load(kObjects, kRequest);
  EXPECT_FALSE(problem.contacts.replace_srdf);
  EXPECT_TRUE(problem.contacts.allowed.empty());
}

TEST_F(MoveitImport, FramesMoveObjects) {
  const std::string transforms =
      "fixed_frame_transforms:\n  - {child_frame_id: cell, transform: {translation: [1, 2, 3], "
      "rotation: [0, 0, 0, 1]}}\n";
  const Problem problem =
      load(transforms + replaced(kObjects, "frame_id: \"\"", "frame_id: cell"), kRequest);
  EXPECT_EQ(problem.world.objects[1].X_WO.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_NE(messageOf(replaced(kObjects, "frame_id: \"\"", "frame_id: cell"), kRequest)
                .find("unknown frame 'cell' in world.collision_objects[1].header.frame_id; known: "
                      "world, torso"),
            std::string::npos)
      << messageOf(replaced(kObjects, "frame_id: \"\"", "frame_id: cell"), kRequest);
}

TEST_F(MoveitImport, SeveralGoalsAndTolerancesAreTaken) {
  const std::string more =
      "  - joint_constraints:\n      - {joint_name: left_joint, position: 3.1, tolerance_above: "
      "0.1, tolerance_below: 0.2}\n"
      "      - {joint_name: right_joint, position: 0}\n      - {joint_name: left_tip_joint, "
      "position: 0}\n";
  const Problem problem = load(kScene, kRequest + more);
  ASSERT_EQ(problem.goals.size(), 2U);
  EXPECT_NEAR(problem.goals[1].ranges[0].first, 2.9, 1e-12);
  EXPECT_EQ(problem.goals[1].ranges[0].second, 3.14159);  // the limit ends the range
}

TEST_F(MoveitImport, WhatWouldChangeTheProblemIsNeverSkipped) {
  const auto expect = [&](const std::string& scene, const std::string& request,
                          const std::string& expected) {
    const std::string message = messageOf(scene, request);
    EXPECT_EQ(message.substr(0, expected.size()), expected) << message;
  };
  const std::string request = kRequest;
  expect(replaced(kScene, "type: sphere", "type: prism"), request,
         "scene.yaml:21: world.collision_objects[1].primitives[1].type is 'prism'; box, sphere, "
         "cylinder or cone is expected");
  expect(replaced(kScene, "[1, 2, 3]}", "[1, 2]}"), request,
         "scene.yaml:21: world.collision_objects[1].primitives[0].dimensions is a list of 2 for a "
         "box; the three edges are expected");
  expect(replaced(kScene, "dimensions: [4]", "dimensions: [-4]"), request,
         "scene.yaml:21: world.collision_objects[1].primitives[1].dimensions[0] is -4; zero or "
         "more is expected");
  expect(replaced(kScene, "dimensions: [4]", "dimensions: [4e9]"), request,
         "scene.yaml:21: world.collision_objects[1].primitives[1].dimensions: sphere: radius is "
         "4000000000, but must be a number that is not negative and at most 1e+09 [m]");
  expect(replaced(kScene, "id: box", "id: can"), request,
         "scene.yaml:19: object 'can' is the name of another object or link; a name of its own is "
         "expected");
  expect(
      replaced(kScene, "[0, 0, 0.70710678118654757, 0.70710678118654757]", "[0, 0, 1, 1]"), request,
      "scene.yaml:18: world.collision_objects[0].pose.orientation is a quaternion of length 1.414");
  expect(replaced(kScene, "[true, false, false, false, false]", "[true, false]"), request,
         "scene.yaml:8: allowed_collision_matrix.entry_values[1] has 2 entries for 5 names; "
         "equally many are expected");
  const auto withMesh = [&](const std::string& mesh) {
    return replaced(kScene, "id: box\n",
                    "id: box\n      mesh_poses: [{}]\n      meshes: [" + mesh + "]\n");
  };
  expect(withMesh("{triangles: []}"), request,
         "scene.yaml:21: key 'vertices' is missing in "
         "world.collision_objects[1].meshes[0]");
  expect(withMesh("{triangles: [], vertices: []}"), request,
         "scene.yaml:21: world.collision_objects[1].meshes[0]: mesh: ");
  expect(
      withMesh("{triangles: [[0, 1, 2]], vertices: [[0, 0, 0], [1, 0, 0]]}"), request,
      "scene.yaml:21: world.collision_objects[1].meshes[0].triangles[0][2] is 2; a vertex from 0 "
      "to 1 is expected");
  expect(withMesh("{triangles: [[0, 1]], vertices: [[0, 0, 0], [1, 0, 0]]}"), request,
         "scene.yaml:21: world.collision_objects[1].meshes[0].triangles[0] is a list of 2; three "
         "numbers of vertices are expected");
  expect(replaced(kScene, "id: box\n", "id: box\n      mesh_poses: [{}]\n"), request,
         "scene.yaml:20: object 'box' has 0 meshes and 1 mesh_poses; at most one for each is "
         "expected");
  const auto withPlane = [&](const std::string& coef) {
    return replaced(kScene, "id: box\n",
                    "id: box\n      planes: [{coef: " + coef + "}]\n      plane_poses: [{}]\n");
  };
  expect(
      withPlane("[0, 0, 1]"), request,
      "scene.yaml:20: world.collision_objects[1].planes[0].coef is a list of 3; four numbers are "
      "expected");
  expect(withPlane("[0, 0, 0, 1]"), request,
         "scene.yaml:20: world.collision_objects[1].planes[0].coef has no usable normal");
  expect(replaced(kScene, "id: box\n", "id: box\n      operation: 1\n"), request,
         "scene.yaml:20: world.collision_objects[1].operation is '1'; only objects that are added "
         "(0) are expected");
  expect("world: {collision_objects: [{id: nothing}]}", request,
         "scene.yaml:1: object 'nothing' has no shape; primitives, meshes or planes are expected");
  expect("link_scale: [{link_name: left, scale: 1.1}]", request,
         "scene.yaml:1: link_scale[0].scale is 1.1; 1 is expected");
  expect("link_padding: [{link_name: lft, padding: 0.1}]", request,
         "scene.yaml:1: unknown link 'lft' in link_padding[0].link_name; did you mean 'left'?");
  expect("link_padding: [{link_name: left, padding: -0.1}]", request,
         "scene.yaml:1: link_padding[0].padding is -0.1; zero or more is expected");
  const auto holding = [&](const std::string& held) {
    return kScene + "robot_state: {attached_collision_objects: [" + held + "]}\n";
  };
  const std::string ball = "primitives: [{type: sphere, dimensions: [0.1]}], primitive_poses: [{}]";
  expect(holding("{link_name: left}"), request,
         "scene.yaml:23: key 'object' is missing in robot_state.attached_collision_objects[0]");
  expect(holding("{link_name: lft, object: {id: a}}"), request,
         "scene.yaml:23: unknown link 'lft' in "
         "robot_state.attached_collision_objects[0].link_name; did you mean 'left'?");
  expect(holding("{link_name: left, object: {id: a}}"), request,
         "scene.yaml:23: object 'a' has no shape, and the world no object of that name");
  expect(holding("{link_name: left, object: {id: can, " + ball + "}}"), request,
         "scene.yaml:23: object 'can' is the name of another object or link");
  expect(holding("{link_name: left, object: {id: a, planes: [{coef: [0, 0, 1, 0]}]}}"), request,
         "scene.yaml:23: robot_state.attached_collision_objects[0].object.planes is not supported");
  expect(holding("{link_name: left, object: {id: a, " + ball +
                 "}}, {link_name: left, object: {id: a, " + ball + "}}"),
         request, "scene.yaml:23: the object is held twice; once is expected");
  expect(kScene, replaced(request, "group_name: both", "group_name: bth"),
         "request.yaml:2: robot 'twins' has no group 'bth'; did you mean 'both'?");
  expect(kScene, replaced(request, "position: [0.5, 7, 0.25, 9]", "position: [0.5, 7, 0.25]"),
         "request.yaml:6: 3 positions for 4 names; equally many are expected");
  expect(kScene,
         replaced(request, "left_tip_joint, left_joint, no_such_joint]",
                  "left_tip_joint, left_joint, left_joint]"),
         "request.yaml:6: joint 'left_joint' stands twice in start_state.joint_state.position[3]; "
         "once is expected");
  expect(kScene, replaced(request, ", left_joint, no_such_joint]", ", a, no_such_joint]"),
         "request.yaml:6: start says nothing of joint 'left_joint'");
  expect(kScene, replaced(request, "[0.5, 7", "[1.5, 7"),
         "request.yaml:6: start has joint 'right_joint' at 1.5, outside its limits; 0 to 1 is "
         "expected");
  expect(
      kScene, replaced(request, "position: 1}", "position: 2}"),
      "request.yaml:11: goal has joint 'right_joint' at 2, outside its limits; 0 to 1 is expected");
  expect(kScene, replaced(request, "joint_name: right_joint", "joint_name: rigt_joint"),
         "request.yaml:11: unknown joint 'rigt_joint' in goal_constraints[0].joint_constraints[1]; "
         "did you mean 'right_joint'?");
  expect(kScene, replaced(request, "joint_name: right_joint", "joint_name: left_joint"),
         "request.yaml:11: joint 'left_joint' has two constraints; one is expected");
  expect(kScene, request + "    position_constraints: [{link_name: left}]\n",
         "request.yaml:13: key 'constraint_region' is missing in "
         "goal_constraints[0].position_constraints[0]");
  const auto withPosition = [&](const std::string& primitive) {
    return request +
           "    position_constraints: [{link_name: left, constraint_region: {primitives: [" +
           primitive + "], primitive_poses: [{}]}}]\n";
  };
  expect(kScene, withPosition("{type: cone, dimensions: [1, 1]}"),
         "request.yaml:13: goal_constraints[0].position_constraints[0].constraint_region.primitives"
         "[0].type is 'cone'; box, sphere or cylinder is expected");
  expect(kScene, withPosition("{type: sphere, dimensions: [0]}"),
         "request.yaml:13: goal_constraints[0].position_constraints[0].constraint_region.primitives"
         "[0].dimensions leave no room");
  expect(
      kScene, withPosition("{type: sphere, dimensions: [1]}"),
      "request.yaml:10: goal_constraints[0].joint_constraints is not supported; a goal of either "
      "joints or poses is expected");
  expect(kScene, request + "path_constraints: {orientation_constraints: [{link_name: left}]}\n",
         "request.yaml:13: key 'orientation' is missing in "
         "path_constraints.orientation_constraints[0]");
  const auto withPathJoint = [&](const std::string& text) {
    return request + "path_constraints: {joint_constraints: [" + text + "]}\n";
  };
  const std::string whole = "path_constraints.joint_constraints[0]";
  expect(kScene, withPathJoint("{joint_name: left_joint}"),
         "request.yaml:13: key 'position' is missing in " + whole);
  expect(kScene, withPathJoint("{joint_name: lft_joint, position: 0}"),
         "request.yaml:13: unknown joint 'lft_joint' in " + whole + "; did you mean 'left_joint'?");
  expect(kScene,
         withPathJoint("{joint_name: left_joint, position: 0, tolerance_above: 1}, {joint_name: "
                       "left_joint, position: 0}"),
         "request.yaml:13: joint 'left_joint' has two constraints; one is expected");
  expect(kScene, withPathJoint("{joint_name: left_joint, position: 9, tolerance_above: 1}"),
         "request.yaml:13: " + whole +
             " allows joint 'left_joint' from 9 to 10, outside its limits; a range that meets "
             "-3.14159 to 3.14159 is expected");
  expect(kScene, withPathJoint("{joint_name: right_joint, position: 0, tolerance_above: 0.4}"),
         "request.yaml:11: goal has joint 'right_joint' at 1, outside its limits; 0 to 0.4 is "
         "expected, because of " +
             whole + " at ");
  expect(kScene, withPathJoint("{joint_name: right_joint, position: 1, tolerance_below: 0.4}"),
         "request.yaml: start has joint 'right_joint' at 0.5, outside its limits; 0.6 to 1 is "
         "expected, because of " +
             whole + " at ");
  expect(kScene,
         request +
             "path_constraints: {orientation_constraints: [{link_name: left, orientation: [0, 0, "
             "0, 1], absolute_x_axis_tolerance: 0.1, absolute_y_axis_tolerance: 6, "
             "absolute_z_axis_tolerance: 0.1}]}\n",
         "request.yaml:13: path_constraints.orientation_constraints[0] leaves turns free that are "
         "not about the x or z axis alone");
  expect(kScene,
         replaced(request, "joint_names: [base_joint], transforms: [{rotation: [0, 0, 0, 1]",
                  "joint_names: [left_joint], transforms: [{rotation: [0, 0, 1, 0]"),
         "request.yaml:7: joint 'left_joint' is neither planar nor floating, but placed "
         "elsewhere; the identity is expected");
}

/// A field that is misspelt would otherwise be taken for one that is not there: the world with it.
TEST_F(MoveitImport, KeysThatTheMessagesDoNotHaveAreRefused) {
  const std::string scene = R"(name: s
robot_model_name: twins
is_diff: false
robot_state:
  joint_state: {header: {seq: 0, stamp: {secs: 0, nsecs: 0}, frame_id: ""}, name: [], position: [], velocity: [], effort: []}
  multi_dof_joint_state: {header: {stamp: 0}, joint_names: [], transforms: [], twist: [], wrench: []}
  attached_collision_objects:
    - link_name: left
      touch_links: [left_tip]
      weight: 0
      detach_posture: {header: {}, joint_names: [], points: [{positions: [], velocities: [], accelerations: [], effort: [], time_from_start: {sec: 0, nanosec: 0}}]}
      object: {id: held, header: {frame_id: left}, primitives: [{type: sphere, dimensions: [0.01]}], primitive_poses: [{position: [0, 0, 1]}]}
fixed_frame_transforms:
  - {header: {frame_id: world}, child_frame_id: hall, transform: {translation: {x: 0, y: 0, z: 9}, rotation: {x: 0, y: 0, z: 0, w: 1}}}
allowed_collision_matrix:
  entry_names: [left]
  entry_values: [{enabled: [false]}]
  default_entry_names: [torso]
  default_entry_values: [true]
link_padding: [{link_name: left, padding: 0.1}]
link_scale: [{link_name: left, scale: 1}]
object_colors: [{id: can, color: {r: 0, g: 0, b: 0, a: 1}}]
world:
  collision_objects:
    - header: {frame_id: hall}
      id: can
      type: {key: "", db: ""}
      operation: 0
      pose: {position: {x: 5, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      primitives: [{type: sphere, dimensions: [0.1], polygon: {points: []}}]
      primitive_poses: [{position: {x: 0, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 0, w: 1}}]
      meshes: [{vertices: [{x: 0, y: 0, z: 0}, {x: 1, y: 0, z: 0}, {x: 0, y: 1, z: 0}, {x: 0, y: 0, z: 1}], triangles: [{vertex_indices: [0, 2, 1]}, [0, 1, 3], [0, 3, 2], [1, 2, 3]]}]
      mesh_poses: [{position: {x: 0, y: 0, z: 3}}]
      planes: [{coef: [0, 0, 1, 9]}]
      plane_poses: [{position: {x: 0, y: 0, z: 0}}]
      subframe_names: [tip]
      subframe_poses: [{position: {x: 0, y: 0, z: 0}}]
  octomap: {header: {}, origin: {position: {x: 0, y: 0, z: 0}}, octomap: {header: {}, binary: false, id: "", resolution: 0, data: []}}
)";
  const std::string request =
      R"(workspace_parameters: {header: {frame_id: ""}, min_corner: {x: -1, y: -1, z: -1}, max_corner: {x: 1, y: 1, z: 1}}
planner_id: ""
pipeline_id: ompl
num_planning_attempts: 1
max_velocity_scaling_factor: 1
max_acceleration_scaling_factor: 1
max_cartesian_speed: 0
cartesian_speed_limited_link: ""
reference_trajectories: []
trajectory_constraints: {}
allowed_planning_time: 5
group_name: both
start_state:
  is_diff: true
  joint_state: {name: [right_joint, left_tip_joint, left_joint], position: [0.5, 0, 0.25]}
  multi_dof_joint_state: {joint_names: [base_joint], transforms: [{translation: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}}], twist: [{linear: {x: 0, y: 0, z: 0}, angular: [0, 0, 0]}]}
path_constraints:
  name: level
  orientation_constraints:
    - {header: {frame_id: ""}, link_name: right, weight: 1, orientation: {x: 0, y: 0, z: 0, w: 1}, parameterization: 0, absolute_x_axis_tolerance: 0.1, absolute_y_axis_tolerance: 0.1, absolute_z_axis_tolerance: 0.1}
goal_constraints:
  - name: g
    visibility_constraints: []
    joint_constraints:
      - {joint_name: left_joint, position: 1, tolerance_above: 0.1, tolerance_below: 0.1, weight: 1}
      - {joint_name: right_joint, position: 1}
      - {joint_name: left_tip_joint, position: -0.5}
)";
  ASSERT_EQ(messageOf(scene, request), "accepted");
  // Empty in other words; and with content.
  const std::string no_trajectory = "trajectory_constraints: {}";
  const auto with = [&](const std::string& other) {
    std::string changed = request;
    return changed.replace(changed.find(no_trajectory), no_trajectory.size(),
                           "trajectory_constraints: " + other);
  };
  for (const char* empty : {"{constraints: []}", "{constraints: }", "", "[]"})
    EXPECT_EQ(messageOf(scene, with(empty)), "accepted") << empty;
  EXPECT_NE(messageOf(scene, with("{constraints: [{name: slow}]}")).find("trajectory_constraints"),
            std::string::npos);

  // Every key of both files, misspelt once.
  int misspelt = 0;
  const auto misspell = [&](const std::string& text, const auto& messageWith) {
    for (std::size_t end = text.find(':'); end != std::string::npos;
         end = text.find(':', end + 1)) {
      std::size_t begin = end;
      while (begin > 0 && (std::isalpha(static_cast<unsigned char>(text[begin - 1])) != 0 ||
                           text[begin - 1] == '_'))
        --begin;
      const std::string key = text.substr(begin, end - begin);
      const auto line =
          std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
      std::string changed = text;
      changed.insert(end, "q");
      const std::string message = messageWith(changed);
      EXPECT_NE(message.find(":" + std::to_string(line + 1) + ": unknown key '" + key + "q' in "),
                std::string::npos)
          << key << ": " << message;
      EXPECT_TRUE(key.size() <= 3 || message.find("; did you mean '") != std::string::npos)
          << key << ": " << message;
      ++misspelt;
    }
  };
  misspell(scene, [&](const std::string& changed) { return messageOf(changed, request); });
  misspell(request, [&](const std::string& changed) { return messageOf(scene, changed); });
  EXPECT_GT(misspelt, 150);

  EXPECT_EQ(messageOf(replaced(scene, "world:\n", "wrld:\n"), request),
            "scene.yaml:23: unknown key 'wrld' in the file; did you mean 'world'?");
  EXPECT_EQ(messageOf(replaced(scene, "pose: {position", "pose: {positon"), request),
            "scene.yaml:29: unknown key 'positon' in world.collision_objects[0].pose; did you mean "
            "'position'?");
  EXPECT_EQ(messageOf(scene, replaced(request, "path_constraints", "path_constrants")),
            "request.yaml:17: unknown key 'path_constrants' in the file; did you mean "
            "'path_constraints'?");
  // A plain value in place of a message is refused.
  EXPECT_EQ(messageOf(replaced(scene, "header: {frame_id: hall}", "header: hall"), request),
            "scene.yaml:25: world.collision_objects[0].header is 'hall'; a map (key: value) is "
            "expected");
  EXPECT_EQ(
      messageOf(replaced(scene, "header: {frame_id: hall}", "header: {frame_id: [hall]}"), request),
      "scene.yaml:25: world.collision_objects[0].header.frame_id is a list of 1; a text is "
      "expected");
}

TEST_F(MoveitImport, MeshesAndPlanesStandWhereTheirPosesSay) {
  const Problem problem = load(R"(
world:
  collision_objects:
    - id: tent
      pose: {position: {x: 1, y: 2, z: 3}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      meshes:
        - triangles: [{vertex_indices: [0, 1, 2]}, [0, 2, 3], [0, 3, 1], [1, 3, 2]]
          vertices: [{x: 0, y: 0, z: 1}, [1, 0, 0], [0, 1, 0], [-1, -1, 0]]
      mesh_poses: [{position: [0, 0, 10], orientation: [0, 0, 0, 0]}]
      primitives: [{type: 2, dimensions: [0.5]}]
      primitive_poses: [{position: {x: 0, y: 0, z: -4}}]
    - id: slope
      planes: [{coef: [0, 3, 4, -10]}]
      plane_poses: [{position: [0, 0, 1]}]
)",
                               kRequest);
  ASSERT_EQ(problem.world.objects.size(), 2U);
  const Object& tent = problem.world.objects[0];
  ASSERT_EQ(tent.geometries.size(), 2U);
  EXPECT_EQ(tent.geometries[0].shape.radius(), 0.5);
  EXPECT_EQ((tent.X_WO * tent.geometries[0].X_BG).translation, Eigen::Vector3d(1, 2, -1));
  const collision::TriangleMesh* mesh = tent.geometries[1].shape.mesh();
  ASSERT_NE(mesh, nullptr);
  EXPECT_EQ(mesh->triangles().size(), 4U);
  EXPECT_EQ(mesh->closedComponentCount(), 1);
  EXPECT_EQ((tent.X_WO * tent.geometries[1].X_BG).translation, Eigen::Vector3d(1, 2, 13));
  // 3 y + 4 z = 10, one up: free above, with distances in metres.
  const Object& slope = problem.world.objects[1];
  ASSERT_EQ(slope.geometries.size(), 1U);
  EXPECT_EQ(slope.geometries[0].shape.type(), collision::ShapeType::kHalfSpace);
  const robots::Pose X_WH = slope.X_WO * slope.geometries[0].X_BG;
  const auto height = [&](const Eigen::Vector3d& point) { return (X_WH.inverse() * point).z(); };
  EXPECT_NEAR(height({7, 2, 2}), 0, 1e-14);
  EXPECT_NEAR(height({-7, 2 + 0.6, 2 + 0.8}), 1, 1e-14);
  EXPECT_NEAR(height({0, 0, 0}), -2.8, 1e-14);
  EXPECT_NEAR(X_WH.rotation.determinant(), 1, 1e-14);
  EXPECT_EQ(std::count_if(problem.warnings.begin(), problem.warnings.end(),
                          [](const std::string& warning) {
                            return warning.find("taken as no rotation") != std::string::npos;
                          }),
            1);
}

TEST_F(MoveitImport, WhatIsHeldMovesWithItsLink) {
  const std::string ball =
      "primitives: [{type: sphere, dimensions: [0.125]}], primitive_poses: [{position: [0, 0, 1]}]";
  // left turns by 0.25 rad about z through (0, 1, 0) at the request's start.
  const std::string request = replaced(
      kRequest, "start_state:\n",
      "start_state:\n  attached_collision_objects:\n    - {link_name: left, touch_links: "
      "[left_tip], object: {id: cup, header: {frame_id: left}, pose: {position: [0.5, 0, 0]}, " +
          ball + "}}\n");
  const std::string scene = kScene +
                            "robot_state:\n  attached_collision_objects:\n"
                            "    - {link_name: left, object: {id: cup, " +
                            ball +
                            "}}\n"
                            "    - {link_name: left, object: {id: lid, header: {frame_id: world}, "
                            "pose: {position: [0, 2, 0]}, " +
                            ball +
                            "}}\n"
                            "    - {link_name: right, object: {id: can}}\n";
  const Problem problem = load(scene, request);
  ASSERT_EQ(problem.robot.attachments.size(), 3U);
  const Attachment& cup = problem.robot.attachments[0];
  EXPECT_EQ(cup.object.name, "cup") << "as the request says, not the scene";
  EXPECT_EQ(cup.link, model_->findLink("left"));
  EXPECT_EQ(cup.touch_links, std::vector<int>{model_->findLink("left_tip")});
  EXPECT_EQ(cup.X_LO.translation, Eigen::Vector3d(0.5, 0, 0));
  const Attachment& lid = problem.robot.attachments[1];
  EXPECT_NEAR(lid.X_LO.translation.x(), std::sin(0.25), 1e-15);
  EXPECT_NEAR(lid.X_LO.translation.y(), std::cos(0.25), 1e-15);
  EXPECT_NEAR(lid.X_LO.rotation(0, 1), std::sin(0.25), 1e-15);
  const Attachment& can = problem.robot.attachments[2];
  EXPECT_EQ(can.object.name, "can");
  EXPECT_EQ(can.X_LO.translation, Eigen::Vector3d(10, 1, -0.5));
  ASSERT_EQ(problem.world.objects.size(), 1U) << "the can is no longer in the world";
  // The matrix speaks of what is held as of anything else.
  EXPECT_NE(std::find(problem.contacts.allowed.begin(), problem.contacts.allowed.end(),
                      std::make_pair(std::string("can"), std::string("left_tip"))),
            problem.contacts.allowed.end());
}

TEST_F(MoveitImport, PaddingIsAMarginOfTheWorldsPairs) {
  const std::string padded =
      kScene +
      "link_padding: [{link_name: left, padding: 0.02}, {link_name: right, padding: 0}]\n"
      "link_scale: [{link_name: left, scale: 1}]\n"
      "robot_state: {attached_collision_objects: [{link_name: left, object: {id: cup, primitives: "
      "[{type: sphere, dimensions: [0.1]}], primitive_poses: [{}]}}]}\n";
  const Problem problem = load(padded, kRequest);
  std::vector<std::string> pairs;
  for (const PairMargin& pair : problem.margins.pairs) {
    EXPECT_EQ(pair.margin, 0.02);
    pairs.push_back(pair.a + " " + pair.b);
  }
  EXPECT_EQ(pairs, (std::vector<std::string>{"left world", "cup world"}));

  // A problem file may ask for more, for less where it names a pair, and bring more objects.
  folder_.write("scene.yaml", padded);
  folder_.write("request.yaml", kRequest);
  const auto marginOf = [&](const std::string& more, const std::string& object) {
    const Problem loaded = loadProblem(folder_.write(
        "padded.yaml",
        "leeway: 1\nrobot: {urdf: twins.urdf, srdf: twins.srdf}\nmoveit: {scene: scene.yaml, "
        "request: request.yaml}\nobjects: [{name: more, sphere: {radius: 1}, position: [0, 0, "
        "40]}]\n" +
            more));
    double margin = loaded.margins.common;
    for (const PairMargin& pair : loaded.margins.pairs)
      if (pair.a == "left" && (pair.b == object || pair.b == "world")) margin = pair.margin;
    return margin;
  };
  EXPECT_EQ(marginOf("", "can"), 0.02);
  EXPECT_EQ(marginOf("", "more"), 0.02);
  EXPECT_EQ(marginOf("margin: 0.01\n", "can"), 0.02);
  EXPECT_EQ(marginOf("margin: 0.03\n", "can"), 0.03);
  EXPECT_EQ(marginOf("margins: [{between: [left, can], margin: 0.001}]\n", "can"), 0.001);
}

/// The two forms that MoveIt has written, with all its shapes.
TEST_F(MoveitImport, ScenesSavedAsTextAreTaken) {
  const std::string colour = "0.1 0.2 0.3 1\n", none = "0 0 0\n0 0 0 1\n";
  const auto shapes = [&](const std::string& place) {
    return "5\nbox\n1 2 3\n" + place + "0 0 0 1\n" + colour +  //
           "sphere\n0.5\n" + none + colour +                   //
           "cylinder\n0.25 2\n" + none + colour +              //
           "cone\n0.25 2\n" + none + colour +                  //
           "mesh\n3 1\n0 0 0\n1 0 0\n0 1 0\n0 1 2\n" + none + colour;
  };
  const auto loaded = [&](const std::string& text) {
    return loadMoveit(model_, folder_.write("room.scene", text),
                      folder_.write("request.yaml", kRequest));
  };
  const std::string floor = "1\nplane\n0 0 2 1\n" + none + colour;
  const Problem old =
      loaded("(noname)+\n* a  box \n" + shapes("1 2 13\n") + "* floor\n" + floor + ".\n");
  const Problem recent = loaded("(noname)+\r\n* a  box\n1 2 3\n0 0 0 1\n" + shapes("0 0 10\n") +
                                "1\ncorner\n" + none + "* floor\n" + none + floor + "0\n.\n");
  EXPECT_EQ(old.name, "room");
  for (const Problem* problem : {&old, &recent}) {
    ASSERT_EQ(problem->world.objects.size(), 2U);
    const Object& box = problem->world.objects[0];
    EXPECT_EQ(box.name, "a  box");
    ASSERT_EQ(box.geometries.size(), 5U);
    EXPECT_EQ(box.geometries[0].shape.halfExtents(), Eigen::Vector3d(0.5, 1, 1.5));
    EXPECT_EQ((box.X_WO * box.geometries[0].X_BG).translation, Eigen::Vector3d(1, 2, 13));
    EXPECT_EQ(box.geometries[1].shape.radius(), 0.5);
    EXPECT_EQ(box.geometries[2].shape.type(), collision::ShapeType::kCylinder);
    EXPECT_EQ(box.geometries[2].shape.radius(), 0.25);
    EXPECT_EQ(box.geometries[2].shape.halfLength(), 1);
    EXPECT_EQ(box.geometries[3].shape.type(), collision::ShapeType::kCone);
    EXPECT_EQ(box.geometries[4].shape.mesh()->triangles().size(), 1U);
    EXPECT_EQ(problem->world.objects[1].geometries[0].X_BG.translation,
              Eigen::Vector3d(0, 0, -0.5));
  }
  const auto expect = [&](const std::string& text, const std::string& expected) {
    try {
      loaded(text);
      ADD_FAILURE() << text;
    } catch (const robots::InputError& error) {
      const std::string message = std::string(error.what()).substr(folder_.path().size() + 1);
      EXPECT_EQ(message.substr(0, expected.size()), expected) << message;
    }
  };
  expect("", "room.scene:1: ends early; '*' and an object, or '.' at the end is expected");
  expect("name\n* a\n1\nbox\n1 2", "room.scene:5: ends early; a size [m] is expected");
  expect("name\n* a\n1\nbox\n1 2 x", "room.scene:5: 'x' stands where a size [m] is expected");
  expect("name\n* a\n1\nbox\n1 2 -3\n", "room.scene:5: a size of -3; zero or more is expected");
  expect("name\n* a\n1\ntorus\n1 2", "room.scene:4: 'torus' is no shape that is known; box, ");
  expect("name\n* a\n1e9\n", "room.scene:3: 1000000000 stands where a number of shapes");
  expect("name\n* a\n0\n.\n", "room.scene:2: object 'a' has no shape");
  expect("name\n* left\n" + floor + ".\n",
         "room.scene:2: object 'left' is the name of another object or link");
  expect("name\n* a\n1\nmesh\n3 1\n0 0 0 1 0 0 0 1 0\n0 1 3\n",
         "room.scene:7: triangle 0 names vertex 3; 0 to 2 is expected");
  expect("name\n" + std::string(".\n\n* a\n"), "room.scene:4: '*' stands after the '.'");
  expect("world: {}\n", "room.scene:2: ends early");
  expect("leeway: 1\nworld: {}\n", "room.scene:2: 'world:' stands where '*' and an object's name");
}

/// Points of the regions are where MoveIt's own formulas allow them, whatever is drawn.
TEST_F(MoveitImport, ConstraintsOfPosesAllowNoMoreThanMoveitDoes) {
  const std::string head = kRequest;
  const std::string goal =
      "goal_constraints:\n"
      "  - position_constraints: [{link_name: left, target_point_offset: [0.1, 0, 0], header: "
      "{frame_id: can}, constraint_region: {primitives: [{type: sphere, dimensions: [0.01]}], "
      "primitive_poses: [{position: [1, 2, 3], orientation: [0, 0, 0.6, 0.8]}]}}]\n"
      "    orientation_constraints: [{link_name: left, orientation: [0.5, 0.5, 0.5, 0.5], "
      "absolute_x_axis_tolerance: 0.1, absolute_y_axis_tolerance: 0.2, absolute_z_axis_tolerance: "
      "3.2}]\n";
  const Problem problem = load(kScene, head.substr(0, head.find("goal_constraints")) + goal);
  ASSERT_EQ(problem.goals.size(), 1U);
  ASSERT_EQ(problem.goals[0].poses.size(), 2U);
  const robots::PoseRegion& place = problem.goals[0].poses[0];
  EXPECT_EQ(place.X_LF.translation, Eigen::Vector3d(0.1, 0, 0));
  for (const auto& [from, to] : place.position) {
    EXPECT_EQ(from, -to);
    EXPECT_GT(to, 0.0057);
    EXPECT_LT(3 * to * to, 0.01 * 0.01);
  }
  // X_WC [1, 2, 3]: the sphere stands relative to the can.
  const auto can = std::find_if(problem.world.objects.begin(), problem.world.objects.end(),
                                [](const Object& object) { return object.name == "can"; });
  ASSERT_NE(can, problem.world.objects.end());
  EXPECT_LT((place.X_WR.translation - can->X_WO * Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);

  const robots::PoseRegion& turn = problem.goals[0].poses[1];
  const Eigen::Matrix3d wanted =
      Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5).toRotationMatrix();  // w x y z
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 4; ++j)
      for (int k = 0; k <= 4; ++k) {
        const auto at = [](const std::pair<double, double>& range, int step) {
          return range.first + (range.second - range.first) * step / 4;
        };
        const Eigen::Matrix3d R_RF =
            robots::rotationOf({at(turn.rpy[0], i), at(turn.rpy[1], j), at(turn.rpy[2], k)});
        const Eigen::Matrix3d R_WL = turn.X_WR.rotation * R_RF * turn.X_LF.rotation.transpose();
        // moveit_core: the x, y, z angles of the rotation from the wanted one.
        const Eigen::Matrix3d D = wanted.transpose() * R_WL;
        EXPECT_LE(std::abs(std::atan2(-D(1, 2), D(2, 2))), 0.1);
        EXPECT_LE(std::abs(std::asin(D(0, 2))), 0.2);
      }
  EXPECT_GT(turn.rpy[2].second, 0.0999);
}

/// Joint constraints of the path are limits of planned joints, and must hold for the others where
/// they stand.
TEST_F(MoveitImport, JointConstraintsOfThePathNarrowLimits) {
  const auto withPath = [](const std::string& constraints, std::string request = kRequest) {
    return request + "path_constraints:\n  joint_constraints:\n" + constraints;
  };
  const auto limits = [](const Problem& problem, const std::string& name) {
    const robots::Model& model = *problem.robot.model;
    const robots::Variable& v = model.variables[static_cast<std::size_t>(model.findVariable(name))];
    return std::make_pair(v.lower, v.upper);
  };
  // The start is 0.25, 7 and 0.5; the goal at -3.14, -0.5 and 1.
  Problem problem = load(
      kScene,
      withPath(
          "    - {joint_name: left_joint, position: -1, tolerance_below: 9, tolerance_above: 2}\n"
          "    - {joint_name: right_joint, position: 0.75, tolerance_below: 0.25, "
          "tolerance_above: 0.25}\n"
          "    - {joint_name: left_tip_joint, position: 0.5, tolerance_below: 1.5, "
          "tolerance_above: 1, weight: 1}\n"));
  EXPECT_EQ(limits(problem, "left_joint"), std::make_pair(-3.14159, 1.0));
  EXPECT_EQ(limits(problem, "right_joint"), std::make_pair(0.5, 1.0));
  // MoveIt does not tell whole turns apart: the range is about the start, and so is the goal.
  const double turn = 2 * M_PI;
  EXPECT_NEAR(limits(problem, "left_tip_joint").first, turn - 1, 1e-12);
  EXPECT_NEAR(limits(problem, "left_tip_joint").second, turn + 1.5, 1e-12);
  ASSERT_EQ(problem.goals.size(), 1U);
  EXPECT_NEAR(problem.goals[0].ranges[1].first, turn - 0.5, 1e-12);
  // The robot that others share stays as it is.
  EXPECT_EQ(model_->variables[static_cast<std::size_t>(model_->findVariable("left_joint"))].upper,
            3.14159);
  // A goal's range is cut to the range that the path allows.
  problem = load(kScene, withPath("    - {joint_name: left_joint, position: 0, tolerance_below: 2, "
                                  "tolerance_above: 2}\n",
                                  replaced(kRequest, "{position: -3.14159265, joint_name",
                                           "{position: -1.8, tolerance_below: 0.5, "
                                           "tolerance_above: 0.5, joint_name")));
  EXPECT_EQ(problem.goals[0].ranges[0], std::make_pair(-2.0, -1.3));
  // More than a turn keeps nothing of a joint without limits.
  problem =
      load(kScene, withPath("    - {joint_name: left_tip_joint, position: 0, tolerance_below: "
                            "3.15, tolerance_above: 3.15}\n"));
  EXPECT_TRUE(std::isinf(limits(problem, "left_tip_joint").second));
  // A start just outside is moved onto the limit.
  problem = load(kScene, withPath("    - {joint_name: right_joint, position: 1, tolerance_below: "
                                  "0.499995}\n"));
  EXPECT_EQ(problem.start[static_cast<std::size_t>(model_->findVariable("right_joint"))],
            1 - 0.499995);
  EXPECT_TRUE(warns(problem, "joint 'right_joint' at 0.5 is moved onto its limit"));
}

TEST_F(MoveitImport, JointConstraintsOfUnplannedJointsMustHoldAtTheStart) {
  std::string request = replaced(kRequest, "group_name: both", "group_name: left");
  request = replaced(request, "      - {joint_name: right_joint, position: 1}\n", "");
  const auto with = [&](const std::string& tolerance) {
    return request + "path_constraints: {joint_constraints: [{joint_name: right_joint, position: " +
           "0.4, tolerance_above: " + tolerance + "}]}\n";
  };
  EXPECT_EQ(messageOf(kScene, with("0.1")), "accepted");
  EXPECT_EQ(messageOf(kScene, with("0.05"))
                .find("request.yaml:12: joint 'right_joint' is not planned and stands at 0.5; "
                      "path_constraints.joint_constraints[0] allows 0.4 to 0.45"),
            0U)
      << messageOf(kScene, with("0.05"));
}

/// Beyond a right angle MoveIt's three angles do not bound a turn: the path keeps a right angle,
/// with a warning. A constraint that allows any rotation is left out.
TEST_F(MoveitImport, WideOrientationConstraintsOfThePathAreNarrowed) {
  const auto with = [&](const std::string& tolerances, const std::string& more = "") {
    return std::string(kRequest) +
           "path_constraints: {orientation_constraints: [{link_name: left, orientation: [0, 0, 0, "
           "1], " +
           more + tolerances + "}]}\n";
  };
  const auto keys = [](double x, double y, double z) {
    return "absolute_x_axis_tolerance: " + std::to_string(x) +
           ", absolute_y_axis_tolerance: " + std::to_string(y) +
           ", absolute_z_axis_tolerance: " + std::to_string(z);
  };
  const Problem narrow = load(kScene, with(keys(0.2, 0.3, 0.4)));
  const std::size_t warnings = narrow.warnings.size();
  // Regression: the least of the three tolerances held for all.
  ASSERT_EQ(narrow.constraints.size(), 2U);
  EXPECT_EQ(narrow.constraints[0].angle, 0.2);
  EXPECT_EQ(narrow.constraints[0].turn, Constraint::Turn::kAxis);
  EXPECT_EQ(narrow.constraints[0].axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(narrow.constraints[1].angle, 0.4);
  EXPECT_EQ(narrow.constraints[1].turn, Constraint::Turn::kFixed);
  Problem wide = load(kScene, with(keys(2, 2.5, 3.14)));
  ASSERT_EQ(wide.constraints.size(), 1U);
  EXPECT_EQ(wide.constraints[0].angle, 1.57);
  EXPECT_EQ(wide.constraints[0].turn, Constraint::Turn::kAxis);
  EXPECT_EQ(wide.constraints[0].axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(wide.warnings.size(), warnings + 1);
  EXPECT_TRUE(warns(wide,
                    "request.yaml:13: path_constraints.orientation_constraints[0] allows turns of "
                    "2 rad; the path keeps 1.57 rad"));
  // One narrow angle bounds it.
  wide = load(kScene, with(keys(2, 0.1, 2)));
  EXPECT_EQ(wide.constraints[0].angle, 0.1);
  EXPECT_EQ(wide.constraints.at(1).angle, 1.57);
  EXPECT_EQ(wide.warnings.size(), warnings + 1);
  const Problem even = load(kScene, with(keys(0.1, 0.3, 0.1)));
  ASSERT_EQ(even.constraints.size(), 1U);
  EXPECT_EQ(even.constraints[0].angle, 0.1);
  EXPECT_EQ(even.constraints[0].turn, Constraint::Turn::kFixed);
  for (const double y : {1.571, 2.0, 6.3}) {
    const Problem any = load(kScene, with(keys(6.3, y, 3.15)));
    EXPECT_TRUE(any.constraints.empty()) << y;
    EXPECT_EQ(any.warnings.size(), warnings + 1);
    EXPECT_TRUE(warns(any, "allows any rotation; it is left out"));
  }
  EXPECT_NE(messageOf(kScene, with(keys(6.3, 1.5, 6.3))).find("leaves turns free"),
            std::string::npos);
  EXPECT_NE(
      messageOf(kScene, with(keys(6.3, 2, 6.3), "parameterization: 1, ")).find("leaves turns"),
      std::string::npos);
}

/// Turns that keep the constraints keep MoveIt's three tolerances.
TEST_F(MoveitImport, OrientationConstraintsAllowNoMoreThanThreeAngles) {
  Random random(2);
  int allowed = 0;
  for (int k = 0; k < 400; ++k) {
    const auto drawn = [&] { return random.uniform(0, 1) < 0.2 ? 3.2 : random.uniform(0.01, 3.1); };
    const double tolerances[] = {drawn(), random.uniform(0.01, 3.1), drawn()};
    if (tolerances[0] > std::numbers::pi && tolerances[2] > std::numbers::pi) continue;
    const Problem problem = load(
        kScene, std::string(kRequest) +
                    fmt::format("path_constraints: {{orientation_constraints: [{{link_name: left, "
                                "orientation: [0, 0, 0, 1], absolute_x_axis_tolerance: {}, "
                                "absolute_y_axis_tolerance: {}, absolute_z_axis_tolerance: {}, "
                                "weight: 1}}]}}\n",
                                tolerances[0], tolerances[1], tolerances[2]));
    for (int j = 0; j < 200; ++j) {
      const Eigen::Matrix3d turn =
          (Eigen::AngleAxisd(random.uniform(-std::numbers::pi, std::numbers::pi),
                             Eigen::Vector3d::UnitX()) *
           Eigen::AngleAxisd(random.uniform(-std::numbers::pi, std::numbers::pi) / 2,
                             Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(random.uniform(-std::numbers::pi, std::numbers::pi),
                             Eigen::Vector3d::UnitZ()))
              .toRotationMatrix();
      const bool keeps = std::all_of(
          problem.constraints.begin(), problem.constraints.end(), [&](const Constraint& c) {
            const double off = c.turn == Constraint::Turn::kFixed
                                   ? Eigen::AngleAxisd(turn).angle()
                                   : std::acos(std::clamp(c.axis.dot(turn * c.axis), -1.0, 1.0));
            return off <= c.angle;
          });
      if (!keeps) continue;
      ++allowed;
      // x, y and z angles, as MoveIt takes them apart.
      const double angles[] = {std::atan2(-turn(1, 2), turn(2, 2)), std::asin(turn(0, 2)),
                               std::atan2(-turn(0, 1), turn(0, 0))};
      for (int i = 0; i < 3; ++i)
        EXPECT_LE(std::abs(angles[i]), tolerances[i] + 1e-9) << k << " " << i;
    }
  }
  EXPECT_GT(allowed, 1000);
}

/// Regression: a turn that is free about one axis was refused in the form of rotation vectors.
TEST_F(MoveitImport, RotationVectorsMayHaveOneFreeAxis) {
  Random random(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto tolerance = [&](int i) { return i == axis ? "6.3, " : "0.5, "; };
    const Problem problem = load(
        kScene, std::string(kRequest) +
                    "path_constraints: {orientation_constraints: [{link_name: left, orientation: "
                    "[0, 0, 0, 1], parameterization: 1, absolute_x_axis_tolerance: " +
                    tolerance(0) + "absolute_y_axis_tolerance: " + tolerance(1) +
                    "absolute_z_axis_tolerance: " + tolerance(2) + "weight: 1}]}\n");
    ASSERT_EQ(problem.constraints.size(), 1U);
    const Constraint& constraint = problem.constraints[0];
    EXPECT_EQ(constraint.turn, Constraint::Turn::kAxis);
    EXPECT_EQ(constraint.axis, Eigen::Vector3d::Unit(axis));
    EXPECT_TRUE(warns(problem, "allows 0.5 rad of the rotation vector about two axes"));
    double most = 0;
    const auto about = [](double angle, int i) {
      return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(i));
    };
    for (int k = 0; k < 10000; ++k) {
      const double tilt = constraint.angle * random.uniform(0, 1);
      const Eigen::AngleAxisd turn(about(random.uniform(-3.2, 3.2), axis) *
                                   about(tilt, (axis + 1) % 3) *
                                   about(random.uniform(-3.2, 3.2), axis));
      for (int i = 0; i < 3; ++i)
        if (i != axis) most = std::max(most, std::abs(turn.angle() * turn.axis()[i]));
    }
    EXPECT_LE(most, 0.5);
    EXPECT_GT(most, 0.45);
  }
}

TEST_F(MoveitImport, AFloatingBaseStandsWhereTheRequestSays) {
  const Problem problem =
      load(kScene, replaced(kRequest, "rotation: [0, 0, 0, 1], translation: [0, 0, 0]",
                            "rotation: [0, 0, 1, 0], translation: [1, 2, 3]"));
  EXPECT_EQ(start(problem, "base_joint/y"), 2);
  EXPECT_EQ(start(problem, "base_joint/qz"), 1);
}

/// Every problem of the public set, where present: it loads, and start and goal are valid, as
/// published.
TEST(MotionBenchMaker, EveryStartAndGoalIsValid) {
  const std::string data = dataFolder();
  LEEWAY_NEEDS_DATA("mbm");
  int problems = 0, moved_by_pose = 0;
  for (const std::string name : {"panda", "ur5"}) {
    const std::string robot = data + "/robots/" + name + "/" + name;
    const auto model = robots::loadModel(robot + ".urdf", robot + ".srdf");
    for (const auto& entry : std::filesystem::recursive_directory_iterator(data + "/mbm/" + name)) {
      const std::string scene_file = entry.path().string();
      const std::size_t place = scene_file.rfind("/scene");
      if (place == std::string::npos) continue;
      const Problem problem =
          loadMoveit(model, scene_file, std::string(scene_file).replace(place, 6, "/request"));
      ++problems;
      for (const Object& object : problem.world.objects)
        moved_by_pose += object.X_WO.translation.norm() > 0 ? 1 : 0;
      EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
      std::vector<double> start, goal;
      for (const int v : problem.robot.variables)
        start.push_back(problem.start[static_cast<std::size_t>(v)]);
      for (const auto& range : problem.goals.at(0).ranges) goal.push_back(range.first);
      EXPECT_EQ(certifier.decide(start), collision::Verdict::kFree) << scene_file;
      EXPECT_EQ(certifier.decide(goal), collision::Verdict::kFree) << scene_file;
    }
  }
  EXPECT_GE(problems, 20);
  EXPECT_GT(moved_by_pose, 0);  // ur5/table_pick: without `pose` the whole table is displaced
}

}  // namespace
}  // namespace leeway::planner
