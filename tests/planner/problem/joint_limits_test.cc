// MoveIt's joint_limits.yaml.

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "leeway/planner/problem.h"
#include "leeway/planner/trajectory.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Two turning joints, a slider, one that follows the first at twice its speed, and a planar one.
const std::string kFiveJoints = [] {
  std::string text = "<robot name=\"r\"><link name=\"l0\"/>";
  const char* const joints[] = {
      R"(name="shoulder" type="revolute"><limit lower="-3" upper="3" effort="1" velocity="2"/>)",
      R"(name="wrist" type="continuous"><limit effort="1" velocity="2"/>)",
      R"(name="slide" type="prismatic"><limit lower="0" upper="1" effort="1" velocity="2"/>)",
      R"(name="finger" type="revolute"><mimic joint="shoulder" multiplier="-2" offset="0.5"/>
<limit lower="-9" upper="9" effort="1" velocity="9"/>)",
      R"(name="cart" type="planar">)",
      R"(name="flange" type="fixed">)"};
  int i = 0;
  for (const char* joint : joints) {
    const std::string parent = "l" + std::to_string(i), child = "l" + std::to_string(++i);
    text += "<link name=\"" + child + "\"/><joint " + joint + "<parent link=\"" + parent +
            "\"/><child link=\"" + child + "\"/><axis xyz=\"0 0 1\"/></joint>";
  }
  return text + "</robot>";
}();

class JointLimits : public ::testing::Test {
 protected:
  std::shared_ptr<const robots::Model> own_ =
      robots::loadModel(folder().write("r.urdf", kFiveJoints), "");

  std::shared_ptr<const robots::Model> with(const std::string& limits) {
    return withJointLimits(*own_, folder().write("joint_limits.yaml", limits));
  }
  const robots::Variable& of(const std::string& name) {
    return model_->variables[static_cast<std::size_t>(model_->findVariable(name))];
  }
  std::string messageOf(const std::string& limits) {
    try {
      with(limits);
    } catch (const robots::InputError& error) {
      return std::string(error.what()).substr(folder().path().size() + 1);
    }
    return "accepted";
  }
  Folder& folder() {
    static Folder folder;
    return folder;
  }
  std::shared_ptr<const robots::Model> model_;
};

TEST_F(JointLimits, HoldAsInMoveit) {
  model_ = with(R"(
default_velocity_scaling_factor: 0.1
joint_limits:
  shoulder:
    has_velocity_limits: true
    max_velocity: 1.5
    has_acceleration_limits: true
    max_acceleration: 4
    has_jerk_limits: true
    max_jerk: 50
    has_position_limits: true
    min_position: -1
    max_position: 2.5
  wrist:
    has_velocity_limits: false
    max_velocity: 100
    has_acceleration_limits: false
    max_acceleration: 0
    max_deceleration: -3
    min_position: -4
    max_position: 4
  slide: {max_position: 0.5, max_velocity: 3}
)");
  EXPECT_EQ(of("shoulder").velocity, 1.5);
  EXPECT_EQ(of("shoulder").acceleration, 4);
  EXPECT_EQ(of("shoulder").jerk, 50);
  EXPECT_EQ(std::pair(of("shoulder").lower, of("shoulder").upper), std::pair(-1.0, 2.5));
  EXPECT_EQ(of("shoulder").touchRange(), std::pair(-3.0, 3.0)) << "the robot's own";
  EXPECT_EQ(of("wrist").velocity, 2) << "false: the robot's own holds";
  EXPECT_EQ(of("wrist").acceleration, 3) << "decelerations have either sign";
  EXPECT_EQ(std::pair(of("wrist").lower, of("wrist").upper), std::pair(-4.0, 4.0));
  EXPECT_EQ(std::pair(of("slide").lower, of("slide").upper), std::pair(0.0, 0.5));
  EXPECT_EQ(of("slide").velocity, 3) << "given without has_velocity_limits, it holds";
  EXPECT_EQ(of("slide").acceleration, kNoLimit);
  ASSERT_EQ(model_->warnings.size(), own_->warnings.size() + 2);
  const std::string& scaling = model_->warnings[own_->warnings.size()];
  const std::string& faster = model_->warnings.back();
  EXPECT_NE(faster.find(":22: "), std::string::npos) << faster;
  EXPECT_NE(faster.find("max_velocity is 3, above 2 of the robot's file"), std::string::npos)
      << faster;
  EXPECT_NE(scaling.find(":2: 'default_velocity_scaling_factor' is left out"), std::string::npos)
      << scaling;
  EXPECT_EQ(own_->variables[0].velocity, 2) << "the robot itself is constant";
}

/// True and False are words of MoveIt's files.
TEST_F(JointLimits, FlagsAreInCapitalsToo) {
  model_ = with(R"(joint_limits:
  shoulder:
    {has_velocity_limits: True, max_velocity: 0.1, has_acceleration_limits: False, max_acceleration: 1,
     has_soft_limits: False, soft_lower_limit: -1}
)");
  EXPECT_EQ(of("shoulder").velocity, 0.1);
  EXPECT_EQ(of("shoulder").acceleration, kNoLimit);
  EXPECT_EQ(model_->warnings.size(), own_->warnings.size());
}

TEST_F(JointLimits, OfAJointThatFollowsLimitTheOneItFollows) {
  model_ = with("joint_limits: {finger: {max_velocity: 3, min_position: -1.5, max_position: 4.5}}");
  EXPECT_EQ(of("shoulder").velocity, 1.5);
  EXPECT_EQ(std::pair(of("shoulder").lower, of("shoulder").upper), std::pair(-2.0, 1.0));
  model_ = with("joint_limits: {shoulder: {max_velocity: 1}, finger: {max_velocity: 3}}");
  EXPECT_EQ(of("shoulder").velocity, 1);
}

/// Warnings name the line of each entry that is left out.
/// Parameters of a ROS node, and limits of frames beside those of joints.
TEST_F(JointLimits, StandBelowTheNamesOfParameters) {
  const std::string limits = "joint_limits: {shoulder: {max_velocity: 1.5}}, cartesian_limits: {}";
  for (const std::string& text :
       {"{" + limits + "}", "robot_description_planning: {" + limits + "}",
        "/**: {ros__parameters: {robot_description_planning: {" + limits + "}}}"}) {
    model_ = with(text + "\n");
    EXPECT_EQ(of("shoulder").velocity, 1.5) << text;
    EXPECT_NE(model_->warnings.back().find("'cartesian_limits' is left out"), std::string::npos);
  }
  EXPECT_NE(messageOf("robot_description_planning: {joint_limits: {}}\nother: 1\n").find("other"),
            std::string::npos);
}

TEST_F(JointLimits, WarnOfWhatIsLeftOut) {
  const std::pair<std::string, std::string> kinds[] = {
      {"gripper_left: {max_velocity: 1}", "has no joint 'gripper_left': its limits are left out"},
      {"shoulder: {min_position: -3.5, max_position: 3}",
       "the limits of joint 'shoulder' reach beyond -3 to 3 of the robot's file, which hold"},
      {"cart: {min_position: -1, max_position: 1}", "'bounds' limit planar and floating joints"},
      {"flange: {max_velocity: 1}", "joint 'flange' does not move"},
      {"wrist: {angle_wraparound: true}", "'angle_wraparound' of joint 'wrist' is left out"},
      {"wrist: {has_soft_limits: true}", "soft limits of joint 'wrist' are left out; min_position"},
      {"wrist: {soft_upper_limit: 1, soft_lower_limit: -1, k_velocity: 1, k_position: 2}",
       "soft limits of joint 'wrist' are left out: soft_lower_limit -1, soft_upper_limit 1; "},
      {"wrist: {max_velocity: 1, min_velocity: -2}", "min_velocity is left out"},
  };
  for (const auto& [limit, words] : kinds) {
    model_ = with("joint_limits:\n  " + limit + "\n");
    ASSERT_EQ(model_->warnings.size(), own_->warnings.size() + 1) << limit;
    const std::string& warning = model_->warnings.back();
    EXPECT_NE(warning.find("joint_limits.yaml:2: "), std::string::npos) << warning;
    EXPECT_NE(warning.find(words), std::string::npos) << warning;
    EXPECT_EQ(of("shoulder").upper, 3);
  }
}

TEST_F(JointLimits, WhatChangesTheQuestionIsRefused) {
  const std::pair<std::string, std::string> wrong[] = {
      {"shouldre: {max_velocity: 1}",
       ":2: robot 'r' has no joint 'shouldre'; did you mean 'shoulder'?"},
      {"shoulder: {max_velocty: 1}", "did you mean 'max_velocity'?"},
      {"shoulder: {max_velocity: 0}",
       "joint_limits.shoulder.max_velocity is 0; a number from 1e-09"},
      {"shoulder: {max_velocity: -1}", "is -1; a number from 1e-09"},
      {"shoulder: {max_jerk: fast}", "joint_limits.shoulder.max_jerk"},
      {"shoulder: {has_velocity_limits: true}",
       "has_velocity_limits is true, and 'max_velocity' is missing"},
      {"shoulder: {has_position_limits: true}", "is true, and 'max_position' is missing"},
      {"shoulder: {has_velocity_limits: 1, max_velocity: 1}", "has_velocity_limits"},
      {"shoulder: {min_position: 1, max_position: -1}",
       "a lower limit below the upper one is expected"},
      {"shoulder: {min_position: 4, max_position: 5}", "leave nothing of -3 to 3, its range"},
      {"wrist: {max_position: 1}", "joint 'wrist' has a limit on one side only"},
      {"wrist: {max_velocity: !degrees 90}",
       ":2: joint_limits.wrist.max_velocity is '90' with a tag"},
  };
  for (const auto& [limit, words] : wrong) {
    const std::string message = messageOf("joint_limits:\n  " + limit + "\n");
    EXPECT_NE(message.find(words), std::string::npos) << limit << '\n' << message;
  }
  EXPECT_NE(messageOf("[1]").find("is no map"), std::string::npos);
  EXPECT_NE(messageOf("shoulder: {max_velocity: 1}").find("unknown key 'shoulder'"),
            std::string::npos);
  EXPECT_NE(messageOf("default_velocity_scaling_factor: 1").find("'joint_limits' is missing"),
            std::string::npos);
}

/// The key of problem files, what a problem says itself, and where timed paths use the limits.
TEST_F(JointLimits, AreTheDefaultsOfAProblem) {
  folder().write("joint_limits.yaml", R"(
joint_limits: {shoulder: {max_velocity: 1.5, max_acceleration: 4, max_jerk: 50, min_position: -1}}
)");
  const auto load = [&](const std::string& more) {
    return loadProblem(folder().write("problem.yaml", R"(leeway: 1
robot: {urdf: r.urdf, joint_limits: joint_limits.yaml}
bounds: {cart: {x: [0, 1], y: [0, 1]}}
start: {shoulder: 0, wrist: 0, slide: 0, cart: {position: [0, 0], angle: 0}}
goal: {shoulder: 1, wrist: 0, slide: 0, cart: {position: [0, 0], angle: 0}}
)" + more));
  };
  MotionLimits limits = motionLimits(load(""));
  EXPECT_EQ(limits.velocity[0], 1.5);
  EXPECT_EQ(limits.acceleration[0], 4);
  EXPECT_EQ(limits.jerk[0], 50);
  EXPECT_EQ(limits.acceleration[2], 4) << "2 m/s in half a second";
  EXPECT_EQ(limits.jerk[2], kNoLimit);
  limits =
      motionLimits(load("execution: {velocities: {shoulder: 1}, accelerations: {shoulder: 2}}"));
  EXPECT_EQ(limits.velocity[0], 1);
  EXPECT_EQ(limits.acceleration[0], 2);
  limits = motionLimits(load("execution: {acceleration_scale: 0.5, jerk_scale: 0.1}"));
  EXPECT_EQ(limits.acceleration[0], 2);
  EXPECT_EQ(limits.jerk[0], 5);
  EXPECT_EQ(limits.jerk[2], kNoLimit);
  folder().write("problem.yaml",
                 "leeway: 1\nrobot: {urdf: r.urdf, joint_limits: none.yaml}\n"
                 "start: zero\ngoal: zero\n");
  try {
    loadProblem(folder().path("problem.yaml"));
    ADD_FAILURE() << "accepted";
  } catch (const robots::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("problem.yaml:2: robot.joint_limits names '"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace leeway::planner
