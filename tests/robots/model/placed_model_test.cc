#include "leeway/robots/placed_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "leeway/robots/kinematics.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

constexpr const char* kCart =
    R"(<robot name="cart"><link name="odom"/><link name="base"/><link name="arm"/>
<link name="drone"/>
<joint name="wheels" type="planar"><parent link="odom"/><child link="base"/><axis xyz="0 0 1"/></joint>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0.3 0 0"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="flight" type="floating"><parent link="odom"/><child link="drone"/></joint></robot>)";

std::shared_ptr<const Model> cart(const std::string& srdf = "") {
  const Folder folder;
  return loadModel(folder.write("cart.urdf", kCart),
                   srdf.empty() ? srdf : folder.write("cart.srdf", srdf));
}

const Variable& variable(const Model& model, const std::string& name) {
  return model.variables[static_cast<std::size_t>(model.findVariable(name))];
}

TEST(PlacedModel, BoundsAreOfTheNamedAxesOnly) {
  const auto free = cart();
  const auto bounded =
      withBounds(*free, {{"wheels", {{"x", {-5, 4}}, {"y", {0, 0}}}}, {"flight", {{"z", {0, 3}}}}});
  EXPECT_EQ(variable(*bounded, "wheels/x").lower, -5);
  EXPECT_EQ(variable(*bounded, "wheels/x").upper, 4);
  EXPECT_EQ(variable(*bounded, "wheels/y").upper, 0);
  EXPECT_EQ(variable(*bounded, "flight/z").upper, 3);
  EXPECT_EQ(variable(*bounded, "flight/x").upper, kInfinite);
  EXPECT_EQ(variable(*bounded, "wheels/theta").upper, kInfinite);
  EXPECT_EQ(variable(*bounded, "elbow").lower, -1);
  EXPECT_EQ(variable(*free, "wheels/x").upper, kInfinite) << "the robot itself is constant";
}

TEST(PlacedModel, LimitsBecomeWiderOnlyWhereThatIsSaid) {
  const auto model = withBounds(*cart(), {{"elbow", {{"", {0.5, 1}}}}});
  const Variable& elbow = variable(*model, "elbow");
  EXPECT_EQ(std::pair(elbow.lower, elbow.upper), std::pair(0.5, 1.0));
  EXPECT_EQ(elbow.narrowed_by, "bounds");
  EXPECT_EQ(elbow.touchRange(), std::pair(-1.0, 1.0)) << "the robot's own";
  EXPECT_EQ(model->defaultConfiguration()[3], 0.5);
  EXPECT_EQ(model->fileConfiguration()[3], 0);
  EXPECT_THROW(withBounds(*model, {{"elbow", {{"", {-1, 1}}}}}), std::invalid_argument);
  const auto wide = withBounds(*model, {{"elbow", {{"", {-0.2, 4, true}}}}});
  EXPECT_EQ(variable(*wide, "elbow").lower, -0.2);
  EXPECT_EQ(variable(*wide, "elbow").upper, 4);
  EXPECT_EQ(variable(*wide, "elbow").touchRange(), std::pair(-1.0, 4.0));
}

TEST(PlacedModel, LimitsOfJointsThatFollowAWidenedOneAreWarnedOf) {
  const Folder folder;
  const auto model = loadModel(folder.write("fingers.urdf", R"(<robot name="fingers">
<link name="base"/><link name="a"/><link name="b"/>
<joint name="left" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint>
<joint name="right" type="prismatic"><parent link="base"/><child link="b"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" velocity="1" effort="1"/><mimic joint="left"/></joint>
</robot>)"),
                               "");
  EXPECT_EQ(variable(*model, "left").upper, 0.5);
  const auto warningsOf = [&](const JointBound& bound) {
    std::string all;
    const auto bounded = withBounds(*model, {{"left", {{"", bound}}}});
    for (const std::string& warning : bounded->warnings) all += warning;
    return all;
  };
  EXPECT_EQ(warningsOf({0, 0.4}).find("follow"), std::string::npos);
  EXPECT_NE(warningsOf({0, 0.8, true}).find("follow it do not hold there: 'right'"),
            std::string::npos)
      << warningsOf({0, 0.8, true});
}

TEST(PlacedModel, AFreeBodyHasItsLowerBoundBelowTheUpper) {
  const auto body = [](JointType type, const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
    return freeBody("brick", {{collision::Shape::sphere(0.1), {}, {}}}, type, lower, upper);
  };
  EXPECT_NO_THROW(body(JointType::kFloating, {0, 0, 0}, {0, 1, 1}));
  EXPECT_THROW(body(JointType::kFloating, {0, 0, 1}, {1, 1, 0}), std::invalid_argument);
  EXPECT_THROW(body(JointType::kPlanar, {0, 1, 0}, {1, 0, 0}), std::invalid_argument);
  EXPECT_THROW(body(JointType::kPlanar, {0, std::nan(""), 0}, {1, 0, 0}), std::invalid_argument);
}

TEST(PlacedModel, AContinuousJointThatIsLimitedBecomesRevolute) {
  std::string urdf = kCart;
  urdf.replace(urdf.find("revolute"), 8, "continuous");
  const Folder folder;
  const auto model = loadModel(folder.write("cart.urdf", urdf), "");
  const auto limited = withBounds(*model, {{"elbow", {{"", {-4, 2}}}}});
  const int elbow = limited->findJoint("elbow");
  EXPECT_EQ(limited->joints[static_cast<std::size_t>(elbow)].type, JointType::kRevolute);
  EXPECT_EQ(limited->steps[static_cast<std::size_t>(elbow)].type, JointType::kRevolute);
  EXPECT_EQ(variable(*limited, "elbow").lower, -4);
  EXPECT_EQ(variable(*limited, "elbow").touchRange(), std::pair(-kInfinite, kInfinite));
  std::vector<double> q = model->defaultConfiguration();
  q[3] = 1.9;
  std::vector<Pose> X_WL(model->links.size()), X_WM(model->links.size());
  forwardKinematics(*model, q, X_WL);
  forwardKinematics(*limited, q, X_WM);
  for (std::size_t l = 0; l < X_WL.size(); ++l)
    EXPECT_EQ(X_WL[l].translation, X_WM[l].translation) << l;
}

/// Proofs and samples within the limits do not hold for wider limits.
TEST(PlacedModel, PairsThatNeverMeetWithinTheLimitsAreNamedWhereTheseAreWider) {
  const auto model = cart(R"(<robot name="cart">
<disable_collisions link1="odom" link2="arm" reason="Never"/>
<disable_collisions link1="odom" link2="base" reason="Never"/>
<disable_collisions link1="base" link2="arm" reason="Adjacent"/></robot>)");
  const auto wide = withBounds(*model, {{"elbow", {{"", {-2, 1, true}}}}});
  ASSERT_EQ(wide->warnings.size(), model->warnings.size() + 1);
  EXPECT_EQ(wide->warnings.back(),
            "bounds of joint 'elbow' are wider than the robot's limits, within which the SRDF says "
            "that pairs never meet; these are not checked: odom and arm");
  const auto narrow = withBounds(*model, {{"elbow", {{"", {-1, 0.5}}}}});
  EXPECT_EQ(narrow->warnings.size(), model->warnings.size());
}

TEST(PlacedModel, WrongBoundsAreNamed) {
  const auto model = cart();
  const std::pair<JointBounds, std::string> wrong[] = {
      {{{"wheel", {{"x", {0, 1}}}}}, "no joint is named 'wheel'; did you mean 'wheels'?"},
      {{{"elbow", {{"x", {0, 1}}}}},
       "axis 'x' is not known; a lower and an upper bound are expected for joint"},
      {{{"elbow", {{"", {-2, 1}}}}},
       "the bounds of joint 'elbow' are -2 to 1, outside its own limits; a range within -1 to 1, "
       "or "
       "'widen', is expected"},
      {{{"elbow", {{"", {-2, kInfinite, true}}}}}, "numbers up to 1e+09 are expected"},
      {{{"elbow", {{"", {1, -1}}}}},
       "the lower bound 1 of joint 'elbow' is above the upper bound -1"},
      {{{"flight", {{"", {0, 1}}}}}, "joint 'flight' is floating; bounds of x, y and z"},
      {{{"wheels", {{"", {0, 1}}}}}, "joint 'wheels' is planar; bounds of x and y are expected"},
      {{{"wheels", {{"z", {0, 1}}}}}, "axis 'z' is not known; x or y is expected"},
      {{{"flight", {{"w", {0, 1}}}}}, "axis 'w' is not known; x, y or z is expected"},
      {{{"wheels", {{"x", {1, 0}}}}},
       "the lower bound 1 of joint 'wheels/x' is above the upper bound 0"},
      {{{"wheels", {{"x", {0, std::nan("")}}}}}, "coordinates up to"},
      {{{"wheels", {{"x", {-kInfinite, 0}}}}}, "coordinates up to"},
      {{{"wheel", {}}}, "no joint is named 'wheel'; did you mean 'wheels'?"},
      {{{"wheels", {}}}, "joint 'wheels' is planar; bounds of x and y are expected"},
      {{{"elbow", {}}}, "joint 'elbow' has no bounds; a lower and an upper bound are expected"},
  };
  for (const auto& [bounds, words] : wrong) try {
      withBounds(*model, bounds);
      ADD_FAILURE() << words;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
}

TEST(PlacedModel, AllLinksMoveWithTheBase) {
  const auto model = cart();
  Pose X_WB;
  X_WB.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).matrix();
  X_WB.translation = {1, 2, 0.5};
  const auto placed = withBasePose(*model, X_WB);
  std::vector<double> q = model->defaultConfiguration();
  q[static_cast<std::size_t>(model->findVariable("wheels/x"))] = 0.7;
  q[static_cast<std::size_t>(model->findVariable("elbow"))] = 0.4;
  std::vector<Pose> before(model->links.size()), after(model->links.size());
  forwardKinematics(*model, q, before);
  forwardKinematics(*placed, q, after);
  for (std::size_t l = 0; l < before.size(); ++l) {
    const Pose expected = X_WB * before[l];
    EXPECT_LT((after[l].translation - expected.translation).norm(), 1e-15) << l;
    EXPECT_LT((after[l].rotation - expected.rotation).norm(), 1e-15) << l;
  }
}

TEST(PlacedModel, ABaseThatAJointMovesAndNoPlacementAreRefused) {
  const auto moved = cart(R"(<robot name="cart">
<virtual_joint name="root" type="planar" parent_frame="map" child_link="odom"/></robot>)");
  EXPECT_NE(basePoseFault(*moved, {}).find("joint 'root' moves the base"), std::string::npos);
  EXPECT_THROW(withBasePose(*moved, {}), std::invalid_argument);
  EXPECT_EQ(basePoseFault(*cart(), {}), "");
  Pose wrong;
  wrong.translation.x() = kInfinite;
  EXPECT_NE(basePoseFault(*cart(), wrong), "");
  wrong = {};
  wrong.rotation.diagonal() << 1, 1, -1;  // mirrors
  EXPECT_NE(basePoseFault(*cart(), wrong), "");
  wrong.rotation = 1.01 * Eigen::Matrix3d::Identity();
  EXPECT_NE(basePoseFault(*cart(), wrong), "");
}

}  // namespace
}  // namespace leeway::robots
