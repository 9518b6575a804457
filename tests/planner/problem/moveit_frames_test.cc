// Frames and robot states of MoveIt's messages.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/placed_model.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

using Eigen::Vector3d;
using robots::Pose;

/// A truck with a mast that lifts an arm. `brace` follows the mast.
constexpr const char* kTruck = R"(<robot name="truck">
  <link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="mast"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="brace"/>
  <link name="arm"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="mast"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="2" velocity="1" effort="1"/></joint>
  <joint name="brace_joint" type="prismatic"><parent link="base"/><child link="brace"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="2" velocity="1" effort="1"/><mimic joint="lift" multiplier="0.5" offset="0.25"/></joint>
  <joint name="turn" type="continuous"><parent link="mast"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>)";

std::string srdfWith(const std::string& virtual_joint) {
  return "<robot name='truck'><group name='arm'><joint name='turn'/></group><group name='all'>"
         "<joint name='turn'/><joint name='lift'/></group>" +
         (virtual_joint.empty()
              ? ""
              : "<group name='drive'><joint name='vj'/></group><virtual_joint name='vj' type='" +
                    virtual_joint + "' parent_frame='odom' child_link='base'/>") +
         "</robot>";
}

class MoveitFrames : public testing::Test {
 protected:
  std::shared_ptr<const robots::Model> truck(const std::string& virtual_joint) {
    return robots::loadModel(folder_.write("truck.urdf", kTruck),
                             folder_.write("truck.srdf", srdfWith(virtual_joint)));
  }
  Problem load(const std::shared_ptr<const robots::Model>& model, const std::string& scene,
               const std::string& request) {
    return loadMoveit(model, folder_.write("scene.yaml", "name: s\n" + scene),
                      folder_.write("request.yaml", request));
  }
  std::string messageOf(const std::shared_ptr<const robots::Model>& model, const std::string& scene,
                        const std::string& request) {
    try {
      load(model, scene, request);
    } catch (const robots::InputError& error) {
      return std::string(error.what()).substr(folder_.path().size() + 1);
    }
    return "accepted";
  }
  static double start(const Problem& problem, const std::string& variable) {
    return problem.start[static_cast<std::size_t>(problem.robot.model->findVariable(variable))];
  }
  static int warnings(const Problem& problem, const std::string& what) {
    return static_cast<int>(std::count_if(
        problem.warnings.begin(), problem.warnings.end(),
        [&](const auto& warning) { return warning.find(what) != std::string::npos; }));
  }

  Folder folder_;
};

const std::string kBall = "primitives: [{type: sphere, dimensions: [0.1]}]";

/// A scene of one ball at [0, 0, 9] of a frame.
std::string ballIn(const std::string& frame, const std::string& more = "") {
  return more + "world: {collision_objects: [{id: ball, header: {frame_id: " + frame +
         "}, pose: {position: [0, 0, 9], orientation: [0, 0, 0, 1]}, " + kBall + "}]}\n";
}

/// The start: `state` is added to turn at 0.25 and lift at 0.5.
std::string requestWith(
    const std::string& state,
    const std::string& goals = "[{joint_constraints: [{joint_name: turn, position: 1}]}]",
    const std::string& group = "arm") {
  return "group_name: " + group +
         "\nstart_state: {joint_state: {name: [turn, lift], position: [0.25, 0.5]}" + state +
         "}\ngoal_constraints: " + goals + "\n";
}

std::string multiDof(const std::string& transform, const std::string& header = "") {
  return ", multi_dof_joint_state: {" + header + "joint_names: [vj], transforms: [" + transform +
         "]}";
}

/// A goal of the arm's position in a frame, 9 m above it.
std::string goalIn(const std::string& frame) {
  return "[{position_constraints: [{header: {frame_id: " + frame +
         "}, link_name: arm, constraint_region: {primitives: [{type: sphere, dimensions: "
         "[0.01]}], primitive_poses: [{position: [0, 0, 9], orientation: [0, 0, 0, 1]}]}}]}]";
}

std::string pathIn(const std::string& frame) {
  return "path_constraints: {position_constraints: [{header: {frame_id: " + frame +
         "}, link_name: arm, constraint_region: {primitives: [{type: box, dimensions: [9, 9, 9]}], "
         "primitive_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}]}}]}\n";
}

Vector3d ballOf(const Problem& problem) {
  const Object& ball = problem.world.objects.at(0);
  return (ball.X_WO * ball.geometries.at(0).X_BG).translation;
}

const std::string kAside = multiDof("{translation: [0.5, 2, 0], rotation: [0, 0, 0, 1]}");

TEST_F(MoveitFrames, TheRootLinkIsWhereTheStartHasIt) {
  for (const char* type : {"floating", "planar"}) {
    const auto model = truck(type);
    for (const std::string& state : {kAside, multiDof("{translation: [0.5, 2, 0], rotation: [0, 0, "
                                                      "0, 1]}",
                                                      "header: {frame_id: odom}, ")}) {
      const Problem problem =
          load(model, ballIn("base"), requestWith(state, goalIn("base")) + pathIn("base"));
      EXPECT_EQ(ballOf(problem), Vector3d(0.5, 2, 9)) << type;
      EXPECT_EQ(problem.goals.at(0).poses.at(0).X_WR.translation, Vector3d(0.5, 2, 9)) << type;
      EXPECT_EQ(problem.constraints.at(0).X_SR.translation, Vector3d(0.5, 2, 1)) << type;
    }
    // Other links, too.
    EXPECT_EQ(ballOf(load(model, ballIn("/mast"), requestWith(kAside))), Vector3d(0.5, 2, 9.5));
  }
  // By the names of variables: MoveIt's, and those of this library.
  for (const char* name : {"vj/x", "vj/trans_x"}) {
    const bool planar = std::string(name) == "vj/x";
    const std::string request =
        "group_name: arm\nstart_state: {joint_state: {name: [turn, lift, " + std::string(name) +
        "], position: [0, 0, 0.75]}}\ngoal_constraints: [{joint_constraints: [{joint_name: turn, "
        "position: 1}]}]\n";
    EXPECT_EQ(ballOf(load(truck(planar ? "planar" : "floating"), ballIn("base"), request)),
              Vector3d(0.75, 0, 9))
        << name;
  }
}

TEST_F(MoveitFrames, ABaseThatIsPlacedTakesItsFrameAlong) {
  const Pose X_WB{Eigen::Matrix3d::Identity(), {3, 0, 0}};
  for (const char* type : {"", "fixed"}) {
    const auto placed = robots::withBasePose(*truck(type), X_WB);
    Problem problem = load(placed, ballIn("base"), requestWith("", goalIn("base")));
    EXPECT_EQ(ballOf(problem), Vector3d(3, 0, 9));
    EXPECT_EQ(problem.goals.at(0).poses.at(0).X_WR.translation, Vector3d(3, 0, 9));
    EXPECT_EQ(warnings(problem, "frame_id"), 0);
    EXPECT_EQ(ballOf(load(placed, ballIn("world"), requestWith(""))), Vector3d(0, 0, 9));
    // MoveIt takes entries without a frame to be in the base.
    problem = load(placed, ballIn("\"\""), requestWith("", goalIn("\"\"")));
    EXPECT_EQ(ballOf(problem), Vector3d(0, 0, 9));
    EXPECT_EQ(warnings(problem, "has no frame_id and is in the world; the base 'base' was placed"),
              1);
    EXPECT_EQ(warnings(load(truck(type), ballIn("\"\""), requestWith("")), "frame_id"), 0);
  }
}

TEST_F(MoveitFrames, TheParentFrameOfTheVirtualJointIsTheWorld) {
  for (const char* type : {"floating", "planar", "fixed"}) {
    const auto model = truck(type);
    const std::string state = std::string(type) == "fixed" ? "" : kAside;
    for (const char* frame : {"odom", "/odom", "world", "\"\""}) {
      const Problem problem =
          load(model, ballIn(frame), requestWith(state, goalIn(frame)) + pathIn(frame));
      EXPECT_EQ(ballOf(problem), Vector3d(0, 0, 9)) << type << frame;
      EXPECT_EQ(problem.goals.at(0).poses.at(0).X_WR.translation, Vector3d(0, 0, 9));
      EXPECT_EQ(problem.constraints.at(0).X_SR.translation, Vector3d(0, 0, 1));
    }
    EXPECT_EQ(
        messageOf(model, ballIn("map"), requestWith(state)),
        "scene.yaml:2: unknown frame 'map' in world.collision_objects[0].header.frame_id; did "
        "you mean 'mast'?");
    EXPECT_EQ(messageOf(model, ballIn("odom"), requestWith(state, goalIn("kitchen")))
                  .find("request.yaml:3: unknown frame 'kitchen' in goal_constraints[0]."
                        "position_constraints[0].header.frame_id; known: world, odom, base, mast"),
              0U);
  }
}

TEST_F(MoveitFrames, AFrameThatPlannedJointsMoveIsRefusedForGoals) {
  EXPECT_EQ(messageOf(truck(""), ballIn("arm"), requestWith("", goalIn("arm"))),
            "request.yaml:3: goal_constraints[0].position_constraints[0].header.frame_id: 'arm' "
            "moves with the planned joints; something at rest to be relative to is expected");
  EXPECT_NE(messageOf(truck("planar"), ballIn("odom"), requestWith(kAside, goalIn("base"), "drive"))
                .find("'base' moves with the planned joints"),
            std::string::npos);
  EXPECT_NE(messageOf(truck("planar"), ballIn("odom"),
                      requestWith(kAside, "[]", "drive") + pathIn("base"))
                .find("'base' moves with the planned joints"),
            std::string::npos);
}

std::string transform(const std::string& header, const std::string& child,
                      const std::string& z = "1") {
  return "  - {" + (header.empty() ? "" : "header: {frame_id: " + header + "}, ") +
         "child_frame_id: " + child + ", transform: {translation: {x: 0, y: 4, z: " + z +
         "}, rotation: {x: 0, y: 0, z: 0, w: 1}}}\n";
}

/// MoveIt names the frame in header.frame_id and the planning frame in child_frame_id; tf the
/// other way round.
TEST_F(MoveitFrames, FixedTransformsAreReadBothWaysRound) {
  const std::string head = "fixed_frame_transforms:\n";
  for (const std::string& list :
       {transform("cam", "odom"), transform("odom", "cam"), transform("", "cam"),
        transform("cam", "world"), transform("/world", "/cam"),
        transform("roof", "odom", "8") + transform("cam", "odom") +
            transform("floor", "odom", "-3")}) {
    const auto model = truck("floating");
    const Problem problem =
        load(model, ballIn("cam", head + list), requestWith(kAside, goalIn("cam")) + pathIn("cam"));
    EXPECT_EQ(ballOf(problem), Vector3d(0, 4, 10)) << list;
    EXPECT_EQ(problem.goals.at(0).poses.at(0).X_WR.translation, Vector3d(0, 4, 10)) << list;
    EXPECT_EQ(problem.constraints.at(0).X_SR.translation, Vector3d(0, 4, 2)) << list;
    // The planning frame stays where it is.
    EXPECT_EQ(ballOf(load(model, ballIn("odom", head + list), requestWith(kAside))),
              Vector3d(0, 0, 9))
        << list;
  }
  // The planning frame of a fixed base is the root link.
  const auto placed =
      robots::withBasePose(*truck(""), Pose{Eigen::Matrix3d::Identity(), {3, 0, 0}});
  for (const std::string& list : {transform("cam", "base"), transform("base", "cam")})
    EXPECT_EQ(ballOf(load(placed, ballIn("cam", head + list), requestWith(""))),
              Vector3d(3, 4, 10));
  EXPECT_EQ(ballOf(load(placed, ballIn("cam", head + transform("cam", "world")), requestWith(""))),
            Vector3d(0, 4, 10));
}

TEST_F(MoveitFrames, FixedTransformsFromOtherFramesAreRefused) {
  const std::string head = "fixed_frame_transforms:\n";
  const auto refused = [&](const std::string& type, const std::string& list) {
    return messageOf(truck(type), ballIn("odom", head + list), requestWith(""));
  };
  EXPECT_EQ(refused("floating", transform("arm", "cam")),
            "scene.yaml:3: fixed_frame_transforms[0].child_frame_id is 'cam', and header.frame_id "
            "'arm'; the planning frame 'odom' is expected as one of them");
  // A base that may move is not the planning frame.
  EXPECT_NE(refused("floating", transform("base", "cam")).find("'odom' is expected as one"),
            std::string::npos);
  EXPECT_EQ(refused("fixed", transform("base", "cam")), "accepted");
  EXPECT_EQ(refused("floating", transform("", "odom")),
            "scene.yaml:3: fixed_frame_transforms[0].child_frame_id is 'odom', and "
            "header.frame_id is missing; the frame's name in header.frame_id, and the planning "
            "frame 'odom' in child_frame_id are expected");
  EXPECT_NE(refused("floating", transform("odom", "odom")).find("so is header.frame_id"),
            std::string::npos);
  EXPECT_EQ(refused("floating", transform("cam", "odom") + transform("cam", "odom", "2")),
            "scene.yaml:4: frame 'cam' stands twice in fixed_frame_transforms; once is expected");
  // As in MoveIt, links stand where the start has them.
  const Problem problem = load(truck("floating"), ballIn("mast", head + transform("mast", "odom")),
                               requestWith(kAside));
  EXPECT_EQ(ballOf(problem), Vector3d(0.5, 2, 9.5));
  EXPECT_EQ(warnings(problem, "the transform of 'mast' is not used"), 1);
}

/// As in MoveIt, an object of one shape without a pose is where its shape is.
TEST_F(MoveitFrames, ObjectsAreFrames) {
  const std::string shape = kBall + ", primitive_poses: [{position: [0, 0, 2]}]";
  const auto scene = [&](const std::string& pose, const std::string& more = "") {
    return "world: {collision_objects: [{id: ball, header: {frame_id: base}, " + pose + shape +
           more + "}, {id: lid, header: {frame_id: ball}, pose: {position: [1, 0, 0]}, " + kBall +
           "}]}\n";
  };
  const auto model = truck("floating");
  const auto expect = [&](const std::string& text, double height) {
    const Problem problem = load(model, text, requestWith(kAside, goalIn("ball")));
    EXPECT_EQ(ballOf(problem).z(), 2 + (text.find("pose: {position: [0, 0, 5]") == 0 ? 5 : 0))
        << text;
    EXPECT_EQ(problem.world.objects.at(1).X_WO.translation, Vector3d(1.5, 2, height)) << text;
    EXPECT_EQ(problem.goals.at(0).poses.at(0).X_WR.translation, Vector3d(0.5, 2, height + 9));
  };
  expect(scene(""), 2);
  expect(scene("pose: {position: [0, 0, 0], orientation: [0, 0, 0, 0]}, "), 2);
  const Problem posed =
      load(model, scene("pose: {position: [0, 0, 5]}, "), requestWith(kAside, goalIn("ball")));
  EXPECT_EQ(ballOf(posed), Vector3d(0.5, 2, 7));
  EXPECT_EQ(posed.world.objects.at(1).X_WO.translation, Vector3d(1.5, 2, 5));
}

/// Objects of the scene refer to the scene's own state. Where that is not the start, what is
/// meant is not known.
TEST_F(MoveitFrames, AFrameThatStandsElsewhereInTheSceneIsRefused) {
  const auto model = truck("planar");
  const std::string scene = "robot_state: {joint_state: {name: [lift], position: [1.5]}}\n";
  EXPECT_EQ(messageOf(model, ballIn("mast", scene), requestWith("")),
            "scene.yaml:3: 'mast' stands elsewhere in the scene's robot_state than at the "
            "request's start; a frame that does not move between them, such as 'odom', is "
            "expected");
  EXPECT_EQ(messageOf(model, ballIn("base", scene), requestWith("")), "accepted");
  const auto holding = [&](const std::string& frame) {
    return "robot_state: {joint_state: {name: [lift], position: [1.5]}, "
           "attached_collision_objects: "
           "[{link_name: arm, object: {id: cup, header: {frame_id: " +
           frame + "}, pose: {position: [0, 0, 1]}, " + kBall + "}}]}\n";
  };
  for (const char* frame : {"arm", "mast"})
    EXPECT_EQ(messageOf(model, holding(frame), requestWith("")), "accepted") << frame;
  EXPECT_EQ(messageOf(model, holding("base"), requestWith("")),
            "scene.yaml:2: robot_state.attached_collision_objects[0].object is held elsewhere in "
            "the scene's robot_state than at the request's start; a header.frame_id of its link "
            "'arm' is expected");
  // The request's own refer to the start.
  const Problem held = load(model, scene,
                            requestWith(", attached_collision_objects: [{link_name: mast, object: "
                                        "{id: cup, header: {frame_id: base}, pose: {position: [0, "
                                        "0, 1]}, " +
                                        kBall + "}}]"));
  EXPECT_EQ(held.robot.attachments.at(0).X_LO.translation, Vector3d(0, 0, 0.5));
}

/// The request's start_state changes the scene's robot_state.
TEST_F(MoveitFrames, JointsThatTheRequestDoesNotNameAreWhereTheSceneHasThem) {
  const std::string scene =
      "robot_state:\n"
      "  joint_state: {name: [lift, turn, brace_joint], position: [1.5, 2, 1]}\n"
      "  multi_dof_joint_state: {joint_names: [vj], transforms: [{translation: [7, 0, 0], "
      "rotation: "
      "[0, 0, 0.6, 0.8]}]}\n";
  const std::string goals =
      "goal_constraints: [{joint_constraints: [{joint_name: turn, position: 1}]}]\n";
  const auto model = truck("planar");
  for (const char* diff : {"is_diff: true, ", "is_diff: False, ", ""}) {
    const Problem problem = load(model, scene,
                                 "group_name: arm\nstart_state: {" + std::string(diff) +
                                     "joint_state: {name: [turn], position: [0.25]}}\n" + goals);
    EXPECT_EQ(start(problem, "turn"), 0.25);
    EXPECT_EQ(start(problem, "lift"), 1.5);
    EXPECT_EQ(start(problem, "vj/x"), 7);
    EXPECT_NEAR(start(problem, "vj/theta"), 2 * std::atan2(0.6, 0.8), 1e-15);
    EXPECT_EQ(warnings(problem, "joint"), 0);
  }
  // Planned joints, too: a request that says nothing of the start means the scene's.
  for (const char* state : {"", "start_state: {is_diff: true}\n",
                            "start_state: {joint_state: {name: [], position: []}}\n"}) {
    const Problem problem = load(model, scene, "group_name: arm\n" + std::string(state) + goals);
    EXPECT_EQ(start(problem, "turn"), 2) << state;
    EXPECT_EQ(start(problem, "lift"), 1.5) << state;
  }
  // Its faults have its lines.
  EXPECT_EQ(
      messageOf(
          model, "robot_state: {joint_state: {name: [lift], position: [5]}}\n",
          "group_name: all\nstart_state: {joint_state: {name: [turn], position: [0]}}\n" + goals),
      "scene.yaml:2: start has joint 'lift' at 5, outside its limits; 0 to 2 is expected");
  EXPECT_EQ(messageOf(model, "robot_state: {joint_state: {name: [lift], position: []}}\n",
                      requestWith("")),
            "scene.yaml:2: 0 positions for 1 names; equally many are expected");
  EXPECT_EQ(messageOf(model, ballIn("odom"), "group_name: arm\n" + goals)
                .find("request.yaml:1: key "
                      "'start_state'"),
            0U);
}

TEST_F(MoveitFrames, JointsThatNeitherFileNamesAreSaid) {
  const auto model = truck("floating");
  const std::string scene = ballIn("odom");
  const std::string one =
      "group_name: arm\nstart_state: {joint_state: {name: [turn, brace_joint], position: [0, "
      "0.7]}}\ngoal_constraints: [{joint_constraints: [{joint_name: turn, position: 1}]}]\n";
  const Problem problem = load(model, scene, one);
  EXPECT_EQ(warnings(problem,
                     "request.yaml:2: neither the request nor the scene says where these "
                     "joints are; they are taken to be at rest at zero or the nearest "
                     "limit: 'vj', 'lift' at 0"),
            1);
  EXPECT_EQ(warnings(problem,
                     "request.yaml:2: joint 'brace_joint' follows another joint and "
                     "stands at 0.25; its position 0.7 is not used"),
            1);
  EXPECT_EQ(warnings(load(model, scene, requestWith(kAside)), "joint"), 0);
}

TEST_F(MoveitFrames, PosesOfPlanarJointsArePlanar) {
  const auto at = [&](const std::string& transform, const std::string& header = "") {
    return load(truck("planar"), ballIn("odom"), requestWith(multiDof(transform, header)));
  };
  const auto refused = [&](const std::string& state) {
    return messageOf(truck("planar"), ballIn("odom"), requestWith(state));
  };
  const Problem turned = at("{translation: [1, 2, 0], rotation: [0, 0, -1, 0]}");
  EXPECT_EQ(start(turned, "vj/x"), 1);
  EXPECT_EQ(start(turned, "vj/y"), 2);
  EXPECT_NEAR(std::abs(start(turned, "vj/theta")), M_PI, 1e-15);
  EXPECT_EQ(warnings(at("{translation: [1, 2, 0.3], rotation: [0, 0, 0, 1]}"),
                     "planar joint 'vj' is at z = 0.3; it has no z, and 0 is taken"),
            1);
  EXPECT_EQ(refused(multiDof("{translation: [1, 2, 0], rotation: [0.6, 0, 0, 0.8]}")),
            "request.yaml:2: planar joint 'vj' is tilted; a turn about z, its normal, is expected");
  EXPECT_EQ(refused(multiDof("{translation: [1, 2, 0]}", "header: {frame_id: base}, ")),
            "request.yaml:2: start_state.multi_dof_joint_state.header.frame_id is 'base'; the "
            "planning frame 'odom' is expected");
  EXPECT_EQ(start(at("{translation: [1, 2, 0]}", "header: {frame_id: /odom}, "), "vj/x"), 1);
  // The same joint in both messages.
  const auto both = [&](const std::string& x) {
    return "group_name: arm\nstart_state: {joint_state: {name: [turn, lift, vj/x], position: [0, "
           "0, " +
           x + "]}" + kAside +
           "}\ngoal_constraints: [{joint_constraints: [{joint_name: turn, position: 1}]}]\n";
  };
  EXPECT_EQ(messageOf(truck("planar"), ballIn("odom"), both("0.5")), "accepted");
  EXPECT_NE(messageOf(truck("planar"), ballIn("odom"), both("0.25")).find("stands twice"),
            std::string::npos);
  EXPECT_NE(
      messageOf(truck("planar"), ballIn("odom"),
                "group_name: arm\nstart_state: {joint_state: {name: [turn, vj], position: [0, "
                "0]}}\ngoal_constraints: [{joint_constraints: [{joint_name: turn, position: "
                "1}]}]\n")
          .find("joint 'vj' has 3 variables; its pose in multi_dof_joint_state is expected"),
      std::string::npos);
}

/// Warnings name the fields that change the robot or the world in MoveIt and not here.
TEST_F(MoveitFrames, WhatIsLeftOutIsSaid) {
  const auto model = truck("");
  const std::string held =
      "robot_state: {attached_collision_objects: [{link_name: arm, object: {id: cup, header: "
      "{frame_id: arm}, pose: {position: [0, 0, 1]}, " +
      kBall + "}}]}\n";
  const std::string drops = "'cup' is held as the scene says; MoveIt would drop it";
  EXPECT_EQ(warnings(load(model, held, requestWith("")), drops), 1);
  EXPECT_EQ(warnings(load(model, held, requestWith(", is_diff: false")), drops), 1);
  EXPECT_EQ(warnings(load(model, held, requestWith(", is_diff: True")), drops), 0);
  const std::string changes = "is_diff is true: objects and contacts of the scene that it changes";
  EXPECT_EQ(warnings(load(model, ballIn("base", "is_diff: true\n"), requestWith("")), changes), 1);
  EXPECT_EQ(warnings(load(model, ballIn("base", "is_diff: False\n"), requestWith("")), changes), 0);
  for (const char* key : {"max_velocity_scaling_factor", "max_acceleration_scaling_factor"})
    for (const auto& [factor, count] : {std::pair("0", 0), {"1", 0}, {"0.1", 1}})
      EXPECT_EQ(warnings(load(model, ballIn("base"), requestWith("") + key + ": " + factor + "\n"),
                         std::string(key) + " is left out; execution."),
                count);
  EXPECT_EQ(warnings(load(model, ballIn("base"), requestWith("") + "max_cartesian_speed: 0.2\n"),
                     "max_cartesian_speed is left out"),
            1);
  EXPECT_NE(messageOf(model, ballIn("base"), requestWith("") + "allowed_planning_time: -1\n")
                .find("allowed_planning_time is -1; zero or more is expected"),
            std::string::npos);
  // A path starts at rest.
  const auto moving = [](const char* rates) {
    return std::string("robot_state: {joint_state: {name: [lift], position: [0], velocity: [") +
           rates + "]}}\n";
  };
  for (const auto& [rates, count] : {std::pair("0", 0), {"0.5", 1}})
    EXPECT_EQ(warnings(load(model, ballIn("base", moving(rates)), requestWith("")),
                       "robot_state.joint_state.velocity is left out: paths start at rest"),
              count);
}

/// MoveIt does not tell whole turns of a free joint apart, and measures by the shorter way round.
TEST_F(MoveitFrames, AGoalOfAFreeJointIsAtATurnThatThePathAllows) {
  const auto model = truck("");
  const auto goalOf = [&](double from, double to, const std::string& more,
                          const std::string& path) {
    const Problem problem =
        load(model, ballIn("base"),
             "group_name: arm\nstart_state: {joint_state: {name: [turn, lift], position: [" +
                 std::to_string(from) +
                 ", 0]}}\ngoal_constraints: [{joint_constraints: [{joint_name: turn, position: " +
                 std::to_string(to) + more +
                 "}]}]\npath_constraints: {joint_constraints: [{joint_name: "
                 "turn, " +
                 path + "}]}\n");
    return problem.goals.at(0).ranges.at(0);
  };
  const std::string wide = "position: 0, tolerance_above: 3.05, tolerance_below: 3.05";
  EXPECT_EQ(goalOf(3, -3, "", wide), std::make_pair(-3.0, -3.0));
  EXPECT_EQ(goalOf(-3, 3, "", wide), std::make_pair(3.0, 3.0));
  EXPECT_NEAR(goalOf(3 + 2 * M_PI, -3, "", wide).first, 2 * M_PI - 3, 1e-5);
  EXPECT_NEAR(goalOf(1, 2 + 4 * M_PI, "", wide).first, 2, 1e-5);
  // Its tolerance alone reaches into what the path allows.
  const auto [lower, upper] = goalOf(3, M_PI, ", tolerance_below: 0.5, tolerance_above: 0.5", wide);
  EXPECT_NEAR(lower, M_PI - 0.5, 1e-5);
  EXPECT_EQ(upper, 3.05);
  // Half a turn to one side and a little to the other is not every turn.
  const auto narrow = goalOf(1, 2, "", "position: 0, tolerance_above: 6.2, tolerance_below: 0.2");
  EXPECT_EQ(narrow, std::make_pair(2.0, 2.0));
  EXPECT_THROW(goalOf(1, -1, "", "position: 0, tolerance_above: 6.2, tolerance_below: 0.2"),
               robots::InputError);
  EXPECT_THROW(goalOf(-1, 2, "", "position: 0, tolerance_above: 6.2, tolerance_below: 0.2"),
               robots::InputError);
  EXPECT_EQ(goalOf(1, -1, "", "position: 0, tolerance_above: 4, tolerance_below: 3.2"),
            std::make_pair(-1.0, -1.0));
}

}  // namespace
}  // namespace leeway::planner
