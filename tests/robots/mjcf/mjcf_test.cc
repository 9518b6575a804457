#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "leeway/collision/convex_hull.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "leeway/robots/named_states.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::robots {
namespace {

using collision::ShapeType;

std::string model(const std::string& body, const std::string& rest = "") {
  return "<mujoco>\n<worldbody>\n" + body + "\n</worldbody>\n" + rest + "\n</mujoco>\n";
}

std::shared_ptr<const Model> load(const std::string& text) {
  const Folder folder;
  return loadModel(folder.write("robot.xml", text), "");
}

const Geometry& geometryOf(const Model& robot, const std::string& link, std::size_t index = 0) {
  return robot.links.at(static_cast<std::size_t>(robot.findLink(link))).geometries.at(index);
}

bool isDisabled(const Model& robot, const std::string& a, const std::string& b,
                const std::string& why) {
  const std::pair<int, int> pair = std::minmax(robot.findLink(a), robot.findLink(b));
  return std::any_of(
      robot.disabled_pairs.begin(), robot.disabled_pairs.end(), [&](const DisabledPair& d) {
        return std::pair(d.link_a, d.link_b) == pair && d.reason == why && d.is_of_mjcf;
      });
}

bool isEnabled(const Model& robot, const std::string& a, const std::string& b) {
  const std::pair<int, int> pair = std::minmax(robot.findLink(a), robot.findLink(b));
  return std::count(robot.enabled_pairs.begin(), robot.enabled_pairs.end(), pair) > 0;
}

std::vector<double> stateOf(const Model& robot, const std::string& name) {
  std::vector<double> q = robot.defaultConfiguration();
  for (const GroupState& state : robot.group_states)
    if (state.name == name) {
      EXPECT_EQ(state.values.size(), q.size());
      for (const auto& [variable, value] : state.values)
        q[static_cast<std::size_t>(variable)] = value;
      return q;
    }
  ADD_FAILURE() << "no state " << name;
  return q;
}

constexpr const char* kArm = R"(<mujoco model="twolink">
  <compiler angle="degree" eulerseq="zYx" autolimits="true"/>
  <default>
    <geom conaffinity="1"/>
    <default class="arm">
      <joint axis="0 1 0" range="-90 120"/>
      <geom type="capsule" size="0.04"/>
      <default class="visual">
        <geom contype="0" conaffinity="0"/>
      </default>
    </default>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1"/>
    <body name="base" pos="0.1 0.2 0.3" euler="30 20 10">
      <geom type="box" size="0.1 0.08 0.05"/>
      <body name="upper" childclass="arm" pos="0 0 0.1">
        <joint name="shoulder" pos="0.01 0 0.02" ref="10"/>
        <geom fromto="0 0 0.16 0.02 0.01 0.4"/>
        <geom class="visual" type="sphere" size="0.2"/>
        <body name="fore" pos="0 0 0.55" axisangle="1 0 0 20">
          <joint name="roll" axis="0 0 1" range="0 0"/>
          <joint name="extend" type="slide" axis="0 3 4" range="-0.1 0.2" pos="1 2 3" ref="0.05"/>
          <geom type="ellipsoid" size="0.05 0.03 0.1" pos="0 0 0.1" zaxis="1 1 0"/>
          <geom type="cylinder" size="0.02 0.1" pos="0.1 0 0.1" xyaxes="1 1 0 0 0 1"/>
          <body name="tool" pos="0 0 0.3">
            <geom type="sphere" size="0.03"/>
          </body>
        </body>
      </body>
    </body>
    <body name="cube" pos="1 0 0.5" quat="1 1 0 0">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1"/>
    </body>
  </worldbody>
  <keyframe>
    <key name="home" qpos="0.3 -0.4 0.1 1.1 0.2 0.6 2 0 2 0"/>
  </keyframe>
</mujoco>
)";

struct Placed {
  const char* body;
  double position[3], rotation[9];  // row by row
};

void expectPose(const Pose& X, const Placed& truth) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(X.translation(i), truth.position[i], 1e-14) << truth.body << i;
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(X.rotation(i, j), truth.rotation[3 * i + j], 1e-14) << truth.body << i << j;
  }
}

// The poses that MuJoCo 2.2.2 computes (mj_kinematics) for the key "home": xpos, xmat.
// clang-format off
constexpr Placed kBodies[] = {
    {"base", {0.10000000000000001, 0.20000000000000001, 0.29999999999999999}, {0.81379768134937369, -0.40331711458527708, 0.41841204441673269, 0.50000000000000011, 0.85286853195244339, -0.1503837331804353, -0.29619813272602397, 0.33158795558326748, 0.89572099109138126}},
    {"upper", {0.14045780479028705, 0.183537718775765, 0.39155183775410468}, {0.75504137424369921, -0.40331711458527708, 0.5169601805388816, 0.51488840549330606, 0.85286853195244339, -0.086632540617514409, -0.40595868394301821, 0.33158795558326748, 0.85161433445155321}},
    {"fore", {0.45296906753721233, 0.14830714613764326, 0.89932905204936076}, {0.77417305252491053, 0.1078037893797614, 0.62372624422868961, 0.17368891752188234, 0.91138572561642828, -0.37310617667454121, -0.60867745536888396, 0.39718308390209828, 0.68684594574597269}},
    {"tool", {0.64008694080581918, 0.036375293135280901, 1.1053828357731526}, {0.77417305252491009, 0.10780378937976134, 0.62372624422868939, 0.17368891752188229, 0.91138572561642806, -0.37310617667454105, -0.60867745536888374, 0.39718308390209811, 0.68684594574597246}},
    {"cube", {1.1000000000000001, 0.20000000000000001, 0.59999999999999998}, {0, 0, 1, 0, 1, 0, -1, 0, 0}},
};
constexpr Placed kGeoms[] = {
    {"upper", {0.29074048351068449, 0.16869383411755623, 0.62760220433902569}, {-0.085567840125803596, -0.82362172177002824, -0.56064730817580744, -0.9951687605778351, 0.097839948916872477, 0.00815367192858929, 0.048138162679730367, 0.55863637889464168, -0.82801456114569749}},
    {"fore", {0.51534169196008128, 0.11099652847018913, 0.96801364662395806}, {-0.10785642532554859, -0.77422568847069773, 0.62365180576028911, -0.10502249641811884, 0.63267431167642718, 0.76726363825667265, -0.98860369550295601, 0.01725684376802622, -0.14954910424695081}},
    {"fore", {0.59275899721257241, 0.12836542022237737, 0.90714590108706961}, {0.623651805760289, 0.62372624422868972, 0.47119422474421779, 0.76726363825667265, -0.3731061766745411, -0.52163041546332467, -0.14954910424695092, 0.6868459457459728, -0.71125080824646914}},
};
// clang-format on

TEST(Mjcf, BodiesAndGeomsStandWhereMuJoCoHasThem) {
  const auto robot = load(kArm);
  EXPECT_EQ(robot->name, "twolink");
  std::vector<Pose> X_WL(robot->links.size());
  forwardKinematics(*robot, stateOf(*robot, "home"), X_WL);
  const auto poseOf = [&](const char* link) {
    return X_WL.at(static_cast<std::size_t>(robot->findLink(link)));
  };
  for (const Placed& truth : kBodies) expectPose(poseOf(truth.body), truth);
  expectPose(poseOf("upper") * geometryOf(*robot, "upper").X_BG, kGeoms[0]);
  expectPose(poseOf("fore") * geometryOf(*robot, "fore", 0).X_BG, kGeoms[1]);
  expectPose(poseOf("fore") * geometryOf(*robot, "fore", 1).X_BG, kGeoms[2]);
}

TEST(Mjcf, ShapesAreThoseThatCollide) {
  const auto robot = load(kArm);
  EXPECT_EQ(geometryOf(*robot, "world").shape.type(), ShapeType::kHalfSpace);
  EXPECT_EQ(geometryOf(*robot, "world").name, "floor");
  EXPECT_EQ(geometryOf(*robot, "base").shape.halfExtents(), Eigen::Vector3d(0.1, 0.08, 0.05));
  const auto& upper = robot->links[static_cast<std::size_t>(robot->findLink("upper"))];
  ASSERT_EQ(upper.geometries.size(), 1u);  // the other one is visual
  EXPECT_EQ(upper.geometries[0].shape.type(), ShapeType::kCapsule);
  EXPECT_EQ(upper.geometries[0].shape.radius(), 0.04);
  EXPECT_NEAR(upper.geometries[0].shape.halfLength(), std::sqrt(4e-4 + 1e-4 + 0.24 * 0.24) / 2,
              1e-16);
  EXPECT_EQ(geometryOf(*robot, "fore", 0).shape.type(), ShapeType::kEllipsoid);
  EXPECT_EQ(geometryOf(*robot, "fore", 0).shape.halfExtents(), Eigen::Vector3d(0.05, 0.03, 0.1));
  EXPECT_EQ(geometryOf(*robot, "fore", 1).shape.type(), ShapeType::kCylinder);
  EXPECT_EQ(geometryOf(*robot, "fore", 1).shape.halfLength(), 0.1);
  EXPECT_EQ(geometryOf(*robot, "tool").shape.type(), ShapeType::kSphere);
}

TEST(Mjcf, JointsAndLimitsAreThoseOfTheFile) {
  const auto robot = load(kArm);
  const auto variable = [&](const char* name) {
    return robot->variables.at(static_cast<std::size_t>(robot->findVariable(name)));
  };
  EXPECT_DOUBLE_EQ(variable("shoulder").lower, -std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(variable("shoulder").upper, 2 * std::numbers::pi / 3);
  EXPECT_EQ(robot->joints[static_cast<std::size_t>(robot->findJoint("roll"))].type,
            JointType::kContinuous);
  EXPECT_EQ(variable("extend").lower, -0.1);
  EXPECT_EQ(variable("extend").upper, 0.2);
  EXPECT_GE(robot->findVariable("cube/qw"), 0);
  EXPECT_EQ(robot->links[0].name, "world");
  EXPECT_GE(robot->findLink("upper/shoulder"), 0);  // beside its origin
  EXPECT_GE(robot->findLink("fore/roll"), 0);       // the first of two
  EXPECT_EQ(robot->findLink("fore/extend"), -1);
}

TEST(Mjcf, KeysAreStates) {
  const auto robot = load(kArm);
  const std::vector<double> home = stateOf(*robot, "home");
  const auto value = [&](const std::vector<double>& q, const char* name) {
    return q.at(static_cast<std::size_t>(robot->findVariable(name)));
  };
  EXPECT_EQ(value(home, "shoulder"), 0.3);
  EXPECT_EQ(value(home, "extend"), 0.1);
  EXPECT_EQ(value(home, "cube/z"), 0.6);
  EXPECT_EQ(value(home, "cube/qx"), 0);
  EXPECT_EQ(value(home, "cube/qy"), 2);
  EXPECT_EQ(value(home, "cube/qw"), 2);
  const std::vector<double> rest = stateOf(*robot, "qpos0");
  EXPECT_DOUBLE_EQ(value(rest, "shoulder"), std::numbers::pi / 18);
  EXPECT_EQ(value(rest, "extend"), 0.05);
  EXPECT_EQ(value(rest, "cube/x"), 1);
  EXPECT_DOUBLE_EQ(value(rest, "cube/qx"), std::sqrt(0.5));
}

TEST(Mjcf, JointsRestWhereTheFileHasThem) {
  const auto robot = load(kArm);
  EXPECT_EQ(robot->defaultConfiguration(), stateOf(*robot, "qpos0"));
  const std::vector<GroupState> states = namedStates(*robot);
  const auto zero = std::find_if(states.begin(), states.end(),
                                 [](const GroupState& state) { return state.name == "zero"; });
  ASSERT_NE(zero, states.end());
  for (const auto& [v, value] : zero->values) {
    const std::string& name = robot->variables[static_cast<std::size_t>(v)].name;
    const double rest = robot->defaultConfiguration()[static_cast<std::size_t>(v)];
    EXPECT_EQ(value, name.starts_with("cube/") ? rest : 0) << name;
  }
  // A floor in <worldbody> is a part of the robot, and a warning says so.
  const auto said = [](const Model& model, const char* words) {
    return std::any_of(model.warnings.begin(), model.warnings.end(),
                       [&](const std::string& w) { return w.find(words) != std::string::npos; });
  };
  const char* const body = R"(<body name="a"><joint name="j"/><geom size="0.1"/></body>)";
  EXPECT_FALSE(said(*load(model(body)), "of <worldbody>"));
  EXPECT_TRUE(said(*load(model(std::string(R"(<geom type="plane" size="0 0 1"/>)") + body)),
                   ": 1 geom of <worldbody> counts as a part of the robot"));
}

TEST(Mjcf, FramesPlaceWhatIsInThem) {
  const auto robot = load(model(R"(<frame pos="1 0 0" euler="0 0 90">
    <body name="a" pos="1 0 0">
      <frame pos="0 0 1" axisangle="1 0 0 90">
        <joint name="j" axis="0 1 0" pos="0 0.5 0"/>
        <geom size="0.1" pos="0 1 0"/>
      </frame>
      <body name="b" pos="0 0 2"><geom size="0.1"/></body>
    </body>
  </frame>)"));
  std::vector<double> q = {std::numbers::pi / 2};
  std::vector<Pose> X_WL(robot->links.size());
  forwardKinematics(*robot, q, X_WL);
  const Pose& X_WA = X_WL.at(static_cast<std::size_t>(robot->findLink("a")));
  // The joint turns about z of the body, through its origin.
  EXPECT_NEAR((X_WA.translation - Eigen::Vector3d(1, 1, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((X_WA.rotation.col(0) - Eigen::Vector3d(-1, 0, 0)).norm(), 0, 1e-15);
  const Pose X_WG = X_WA * geometryOf(*robot, "a").X_BG;
  EXPECT_NEAR((X_WG.translation - Eigen::Vector3d(1, 1, 2)).norm(), 0, 1e-15);
}

TEST(Mjcf, UnnamedBodiesAndJointsGetNames) {
  const auto robot = load(model(R"(<body><joint/><geom size="0.1"/>
    <body name="b"><joint/><joint axis="1 0 0"/><geom size="0.1"/></body>
    <body name="body_1"><geom size="0.1"/></body></body>)"));
  EXPECT_GE(robot->findLink("body_1_"), 0);
  EXPECT_GE(robot->findLink("b"), 0);
  EXPECT_GE(robot->findVariable("body_1_"), 0);
  EXPECT_GE(robot->findVariable("b_1"), 0);
  EXPECT_GE(robot->findVariable("b_2"), 0);
}

TEST(Mjcf, SizesOfAClassStayWhereAnElementGivesFewer) {
  const auto robot = load("<mujoco><default><geom type=\"capsule\" size=\"0.1 0.5\"/></default>\n" +
                          model("<body name=\"a\"><joint/><geom size=\"0.2\"/></body>").substr(8));
  EXPECT_EQ(geometryOf(*robot, "a").shape.radius(), 0.2);
  EXPECT_EQ(geometryOf(*robot, "a").shape.halfLength(), 0.5);
}

/// As in MuJoCo, which copies the outer class where an inner one begins.
TEST(Mjcf, ALaterSectionOfDefaultsLeavesClassesAsTheyAre) {
  const auto robot = load(
      "<mujoco><default><default class=\"a\"><geom rgba=\"1 0 0 1\"/></default></default>"
      "<default><geom type=\"box\" size=\".1 .1 .1\"/></default>\n" +
      model(
          "<body name=\"a\"><joint/><geom class=\"a\" size=\".2\"/></body><body name=\"b\"><joint/>"
          "<geom/></body>")
          .substr(8));
  EXPECT_EQ(geometryOf(*robot, "a").shape.type(), ShapeType::kSphere);
  EXPECT_EQ(geometryOf(*robot, "a").shape.radius(), 0.2);
  EXPECT_EQ(geometryOf(*robot, "b").shape.type(), ShapeType::kBox);
}

TEST(Mjcf, LinesOfPolycoefAreMimics) {
  const auto robot = load(model(
      R"(<body name="a"><joint name="j" type="slide" range="0 1" ref="0.25"/><geom size="0.1"/></body>
<body name="b"><joint name="k" type="slide" ref="0.5"/><geom size="0.1"/></body>
<body name="c"><joint name="l" type="slide"/><geom size="0.1"/></body>
<body name="d"><joint name="m" type="slide"/><geom size="0.1"/></body>
<body name="e"><joint name="n" type="slide"/><geom size="0.1"/></body>
<body name="f"><joint name="o" type="slide" ref="1"/><geom size="0.1"/></body>)",
      R"(<equality><joint joint1="k" joint2="j" polycoef="0.1 2"/><joint joint1="o" joint2="j" polycoef="0.4 0"/>
<joint joint1="l" polycoef="0.3 1 0 0 0"/>
<joint joint1="m" joint2="j" polycoef="0 1 1"/>
<joint joint1="n" joint2="j" active="false"/></equality>)"));
  std::vector<double> q = robot->defaultConfiguration();
  ASSERT_EQ(q.size(), 3u);  // j, m, n
  q[static_cast<std::size_t>(robot->findVariable("j"))] = 0.75;
  std::vector<Pose> X_WL(robot->links.size());
  forwardKinematics(*robot, q, X_WL);
  const auto height = [&](const char* link) {
    return X_WL.at(static_cast<std::size_t>(robot->findLink(link))).translation.z();
  };
  EXPECT_DOUBLE_EQ(height("a"), 0.5);
  EXPECT_DOUBLE_EQ(height("b"), 0.1 + 2 * 0.5);  // q - ref = 0.1 + 2 (0.75 - 0.25)
  EXPECT_DOUBLE_EQ(height("c"), 0.3);
  EXPECT_DOUBLE_EQ(height("f"), 0.4);
  EXPECT_NE(std::find_if(robot->warnings.begin(), robot->warnings.end(),
                         [](const std::string& w) {
                           return w.find("robot.xml:12: the equality of joint \"m\"") !=
                                  std::string::npos;
                         }),
            robot->warnings.end());
}

TEST(Mjcf, AJointThatAnotherEqualityCouplesIsNotLocked) {
  const auto robot = load(model(
      R"(<body name="a"><joint name="j" type="slide"/><geom size="0.1"/></body>
<body name="b"><joint name="k" type="slide"/><geom size="0.1"/></body>)",
      R"(<equality><joint joint1="k" joint2="j"/>
<joint joint1="j" polycoef="0.3"/>
<joint joint1="k" polycoef="0.3"/>
<joint joint1="j" joint2="k"/></equality>)"));
  std::vector<Pose> X_WL(robot->links.size());
  forwardKinematics(*robot, std::vector<double>{0.75}, X_WL);
  EXPECT_EQ(X_WL.at(static_cast<std::size_t>(robot->findLink("b"))).translation.z(), 0.75);
  ASSERT_EQ(robot->warnings.size(), 3u);
  for (const auto& [index, place] : {std::pair(0u, "7: the equality of joint \"j\""),
                                     std::pair(1u, "8: the equality of joint \"k\""),
                                     std::pair(2u, "9: the equality of joint \"j\"")})
    EXPECT_NE(robot->warnings[index].find("robot.xml:" + std::string(place) +
                                          " is left out: another equality couples"),
              std::string::npos)
        << robot->warnings[index];
}

// Pairs.

TEST(Mjcf, PairsAreThoseThatMuJoCoCollides) {
  const auto robot = load(model(
      R"(<geom type="plane" size="1 1 1"/>
<body name="base"><geom size="0.1"/>
  <body name="one"><joint/><geom size="0.1"/>
    <body name="flange"><geom size="0.1"/>
      <body name="two"><joint/><geom size="0.1"/>
        <body name="three"><joint/><geom size="0.1" contype="2" conaffinity="2"/></body>
        <body name="four"><joint/><geom size="0.1" contype="0" conaffinity="1"/></body>
      </body></body></body></body>)",
      R"(<contact><exclude body1="four" body2="base"/></contact>)"));
  // A fixed body collides with bodies that turn on it; other bodies do not collide with parents.
  EXPECT_TRUE(isEnabled(*robot, "base", "one"));
  EXPECT_TRUE(isDisabled(*robot, "one", "two", "parent and child"));
  EXPECT_TRUE(isDisabled(*robot, "flange", "two", "parent and child"));
  EXPECT_TRUE(isDisabled(*robot, "two", "three", "parent and child"));
  EXPECT_TRUE(isDisabled(*robot, "base", "four", "<exclude>"));
  EXPECT_TRUE(isDisabled(*robot, "base", "three", "contype and conaffinity"));
  EXPECT_TRUE(isDisabled(*robot, "three", "four", "contype and conaffinity"));
  for (const DisabledPair& pair : robot->disabled_pairs) {
    EXPECT_NE(robot->links[static_cast<std::size_t>(pair.link_a)].name + "+" +
                  robot->links[static_cast<std::size_t>(pair.link_b)].name,
              "one+four");
    EXPECT_LT(pair.link_a, pair.link_b);
  }
}

TEST(Mjcf, PairsOfContactCollideInAnyCase) {
  const std::string bodies =
      R"(<body name="a"><joint/><geom name="ga" size="0.1"/>
<body name="b"><joint/><geom name="gb" size="0.1" contype="0" conaffinity="0"/></body></body>)";
  EXPECT_TRUE(load(model(bodies))->links[2].geometries.empty());
  const auto robot = load(model(bodies, "<contact><pair geom1=\"ga\" geom2=\"gb\"/></contact>"));
  EXPECT_EQ(robot->links[2].geometries.size(), 1u);
  EXPECT_TRUE(robot->disabled_pairs.empty());
  EXPECT_TRUE(isEnabled(*robot, "a", "b"));
  EXPECT_EQ(robot->asked_pairs.size(), 1u);
}

TEST(Mjcf, ParentsCollideWhereTheFileSaysSo) {
  const auto robot = load(model(
      R"(<body name="a"><joint/><geom size="0.1"/>
<body name="b"><joint/><geom size="0.1"/></body></body>)",
      "<option><flag filterparent=\"disable\"/></option>"));
  EXPECT_TRUE(isEnabled(*robot, "a", "b"));
}

TEST(Mjcf, GeomsOfSeveralMasksAreAllCheckedAndNamed) {
  const auto robot = load(model(
      R"(<body name="a"><joint/><geom size="0.1" contype="2" conaffinity="2"/><geom size="0.1"/></body>
<body name="b"><joint/><geom size="0.1"/></body>)"));
  EXPECT_TRUE(robot->disabled_pairs.empty());
  ASSERT_EQ(robot->warnings.size(), 1u);
  EXPECT_NE(robot->warnings[0].find("only some geoms of 1 pair of bodies"), std::string::npos);
}

// Meshes and other files.

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nv 0.1 0.1 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 5\nf 1 4 "
    "5\nf 4 3 5\n";

TEST(Mjcf, MeshesCollideAsTheirHulls) {
  const Folder folder;
  folder.write("assets/part.obj", kTetrahedron);
  const std::string file = folder.write(
      "robot.xml",
      "<mujoco><compiler meshdir=\"assets\"/><default><mesh scale=\"2 2 2\"/></default>\n<asset>"
      "<mesh file=\"part.obj\" refpos=\"0 0 1\" refquat=\"1 0 0 1\"/></asset>\n" +
          model("<body name=\"a\"><joint/><geom type=\"mesh\" mesh=\"part\" pos=\"5 0 0\"/></body>")
              .substr(8));
  const auto robot = loadModel(file, "");
  const Geometry& geometry = geometryOf(*robot, "a");
  ASSERT_EQ(geometry.shape.type(), ShapeType::kConvexHull);
  EXPECT_EQ(geometry.shape.hull()->vertices().size(), 4u);
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector3d& v : geometry.shape.hull()->vertices())
    corners.push_back(geometry.X_BG * v);
  // 2 R'(v - p), R a quarter turn about z.
  for (const Eigen::Vector3d& corner : {Eigen::Vector3d(5, 0, -2), Eigen::Vector3d(5, -2, -2),
                                        Eigen::Vector3d(9, 0, -2), Eigen::Vector3d(5, 0, 4)})
    EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& c) {
      return (c - corner).norm() < 1e-14;
    })) << corner.transpose();
  LoadOptions as_written;
  as_written.meshes["a"] = {};
  EXPECT_EQ(geometryOf(*loadModel(file, "", as_written), "a").shape.type(), ShapeType::kMesh);
}

TEST(Mjcf, IncludesStandForTheirContents) {
  const Folder folder;
  folder.write("parts/arm.xml",
               "<mujocoinclude>\n<joint name=\"j\"/>\n<geom size=\"0.1\"/>\n<include "
               "file=\"more.xml\"/></mujocoinclude>");
  folder.write("parts/more.xml", "<mujocoinclude>\n\n<geom size=\"wide\"/></mujocoinclude>");
  const std::string file = folder.write(
      "robot.xml", model("<body name=\"a\">\n<include file=\"parts/arm.xml\"/></body>"));
  expectInputError([&] { loadModel(file, ""); }, folder.path("parts/more.xml"), 3,
                   {"size of <geom>", "\"wide\""});
  folder.write("parts/more.xml", "<mujocoinclude><geom size=\"0.2\"/></mujocoinclude>");
  const auto robot = loadModel(file, "");
  EXPECT_EQ(robot->variables.size(), 1u);
  EXPECT_EQ(robot->links[1].geometries.size(), 2u);
  folder.write("parts/more.xml", "<mujocoinclude>\n<include file=\"robot.xml\"/></mujocoinclude>");
  expectInputError([&] { loadModel(file, ""); }, folder.path("parts/more.xml"), 2,
                   {"includes this file"});
}

TEST(Mjcf, FilesMayBeIncludedAgainButNotInThemselves) {
  const Folder folder;
  folder.write("wheel.xml", "<mujoco><geom size=\"0.1\"/></mujoco>");
  const std::string file = folder.write(
      "robot.xml", model("<body name=\"left\"><include file=\"wheel.xml\"/></body>\n"
                         "<body name=\"right\"><include file=\"./wheel.xml\"/></body>"));
  const auto robot = loadModel(file, "");
  EXPECT_EQ(geometryOf(*robot, "left").shape.radius(), 0.1);
  EXPECT_EQ(geometryOf(*robot, "right").shape.radius(), 0.1);
  const std::string wheel =
      folder.write("wheel.xml", "<mujoco>\n<include file=\"robot.xml\"/></mujoco>");
  expectInputError([&] { loadModel(file, ""); }, wheel, 2,
                   {"\"robot.xml\"", "includes this file", "do not contain themselves"});
}

TEST(Mjcf, OtherOrientationsWinOverAQuat) {
  const auto robot = load(model(
      "<body name=\"a\" childclass=\"c\"><geom class=\"c\" size=\"1 1\" quat=\"1 0 0 1\"/>"
      "<geom class=\"d\" size=\"1 1\" euler=\"90 0 0\"/></body>",
      "<default><geom type=\"cylinder\"/><default class=\"c\"><geom euler=\"0 90 0\"/></default>"
      "<default class=\"d\"><geom quat=\"0 1 0 0\"/></default></default>"));
  // Both lie, along x and along y.
  EXPECT_LE((geometryOf(*robot, "a", 0).X_BG.rotation.col(2) - Eigen::Vector3d::UnitX()).norm(),
            1e-15);
  EXPECT_LE((geometryOf(*robot, "a", 1).X_BG.rotation.col(2) + Eigen::Vector3d::UnitY()).norm(),
            1e-15);
}

TEST(Mjcf, LimitsInAnIncludedFileAreNamedByThatFile) {
  const Folder folder;
  folder.write("part.xml",
               "<mujocoinclude>\n\n<body name=\"b\">\n<joint name=\"k\" type=\"slide\" "
               "range=\"0 0.5\"/><geom size=\"0.1\"/></body></mujocoinclude>");
  const std::string file = folder.write(
      "robot.xml", model("<body name=\"a\"><joint name=\"j\" type=\"slide\" range=\"-1 1\"/></body>"
                         "<include file=\"part.xml\"/>",
                         "<equality><joint joint1=\"k\" joint2=\"j\"/></equality>"));
  const auto robot = loadModel(file, "");
  ASSERT_EQ(robot->variables.size(), 1u);
  EXPECT_EQ(robot->variables[0].upper, 0.5);
  EXPECT_NE(robot->variables[0].narrowed_by.find(folder.path("part.xml") + ":4"), std::string::npos)
      << robot->variables[0].narrowed_by;
}

TEST(Mjcf, UnknownAttributesAreLeftOut) {
  const std::string text = model("<body name=\"a\"><joint/><geom size=\"0.1\"/></body>");
  const auto robot = load("<mujoco><worldbody pos=\"0 0 1\"" + text.substr(19));
  ASSERT_EQ(robot->warnings.size(), 1u);
  EXPECT_NE(robot->warnings[0].find("<worldbody> has the unknown attribute \"pos\""),
            std::string::npos)
      << robot->warnings[0];
}

TEST(Mjcf, WhatPlanningDoesNotUseIsCounted) {
  const auto robot = load(model(
      R"(<light pos="0 0 2"/><body name="a"><joint name="j"/><geom size="0.1"/><site name="s"/><site/>
<geom size="0.1" contype="0" conaffinity="0"/></body>)",
      R"(<actuator><motor joint="j"/></actuator><keyframe><key qpos="0"/></keyframe>)"));
  ASSERT_EQ(robot->warnings.size(), 1u);
  EXPECT_NE(robot->warnings[0].find(
                "robot.xml: planning does not use 1 actuator, 1 key without a name, 1 light, 2 "
                "sites, 1 visual geom"),
            std::string::npos)
      << robot->warnings[0];
}

TEST(Mjcf, WrongKeysAreLeftOut) {
  const auto robot = load(model(R"(<body name="a"><joint name="j"/><geom size="0.1"/></body>)",
                                "<keyframe>\n<key name=\"home\" qpos=\"0 0\"/></keyframe>"));
  ASSERT_EQ(robot->warnings.size(), 1u);
  EXPECT_NE(robot->warnings[0].find("robot.xml:6: key \"home\" is left out: qpos has 2 numbers; 1 "
                                    "would be accepted"),
            std::string::npos)
      << robot->warnings[0];
}

// Messages.

struct BadMjcf {
  const char* name;
  std::string text;
  int line;
  std::initializer_list<std::string> words;
};

void PrintTo(const BadMjcf& bad, std::ostream* stream) { *stream << bad.text; }

class MjcfMessage : public testing::TestWithParam<BadMjcf> {};

TEST_P(MjcfMessage, SaysWhereWhatAndWhatInstead) {
  const Folder folder;
  const std::string file = folder.write("bad.xml", GetParam().text);
  expectInputError([&] { loadModel(file, ""); }, file, GetParam().line, GetParam().words);
  InputErrors errors;
  LoadOptions options;
  options.errors = &errors;
  try {
    loadModel(file, "", options);
    FAIL() << "read in spite of it";
  } catch (const InputError& error) {
    errors.keep(error);  // what ends the reading at once is only thrown
  }
  EXPECT_EQ(errors.list().front().line(), GetParam().line);
}

/// A body (line 3) with `inside` in line 4.
/// MuJoCo's own sizes and poses, of its release 3 compiled to WebAssembly (npm's mujoco-js 0.0.7).
TEST(Mjcf, PrimitivesAreFittedToMeshesAsMuJoCoDoes) {
  struct Case {
    const char *compiler, *mesh, *geom;
    Eigen::Vector3d size, pos;
    Eigen::Vector4d quat;  // w x y z
  };
  const Eigen::Vector3d center(0.07500000298023222, 0.05000000074505806, 0.025000000372529026);
  const Eigen::Vector4d turn(0.22089758010408622, 0.7360409335852054, 0.005524009276587527,
                             0.6398573970133457);
  const Case cases[] = {
      {"",
       "",
       "type=\"box\"",
       {0.025999430195414633, 0.06396526944309404, 0.10479730391039135},
       center,
       turn},
      {"", "", "type=\"capsule\"", {0.044982349819254336, 0.08230612900076419, 0}, center, turn},
      {"", "", "type=\"cylinder\"", {0.044982349819254336, 0.10479730391039135, 0}, center, turn},
      {"", "", "", {0.06492066784963334, 0, 0}, center, turn},
      {"",
       "",
       "type=\"ellipsoid\" pos=\"1 2 3\" euler=\"10 20 30\" fitscale=\"2\"",
       {0.051998860390829266, 0.12793053888618808, 0.2095946078207827},
       {1.0460930163673527, 2.077867112312574, 3.0237096436587954},
       {-0.05813801603914889, 0.8140344269413825, 0.15317303732012696, 0.5572306017111566}},
      {"fitaabb=\"true\"",
       "",
       "type=\"box\"",
       {0.04697410025771179, 0.10684717440561345, 0.1734654655230407},
       {0.13245257634650165, 0.04515150842658293, 0.01049041088351119},
       turn},
      {"fitaabb=\"true\"",
       "",
       "type=\"cylinder\"",
       {0.10684717440561345, 0.1734654655230407, 0},
       {0.13245257634650165, 0.04515150842658293, 0.01049041088351119},
       turn},
      {"",
       "inertia=\"shell\"",
       "type=\"box\"",
       {0.03345330755899482, 0.08077392877009854, 0.13383574168348716},
       {0.08888889265754236, 0.05555555634397679, 0.02222222251393808},
       {0.23453323754007607, 0.7336662772815936, -0.0012241108170968906, 0.6377510922150189}},
      {"",
       "inertia=\"exact\" scale=\"-1 2 3\" refpos=\"0.1 0 0\"",
       "type=\"box\"",
       {0.06230117539914108, 0.11618950356037966, 0.14445955990910042},
       {0.024999997019767774, 0.1000000014901161, 0.07500000111758709},
       {0.6955607099671162, 0.58182260672345, 0.12726069123038009, -0.40184881426120667}},
      // Of a small mesh the axes are off the principal ones.
      {"",
       "scale=\"0.1 0.1 0.1\" refquat=\"1 2 3 4\"",
       "type=\"box\"",
       {0.002604021195242004, 0.0063948756006106606, 0.010479725635266062},
       {-0.0008333334699273109, 0.0016666667163372044, 0.009166666939854622},
       {0.2875805636141903, 0.7839921853548755, 0.3467715993119941, 0.4270867952119751}},
      {"",
       "scale=\"0.01 0.01 0.01\" refquat=\"1 2 3 4\"",
       "type=\"box\"",
       {0.0009376389078042969, 0.00045240100957181384, 0.0007008328633419293},
       {-0.00008333334699273111, 0.00016666667163372047, 0.0009166666939854621},
       {1, 0, 0, 0}}};
  const Folder folder;
  folder.write("tet.obj",
               "v 0 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const Case& c : cases) {
    const std::string text = std::string("<mujoco><compiler ") + c.compiler +
                             "/><asset><mesh name=\"t\" file=\"tet.obj\" " + c.mesh +
                             "/></asset><worldbody><body name=\"a\"><joint/><geom mesh=\"t\" " +
                             c.geom + "/></body></worldbody></mujoco>";
    const auto robot = loadModel(folder.write("robot.xml", text), "");
    const Geometry& geometry = geometryOf(*robot, "a");
    const collision::Shape& shape = geometry.shape;
    const bool is_box = shape.type() == collision::ShapeType::kBox ||
                        shape.type() == collision::ShapeType::kEllipsoid;
    const Eigen::Vector3d size =
        is_box ? shape.halfExtents() : Eigen::Vector3d(shape.radius(), shape.halfLength(), 0);
    EXPECT_LE((size - c.size).norm(), 1e-12) << text << size.transpose();
    EXPECT_LE((geometry.X_BG.translation - c.pos).norm(), 1e-12) << text;
    const Eigen::Quaterniond q(c.quat[0], c.quat[1], c.quat[2], c.quat[3]);
    // A primitive is the same if axes point the other way.
    const Eigen::Matrix3d R = geometry.X_BG.rotation.transpose() * q.toRotationMatrix();
    EXPECT_LE((R.cwiseAbs() - Eigen::Matrix3d::Identity()).norm(), 1e-10) << text << R;
  }
}

std::string body(const std::string& inside, const std::string& rest = "") {
  return model("<body name=\"a\"><joint name=\"j\"/>\n" + inside + "</body>", rest);
}

const BadMjcf kBad[] = {
    {"NoBody", "<mujoco>\n</mujoco>", 1, {"no body", "at least one <body>"}},
    {"Section",
     "<mujoco>\n<worldbdy/>\n</mujoco>",
     2,
     {"<worldbdy>", "did you mean \"worldbody\""}},
    {"Element", body("<goem size=\"1\"/>"), 4, {"<goem>", "did you mean \"geom\"?"}},
    {"Replicate", body("<replicate count=\"3\"/>"), 4, {"<replicate>", "not read"}},
    {"Attribute", body("<geom siez=\"1\"/>"), 4, {"\"siez\"", "size"}},
    {"BodyTwice", body("<body name=\"a\"/>"), 4, {"second body \"a\"", "unique"}},
    {"JointTwice", body("<body><joint name=\"j\"/></body>"), 4, {"second joint \"j\"", "unique"}},
    {"Ball", body("<body><joint type=\"ball\"/></body>"), 4, {"\"ball\"", "hinge, slide and free"}},
    {"JointType", body("<body><joint type=\"hing\"/></body>"), 4, {"\"hing\"", "slide or hinge"}},
    {"FreeInside", body("<body><freejoint/></body>"), 4, {"free joint", "<worldbody>"}},
    {"FreeBeside", body("<freejoint/>"), 4, {"beside others"}},
    {"Axis", body("<body><joint axis=\"0 0 0\"/></body>"), 4, {"axis", "\"0 0 0\"", "zero"}},
    {"Limited",
     body("<body><joint limited=\"true\" range=\"1 0\"/></body>"),
     4,
     {"range", "\"1 0\"", "the lower first"}},
    {"Reversed",
     body("<body><joint range=\"90 -90\"/></body>"),
     4,
     {"range", "\"90 -90\"", "the lower first"}},
    {"ReversedSlide",
     body("<body><joint type=\"slide\" range=\"1 0\"/></body>"),
     4,
     {"range", "\"1 0\"", "the lower first"}},
    {"JointInWorld", model("<joint/>"), 3, {"<joint> in <worldbody>"}},
    {"GeomInInertial",
     body("<inertial>\n<geom size=\"1\"/></inertial>"),
     5,
     {"<geom> in <inertial>"}},
    {"GeomInJoint", body("<joint><geom size=\"1\"/></joint>"), 4, {"<geom> in <joint>", "<body>"}},
    {"GeomInGeom", body("<geom size=\"1\"><geom size=\"3\"/></geom>"), 4, {"<geom> in <geom>"}},
    {"GeomInPlugin",
     body("<plugin>\n<geom size=\"1\"/></plugin>"),
     5,
     {"<geom> in <plugin>", "<worldbody>"}},
    {"BodyInDefault",
     model("", "<default><geom size=\"1\"/>\n<body><geom/></body></default>"),
     6,
     {"<body> in <default> is not read; one in <worldbody>"}},
    {"GeomInAsset", model("", "<asset>\n<geom size=\"1\"/></asset>"), 6, {"<geom> in <asset>"}},
    {"NoSize", body("<geom/>"), 4, {"size", "not given", "1 positive number"}},
    {"Sizes", body("<geom type=\"box\" size=\"1 2\"/>"), 4, {"\"1 2\"", "3 positive numbers"}},
    {"ManySizes", body("<geom size=\"1 2 3 4\"/>"), 4, {"up to 3 numbers"}},
    {"GeomType", body("<geom type=\"cone\" size=\"1\"/>"), 4, {"\"cone\"", "ellipsoid"}},
    {"MovingPlane", body("<geom type=\"plane\" size=\"1 1 1\"/>"), 4, {"plane moves"}},
    {"FromTo",
     body("<geom type=\"sphere\" size=\"1\" fromto=\"0 0 0 1 0 0\"/>"),
     4,
     {"fromto", "sphere"}},
    {"FromToPos",
     body("<geom type=\"capsule\" size=\"1\" pos=\"1 0 0\" fromto=\"0 0 0 1 0 0\"/>"),
     4,
     {"pos or fromto"}},
    {"UnknownMesh", body("<geom type=\"mesh\" mesh=\"m\"/>"), 4, {"\"m\"", "name of a <mesh>"}},
    {"MissingMesh",
     body("<geom type=\"mesh\" mesh=\"m\"/>", "<asset>\n<mesh name=\"m\" file=\"m.stl\"/></asset>"),
     7,
     {"\"m.stl\"", "there is no", "meshdir"}},
    {"Msh",
     body("<geom type=\"mesh\" mesh=\"m\"/>", "<asset>\n<mesh file=\"m.msh\"/></asset>"),
     7,
     {".msh", ".stl and .obj"}},
    {"Orientations",
     body("<geom size=\"1\" quat=\"1 0 0 0\" euler=\"0 0 0\"/>"),
     4,
     {"euler", "quat already", "one orientation"}},
    {"Quaternion", body("<geom size=\"1\" quat=\"0 0 0 0\"/>"), 4, {"quat", "other than zero"}},
    {"Numbers", body("<geom size=\"1\" pos=\"1 2\"/>"), 4, {"pos", "\"1 2\"", "3 numbers"}},
    {"Far", body("<geom size=\"1\" pos=\"1e10 0 0\"/>"), 4, {"pos", "1e9"}},
    {"Mask", body("<geom size=\"1\" contype=\"1.5\"/>"), 4, {"contype", "whole number"}},
    {"Class", body("<geom class=\"x\"/>"), 4, {"class \"x\"", "not defined"}},
    {"ChildClass", body("<body childclass=\"x\"/>"), 4, {"class \"x\"", "not defined"}},
    {"ClassTwice",
     body("", "<default><default class=\"c\"/>\n<default class=\"c\"/></default>"),
     7,
     {"second class \"c\""}},
    {"Coordinate", body("", "<compiler coordinate=\"global\"/>"), 6, {"\"global\"", "\"local\""}},
    {"Angle", body("", "<compiler angle=\"deg\"/>"), 6, {"\"deg\"", "radian or degree"}},
    {"Euler", body("", "<compiler eulerseq=\"xyw\"/>"), 6, {"\"xyw\"", "xyzXYZ"}},
    {"AutoLimits",
     body("<body><joint range=\"0 1\"/></body>", "<compiler autolimits=\"false\"/>"),
     4,
     {"limited", "autolimits"}},
    {"Exclude",
     body("<body name=\"b\"/>", "<contact><exclude body1=\"b\" body2=\"aa\"/></contact>"),
     6,
     {"body \"aa\"", "did you mean"}},
    {"Pair", body("", "<contact><pair geom1=\"g\" geom2=\"g\"/></contact>"), 6, {"geom \"g\""}},
    {"Equality",
     body("", "<equality><joint joint1=\"j\" joint2=\"k\"/></equality>"),
     6,
     {"joint \"k\"", "not defined"}},
    {"Locked",
     body("<body><joint name=\"k\"/></body>",
          "<equality><joint joint1=\"j\"/>\n<joint joint1=\"k\" joint2=\"j\"/></equality>"),
     7,
     {"joint2", "\"j\"", "not locked"}},
    {"EqualityAttribute",
     body("<body><joint name=\"k\"/></body>",
          "<equality><joint joint1=\"k\" joint2=\"j\" polycoeff=\"0 2\"/></equality>"),
     6,
     {"\"polycoeff\"", "did you mean \"polycoef\""}},
    {"KeyAttribute",
     body("", "<keyframe><key name=\"home\" qpo=\"1\"/></keyframe>"),
     6,
     {"\"qpo\"", "did you mean \"qpos\""}},
    {"FlagAttribute",
     body("", "<option><flag filterparents=\"disable\"/></option>"),
     6,
     {"\"filterparents\"", "did you mean \"filterparent\""}},
    {"Include", body("<include file=\"none.xml\"/>"), 4, {"\"none.xml\"", "there is no"}},
    {"HeightField", body("<geom type=\"hfield\" hfield=\"h\"/>"), 4, {"hfield", "not read"}},
    {"Fitted", body("<geom type=\"capsule\" mesh=\"m\"/>"), 4, {"\"m\"", "name of a <mesh>"}},
    {"FittedPlane", body("<geom type=\"plane\" mesh=\"m\"/>"), 4, {"plane moves"}},
    {"FittedFromTo",
     body("<geom type=\"capsule\" mesh=\"m\" fromto=\"0 0 0 1 0 0\"/>"),
     4,
     {"fromto", "beside a mesh"}},
    {"Model", body("", "<asset><model file=\"x.xml\"/></asset>"), 6, {"<model>", "<include>"}},
    {"SecondRoot", body("") + "<mujoco/>", 8, {"second root", "one <mujoco>"}},
};

INSTANTIATE_TEST_SUITE_P(All, MjcfMessage, testing::ValuesIn(kBad),
                         [](const testing::TestParamInfo<BadMjcf>& bad) {
                           return std::string(bad.param.name);
                         });

}  // namespace
}  // namespace leeway::robots
