// Parts of URDFs that planning does not need, or that plain URDF 1.0 does not have.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "leeway/robots/model.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::robots {
namespace {

class LeftOutOfUrdf : public testing::Test {
 protected:
  /// Link "a" is in line 2, and `rest` begins in line 3.
  std::shared_ptr<const Model> load(const std::string& rest, const LoadOptions& options = {}) {
    file_ = folder_.write("r.urdf",
                          "<robot name=\"r\" xmlns:drake=\"http://drake.mit.edu\">\n"
                          "<link name=\"a\"/>\n" +
                              rest + "\n</robot>\n");
    return loadModel(file_, "", options);
  }
  static std::string linkWithShape(const std::string& name) {
    return "<link name=\"" + name +
           "\"><collision><geometry><sphere radius=\"1\"/></geometry></collision></link>";
  }
  /// A revolute joint from "a" to "b" and the link "b".
  static std::string joint(const std::string& inside) {
    return linkWithShape("b") +
           "\n<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child "
           "link=\"b\"/>" +
           inside + "</joint>";
  }
  static std::string limit(const std::string& attributes) {
    return "<limit lower=\"-1\" upper=\"1\" " + attributes + "/>";
  }
  static std::string collision(const std::string& geometry) {
    return "<link name=\"b\"><collision><geometry>" + geometry +
           "</geometry></collision></link>\n<joint name=\"j\" type=\"fixed\"><parent "
           "link=\"a\"/><child link=\"b\"/></joint>";
  }
  /// Expects these warnings, each FILE:LINE: and words.
  void expectWarnings(const Model& model, const std::vector<std::string>& expected) {
    ASSERT_EQ(model.warnings.size(), expected.size()) << testing::PrintToString(model.warnings);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(model.warnings[i].rfind(file_ + expected[i], 0), 0U)
          << model.warnings[i] << " should begin with " << expected[i];
  }
  Folder folder_;
  std::string file_;
};

TEST_F(LeftOutOfUrdf, ExtensionsOfLimitsAndAxes) {
  const auto model = load(
      joint("<axis xyz=\"0 0 1\" rpy=\"0 0 0\"/>\n" +
            limit("effort=\"1\" velocity=\"2\" drake:acceleration=\"5\" command_effort=\"3\"")));
  expectWarnings(*model,
                 {":4: <axis> has the unknown attribute \"rpy\", which is left out",
                  ":5: <limit> has the unknown attribute \"drake:acceleration\", which is left out",
                  ":5: <limit> has the unknown attribute \"command_effort\", which is left out"});
  EXPECT_EQ(model->variables[0].velocity, 2);
  EXPECT_EQ(model->joints[1].axis, Eigen::Vector3d::UnitZ());
}

/// Unread attributes and text that look like poses or limits have a warning.
TEST_F(LeftOutOfUrdf, AttributesAndTextThatNobodyReads) {
  const auto model = load(
      "<link name=\"b\" concave=\"yes\">\n<collision xyz=\"0.5 0 0\" scale=\"2\">\n<origin>0.5 0 "
      "0</origin>\n<geometry size=\"1\"><sphere "
      "radius=\"1\">2</sphere></geometry></collision></link>"
      "\n<joint name=\"j\" type=\"revolute\" axis=\"0 0 1\" lower=\"-1\">\n<parent "
      "link=\"a\"/><child link=\"b\"/>\n<limit lower=\"-1\" upper=\"1\" effort=\"1\" "
      "velocity=\"1\">\n</limit>\n<safety_controller soft_lower=\"-0.5\"/></joint>");
  expectWarnings(
      *model,
      {":3: <link> has the unknown attribute \"concave\", which is left out",
       ":4: <collision> has the unknown attribute \"xyz\", which is left out",
       ":4: <collision> has the unknown attribute \"scale\", which is left out",
       ":5: <origin> holds the text \"0.5 0 0\", which is left out",
       ":6: <geometry> has the unknown attribute \"size\", which is left out",
       ":6: <sphere> holds the text \"2\", which is left out",
       ":7: <joint> has the unknown attribute \"axis\", which is left out",
       ":7: <joint> has the unknown attribute \"lower\", which is left out",
       ":11: <safety_controller> has the unknown attribute \"soft_lower\", which is left out"});
}

/// Regression: a shape in a part that is not read was lost in silence.
TEST_F(LeftOutOfUrdf, ShapesInPartsThatAreNotRead) {
  const std::string shape = "<geometry><sphere radius=\"0.5\"/></geometry>";
  const auto model = load("<link name=\"b\"><visual>" + shape + "\n<collision>" + shape +
                          "</collision></visual>\n<inertial><collision>" + shape +
                          "</collision></inertial><collision>" + shape +
                          "</collision></link>\n<joint name=\"j\" type=\"continuous\"><parent "
                          "link=\"a\"/><child link=\"b\"/></joint>");
  EXPECT_EQ(model->links.back().geometries.size(), 1U);
  expectWarnings(*model, {":5: <collision> in <inertial> is not known and is left out",
                          ":4: <collision> in <visual> is not known and is left out"});
  // Regression: in parts that are known and not read.
  const std::string body = "<collision>" + shape + "</collision>";
  expectWarnings(
      *load("<link name=\"b\"><contact>" + shape + "\n" + body + "</contact><collision>" + shape +
            "<verbose>\n" + body + "</verbose></collision></link>\n<material name=\"m\">" + body +
            "</material>\n<transmission><link name=\"c\">" + body +
            "</link></transmission><unknown>" + body + "</unknown>\n" +
            "<gazebo reference=\"b\"><collision>b_collision</collision><visual>" + shape +
            "</visual></gazebo><joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child "
            "link=\"b\"/><sensor>" +
            body + "</sensor></joint>"),
      {":7: <unknown> in <robot> is not known and is left out",
       ":3: <geometry> in <contact> is left out; one in a <collision> would be read",
       ":4: <collision> in <contact> is left out; one in a <link> would be read",
       ":5: <collision> in <verbose> is left out; one in a <link> would be read",
       ":6: <collision> in <material> is left out; one in a <link> would be read",
       ":7: <collision> in <transmission> is left out; one in a <link> would be read",
       ":8: <collision> in <sensor> is left out; one in a <link> would be read"});
}

/// Elements that planning does not read have these warnings, too; extensions have none.
TEST_F(LeftOutOfUrdf, AttributesOfWhatIsNotRead) {
  file_ = folder_.write("r.urdf", R"(<robot name="r" nmae="s" version="1.0" xmlns:x="y">
<link name="a">
<visual name="v" colour="red">
<origin xyz="0 0 0" quat="1 0 0 0"/>
<geometry><box size="1 1 1" radius="1"/></geometry>
<material name="m"><color rgb="1 0 0"/></material></visual>
<inertial unit="kg">
<mass value="1" values="2"/>
<inertia ixx="1" iyx="0"/></inertial>
<collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/>
<dynamics damping="1" stiffness="2"/>
<limit effort="1" velocity="1"/></joint>
<gazebo reference="a"><visual any="thing"/></gazebo>
</robot>
)");
  const auto model = loadModel(file_, "", {});
  const auto unknown = [](int line, const std::string& element, const std::string& attribute) {
    return ":" + std::to_string(line) + ": <" + element + "> has the unknown attribute \"" +
           attribute + "\", which is left out";
  };
  expectWarnings(*model, {unknown(1, "robot", "nmae"), unknown(7, "inertial", "unit"),
                          unknown(8, "mass", "values"), unknown(9, "inertia", "iyx"),
                          unknown(3, "visual", "colour"), unknown(4, "origin", "quat"),
                          unknown(5, "box", "radius"), unknown(6, "color", "rgb"),
                          unknown(13, "dynamics", "stiffness")});
}

TEST_F(LeftOutOfUrdf, ElementsBesideAShape) {
  const auto model =
      load("<drake:proximity/>\n" +
           collision("<drake:declare_convex/>\n<box size=\"1 2 3\"/><drake:declare_convex/>"));
  expectWarnings(*model, {":3: <drake:proximity> in <robot> is not known and is left out",
                          ":4: <drake:declare_convex> in <geometry> is not known and is left out "
                          "(and in 1 more place)"});
  EXPECT_EQ(model->links[1].geometries.at(0).shape.halfExtents(), Eigen::Vector3d(0.5, 1, 1.5));
}

TEST_F(LeftOutOfUrdf, LimitsThatPlanningDoesNotNeed) {
  EXPECT_EQ(load(joint("\n" + limit("velocity=\"3\"")))->variables[0].velocity, 3);
  expectWarnings(*load(joint("\n" + limit("velocity=\"3\""))),
                 {":5: <limit> has no effort, which is not used"});
  expectWarnings(*load(joint("\n" + limit("velocity=\"3\" effort=\"much\""))),
                 {":5: effort of <limit> holds \"much\""});
  for (const char* none : {"-1", "0", "1e17", "inf", "nan", "1e999"}) {
    const auto model =
        load(joint("\n" + limit("effort=\"1\" velocity=\"" + std::string(none) + "\"")));
    expectWarnings(*model, {":5: the velocity limit \"" + std::string(none) +
                            "\" of joint \"j\" is taken for none: it may move at 1 rad/s"});
    EXPECT_TRUE(std::isinf(model->variables[0].velocity));
  }
  EXPECT_TRUE(std::isinf(load(joint("\n" + limit("effort=\"1\"")))->variables[0].velocity));
  expectWarnings(*load(joint("\n" + limit("effort=\"1\""))),
                 {":5: joint \"j\" has no velocity limit: it may move at 1 rad/s"});
  expectInputError([&] { load(joint("\n" + limit("effort=\"1\" velocity=\"fast\""))); }, file_, 5,
                   {"velocity of <limit> holds \"fast\""});
}

TEST_F(LeftOutOfUrdf, NamesThatAreNotNeeded) {
  file_ = folder_.write("arm6.urdf", "<robot>\n<link name=\"a\"/></robot>");
  const auto nameless = loadModel(file_, "");
  EXPECT_EQ(nameless->name, "arm6");
  expectWarnings(*nameless, {":1: <robot> has no name; \"arm6\" is taken"});
  const auto world = load(
      "<joint name=\"w\" type=\"fixed\">\n<parent link=\"world\"/><child link=\"a\"/></joint>");
  expectWarnings(*world, {":4: the parent link \"world\" is not defined; it is taken as a link"});
  ASSERT_EQ(world->links.size(), 2U);
  EXPECT_EQ(world->links[0].name, "world");
  // Only a root.
  EXPECT_THROW(load("<joint name=\"w\" type=\"fixed\"><parent link=\"a\"/><child "
                    "link=\"world\"/></joint>"),
               InputError);
}

// Errors that do not end the reading, for callers that gather errors.
TEST_F(LeftOutOfUrdf, IsAnErrorWhereErrorsAreGathered) {
  InputErrors errors;
  LoadOptions options;
  options.errors = &errors;
  const auto model =
      load(joint(limit("effort=\"1\" velocity=\"1\" drake:acceleration=\"5\"")), options);
  ASSERT_NE(model, nullptr);
  EXPECT_TRUE(model->warnings.empty());
  ASSERT_EQ(errors.list().size(), 1U);
  EXPECT_EQ(errors.list()[0].line(), 4);
  EXPECT_EQ(errors.count(), 0U);
}

TEST_F(LeftOutOfUrdf, CapsulesAreRead) {
  const auto model = load(collision("<capsule radius=\"0.1\" length=\"0.6\"/>"));
  expectWarnings(*model, {});
  const collision::Shape& shape = model->links[1].geometries.at(0).shape;
  EXPECT_EQ(shape.type(), collision::ShapeType::kCapsule);
  EXPECT_EQ(shape.radius(), 0.1);
  EXPECT_EQ(shape.halfLength(), 0.3);
  expectInputError([&] { load(collision("\n<capsule radius=\"0.1\"/>")); }, file_, 4,
                   {"<capsule> has no length"});
  EXPECT_NO_THROW(loadModel(
      folder_.write("v.urdf", "<robot name=\"r\" version=\"1.2\"><link name=\"a\"/></robot>"), ""));
}

/// Quaternions of URDF 1.1, of any length; roll and yaw may be about one axis.
TEST_F(LeftOutOfUrdf, QuaternionsAreRead) {
  for (const Eigen::Vector4d& q :
       {Eigen::Vector4d(0.1, -0.4, 0.7, 0.3), Eigen::Vector4d(0, 0, 0, -2),
        Eigen::Vector4d(0.5, 0.5, 0.5, -0.5), Eigen::Vector4d(0.3, 0.6, -0.3, 0.6),
        Eigen::Vector4d(0.3, 0.6, -0.3, 0.6 + 1e-9), Eigen::Vector4d(1e-9, 0.3, -0.3, 0.3)}) {
    std::ostringstream text;
    text.precision(17);
    text << "<origin quat_xyzw=\"" << q.transpose() << "\"/>";
    const auto model = loadModel(
        folder_.write("q.urdf",
                      "<robot name=\"r\" version=\"1.1\"><link name=\"a\"/><link name=\"b\">"
                      "<collision>" +
                          text.str() +
                          "<geometry><sphere radius=\"1\"/></geometry>"
                          "</collision></link><joint name=\"j\" type=\"fixed\"><parent link=\"a\"/>"
                          "<child link=\"b\"/>" +
                          text.str() + "</joint></robot>"),
        "");
    expectWarnings(*model, {});
    const Eigen::Matrix3d expected =
        Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
    EXPECT_LT((model->joints[1].X_PJ.rotation - expected).norm(), 1e-14) << text.str();
    EXPECT_LT((model->links[1].geometries.at(0).X_BG.rotation - expected).norm(), 1e-14);
  }
}

TEST_F(LeftOutOfUrdf, ShapesOfDrakeAreRead) {
  const auto shapeOf = [&](const std::string& geometry) {
    return load(collision(geometry))->links[1].geometries.at(0).shape;
  };
  const collision::Shape capsule = shapeOf("<drake:capsule radius=\"0.1\" length=\"0.6\"/>");
  EXPECT_EQ(capsule.type(), collision::ShapeType::kCapsule);
  EXPECT_EQ(capsule.halfLength(), 0.3);
  const collision::Shape ellipsoid =
      shapeOf("<drake:ellipsoid a=\"0.1\" b=\"0.2\" c=\"0.3\"/><drake:declare_convex/>");
  EXPECT_EQ(ellipsoid.type(), collision::ShapeType::kEllipsoid);
  EXPECT_EQ(ellipsoid.halfExtents(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(shapeOf("<drake:capsule radius=\"1\" length=\"1\"/><sphere radius=\"2\"/>").radius(), 2)
      << "plain URDF comes first";
  expectInputError([&] { load(collision("\n<drake:ellipsoid a=\"1\" b=\"1\"/>")); }, file_, 4,
                   {"<drake:ellipsoid> has no c"});
  const std::string two = "\n<drake:capsule radius=\"1\" length=\"1\"/>";
  expectInputError([&] { load(collision(two + two)); }, file_, 5, {"a second shape"});
}

/// As SDF has them, an element would be lost in place of an attribute.
TEST_F(LeftOutOfUrdf, ElementsInElementsThatHaveAttributesAlone) {
  expectWarnings(*load(collision("\n<sphere radius=\"1\"><drake:proximity/><colour/></sphere>")),
                 {":4: <drake:proximity> in <sphere> is not known and is left out",
                  ":4: <colour> in <sphere> is not known and is left out"});
  const std::pair<std::string, std::string> wrong[] = {
      {collision("<mesh filename=\"m.stl\">\n<scale>1 1 1</scale></mesh>"), "scale"},
      {collision("<sphere radius=\"1\">\n<radius>2</radius></sphere>"), "radius"},
      {linkWithShape("b") + "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child "
                            "link=\"b\"/><origin>\n<xyz>1 0 0</xyz></origin></joint>",
       "xyz"}};
  for (const auto& [text, name] : wrong)
    expectInputError([&, &given = text] { load(given); }, file_, 4,
                     {"<" + name + "> in <", "the attribute " + name + "=\"...\""});
}

TEST_F(LeftOutOfUrdf, LimitsOfJointsWithoutEnds) {
  const auto limited = [&](const std::string& type, const std::string& range) {
    return load(linkWithShape("b") + "\n<joint name=\"j\" type=\"" + type +
                "\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/>\n<limit " + range +
                " effort=\"1\" velocity=\"1\"/></joint>");
  };
  for (const char* type : {"continuous", "planar", "floating"})
    expectWarnings(*limited(type, "lower=\"-1\" upper=\"1\""),
                   {":5: lower and upper limits are not used of joints that are not revolute or "
                    "prismatic: \"j\""});
  for (const char* none : {"", "lower=\"0\" upper=\"0\"", "lower=\"-3.1415\" upper=\"3.1415\""})
    expectWarnings(*limited("continuous", none), {});
}

/// As URDF 1.2 has them. The lesser of acceleration and deceleration counts, also for mimics.
TEST_F(LeftOutOfUrdf, AccelerationsAndJerksAreLimits) {
  const std::string limits = "effort=\"1\" velocity=\"1\" acceleration=\"4\" deceleration=\"3\" ";
  const auto model = load(joint(limit(limits + "jerk=\"20\"")));
  expectWarnings(*model, {});
  EXPECT_EQ(model->variables[0].acceleration, 3);
  EXPECT_EQ(model->variables[0].jerk, 20);
  const auto followed = load(joint(limit(limits)) +
                             "<link name=\"c\"/><joint name=\"m\" type=\"revolute\"><parent "
                             "link=\"b\"/><child link=\"c\"/><mimic joint=\"j\" multiplier=\"-2\"/>"
                             "<limit lower=\"-9\" upper=\"9\" effort=\"1\" velocity=\"9\" "
                             "acceleration=\"2\" jerk=\"8\"/></joint>");
  EXPECT_EQ(followed->variables[0].acceleration, 1);
  EXPECT_EQ(followed->variables[0].jerk, 4);
  expectWarnings(*load(joint("\n" + limit("effort=\"1\" velocity=\"1\" jerk=\"0\""))),
                 {":5: the jerk limit \"0\" of joint \"j\" is taken for none"});
  expectInputError([&] { load(joint("\n" + limit("effort=\"1\" velocity=\"1\" jerk=\"low\""))); },
                   file_, 5, {"jerk of <limit> holds \"low\""});
}

/// A prismatic joint without <limit> has no limits, as in SDF; urdfdom takes it, too.
TEST_F(LeftOutOfUrdf, APrismaticJointWithoutLimitIsUnlimited) {
  std::string slider = joint("\n<axis xyz=\"0 0 1\"/>");
  slider.replace(slider.find("revolute"), 8, "prismatic");
  const auto model = load(slider);
  expectWarnings(*model, {":4: joint \"j\" has no <limit>: it needs bounds to be planned"});
  EXPECT_TRUE(std::isinf(model->variables[0].lower) && std::isinf(model->variables[0].upper));
  EXPECT_LT(model->variables[0].lower, model->variables[0].upper);
}

/// Published grippers mimic joints that do not exist. The message does not suggest the joint
/// itself.
TEST_F(LeftOutOfUrdf, AMimicOfAnUnknownJointMovesOnItsOwn) {
  const auto model =
      load(joint("\n<mimic joint=\"k\" multiplier=\"2\"/>" + limit("effort=\"1\" velocity=\"1\"")));
  expectWarnings(
      *model, {":5: joint \"j\" mimics \"k\", which is not defined: it is an independent joint"});
  ASSERT_EQ(model->variables.size(), 1U);
  EXPECT_EQ(model->joints[1].mimic, -1);
  EXPECT_EQ(model->variables[0].upper, 1);
}

TEST_F(LeftOutOfUrdf, TabsAndNewlinesAreWhiteSpace) {
  testing::internal::CaptureStderr();
  const auto model =
      load(joint("<origin xyz=\"1\t2\n 3\" rpy=\"\t0 0\r\n0 \"/><axis xyz=\"0\t0 1\"/>"
                 "<limit lower=\"\t-1\" upper=\"1\n\" effort=\"1\" velocity=\" 1\"/>"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  expectWarnings(*model, {});
  EXPECT_EQ(model->joints[1].X_PJ.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(model->variables[0].lower, -1);
  expectInputError([&] { load(collision("\n<box size=\"1\t2\"/>")); }, file_, 4,
                   {"2 numbers; three would be accepted"});
}

// urdfdom writes its reasons to stderr; they belong in the message.
TEST_F(LeftOutOfUrdf, WhatUrdfdomSaysIsInTheMessage) {
  testing::internal::CaptureStderr();
  file_ = folder_.write("v.urdf", "<robot name=\"r\" version=\"2.0\"><link name=\"a\"/></robot>");
  expectInputError([&] { loadModel(file_, ""); }, file_, 0,
                   {"urdfdom refuses this file: ", "version", "plain URDF 1.0"});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(LeftOutOfUrdf, VisualShapesStandInWhereAskedFor) {
  const std::string shapes =
      "<link name=\"b\"><visual><origin xyz=\"0 0 1\"/><geometry><box size=\"1 1 1\"/></geometry>"
      "</visual><visual><geometry><capsule radius=\"1\" length=\"2\"/></geometry></visual></link>\n"
      "<link name=\"c\"><visual><geometry><box size=\"1 1 1\"/></geometry></visual>"
      "<collision><geometry><sphere radius=\"1\"/></geometry></collision></link>\n"
      "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>"
      "<joint name=\"k\" type=\"fixed\"><parent link=\"a\"/><child link=\"c\"/></joint>";
  const auto plain = load(shapes);
  EXPECT_TRUE(plain->links[1].geometries.empty());
  LoadOptions options;
  options.visual_as_collision = true;
  const auto model = load(shapes, options);
  expectWarnings(*model,
                 {":3: the <visual> shapes of links without <collision> stand in for it: \"b\""});
  const auto& b = model->links[1].geometries;
  ASSERT_EQ(b.size(), 2U);
  EXPECT_EQ(b[0].shape.type(), collision::ShapeType::kBox);
  EXPECT_EQ(b[0].X_BG.translation, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(b[1].shape.type(), collision::ShapeType::kCapsule);
  ASSERT_EQ(model->links[2].geometries.size(), 1U);
  EXPECT_EQ(model->links[2].geometries[0].shape.type(), collision::ShapeType::kSphere);
}

TEST_F(LeftOutOfUrdf, KinematicsNeedNoMeshes) {
  const std::string text =
      "<link name=\"b\"><collision><geometry>\n<mesh filename=\"gone.stl\"/></geometry></collision>"
      "<collision><geometry><sphere radius=\"1\"/></geometry></collision></link>"
      "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>";
  EXPECT_THROW(load(text), InputError);
  LoadOptions options;
  options.kinematics_only = true;
  const auto model = load(text, options);
  EXPECT_TRUE(model->lacks_meshes);
  EXPECT_EQ(model->links[1].geometries.size(), 1U);
  expectInputError([&] { model->expectMeshes(); }, file_, 0, {"without its meshes"});
  const auto whole = load(collision("<sphere radius=\"1\"/>"), options);
  EXPECT_FALSE(whole->lacks_meshes);
  EXPECT_NO_THROW(whole->expectMeshes());
}

// Limits.

TEST_F(LeftOutOfUrdf, AJointThatCannotMoveIsAWarning) {
  expectWarnings(*load(joint("\n<limit effort=\"1\" velocity=\"1\"/>")),
                 {":5: joint \"j\" cannot move: its lower and upper limits are not given"});
  expectWarnings(*load(joint("\n<limit lower=\"0.5\" upper=\"0.5\" effort=\"1\" velocity=\"1\"/>")),
                 {":5: joint \"j\" cannot move: its lower and upper limits are equal"});
  expectWarnings(*load(joint("\n<limit upper=\"0.5\" effort=\"1\" velocity=\"1\"/>")), {});
}

/// MoveIt always takes z.
TEST_F(LeftOutOfUrdf, APlaneThatIsNotNormalToZIsAWarning) {
  const auto planar = [](std::string text) {
    return text.replace(text.find("revolute"), 8, "planar");
  };
  expectWarnings(*load(planar(joint("<axis xyz=\"0 0 2\"/>"))), {});
  expectWarnings(*load(planar(joint("<axis xyz=\"1 0 0\"/>"))),
                 {":4: planar joint \"j\" moves in the plane normal to \"1 0 0\""});
}

TEST_F(LeftOutOfUrdf, SoftLimitsAreNamed) {
  const auto limited = [&](const std::string& soft) {
    return load(joint(limit("effort=\"1\" velocity=\"1\"") + "\n<safety_controller " + soft +
                      " k_velocity=\"10\"/>"));
  };
  for (const char* narrow :
       {"soft_lower_limit=\"-0.5\" soft_upper_limit=\"0.4\"", "soft_upper_limit=\"0.4\"",
        "soft_lower_limit=\"-1\"", "soft_lower_limit=\"0\" soft_upper_limit=\"0\"",
        "soft_lower_limit=\"2\" soft_upper_limit=\"3\""}) {
    const auto model = limited(narrow);
    EXPECT_EQ(model->variables[0].lower, -1);
    EXPECT_EQ(model->variables[0].upper, 1);
    expectWarnings(*model,
                   {":5: soft limits are not used, joints move within their <limit>: \"j\""});
  }
  for (const char* wide : {"", "soft_lower_limit=\"-1\" soft_upper_limit=\"1\"",
                           "soft_lower_limit=\"-9\" soft_upper_limit=\"9\""})
    expectWarnings(*limited(wide), {});
  expectWarnings(*limited("soft_lower_limit=\"low\""),
                 {":5: soft_lower_limit of <safety_controller> holds \"low\""});
  // One warning for all of them.
  expectWarnings(
      *load(linkWithShape("b") +
            "\n<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/>\n"
            "<safety_controller soft_lower_limit=\"-1\" soft_upper_limit=\"1\"/></joint>\n"
            "<link name=\"c\"/><joint name=\"k\" type=\"continuous\"><parent link=\"b\"/><child "
            "link=\"c\"/><safety_controller soft_upper_limit=\"1\"/></joint>"),
      {":5: soft limits are not used, joints move within their <limit>: \"j\", \"k\""});
}

TEST_F(LeftOutOfUrdf, AMimicsOwnLimitsNarrowItsMaster) {
  const auto model = [&](const std::string& master, const std::string& own,
                         const std::string& mimic) {
    return load(linkWithShape("b") + "<link name=\"c\"/>\n" + master +
                "<parent link=\"a\"/><child link=\"b\"/><limit lower=\"-0.2\" upper=\"0.8\" "
                "effort=\"1\" velocity=\"1\"/></joint>\n<joint name=\"f\" type=\"revolute\">"
                "<parent link=\"a\"/><child link=\"c\"/>\n<limit " +
                own + " effort=\"1\" velocity=\"1\"/><mimic joint=\"m\" " + mimic + "/></joint>");
  };
  const std::string turns = "<joint name=\"m\" type=\"revolute\">";
  const auto range = [&](const std::string& own, const std::string& mimic) {
    const Variable v = model(turns, own, mimic)->variables[0];
    return std::pair(v.lower, v.upper);
  };
  using Range = std::pair<double, double>;
  EXPECT_EQ(range("lower=\"0\" upper=\"0.4\"", ""), Range(0, 0.4));
  EXPECT_EQ(range("lower=\"-1\" upper=\"0.4\"", "multiplier=\"2\""), Range(-0.2, 0.2));
  EXPECT_EQ(range("lower=\"-0.4\" upper=\"1\"", "multiplier=\"-2\""), Range(-0.2, 0.2));
  EXPECT_EQ(range("lower=\"0.5\" upper=\"2\"", "offset=\"0.5\""), Range(0, 0.8));
  // The same up to rounding.
  EXPECT_EQ(range("lower=\"-0.22\" upper=\"0.88\"", "multiplier=\"1.1\""), Range(-0.2, 0.8));
  // Limits that are not given, or belong to a joint that does not move, change nothing.
  EXPECT_EQ(range("", ""), Range(-0.2, 0.8));
  EXPECT_EQ(range("lower=\"0\" upper=\"0.4\"", "multiplier=\"0\""), Range(-0.2, 0.8));
  const auto narrowed = model(turns, "lower=\"0\" upper=\"0.4\"", "");
  EXPECT_EQ(narrowed->variables[0].narrowed_by,
            "the limits of joint \"f\", which mimics \"m\" (" + file_ + ":6)");
  expectWarnings(*narrowed, {});
  // Copied from the master in spite of a multiplier of another sign.
  const auto copied = model(turns, "lower=\"0.2\" upper=\"0.8\"", "multiplier=\"-1\"");
  EXPECT_EQ(copied->variables[0].upper, 0.8);
  expectWarnings(*copied, {":6: the limits of joint \"f\", which mimics \"m\", are left out: they "
                           "leave it no range"});
  // Regression: a range of one position was ignored in silence.
  for (const char* own : {"lower=\"0.1\" upper=\"0.1\"", "lower=\"0\" upper=\"0\""}) {
    EXPECT_EQ(range(own, ""), Range(-0.2, 0.8));
    expectWarnings(*model(turns, own, ""),
                   {":6: the limits of joint \"f\", which mimics \"m\", are "
                    "left out: they leave it no range"});
  }
  expectWarnings(*model(turns, "", ""), {});
  expectWarnings(
      *model("<joint name=\"m\" type=\"continuous\">", "lower=\"0\" upper=\"0.4\"", ""),
      {":4: lower and upper limits are not used of joints that are not revolute or prismatic: "
       "\"m\"",
       ":6: the limits of joint \"f\", which mimics \"m\", are left out: that joint has none"});
}

}  // namespace
}  // namespace leeway::robots
