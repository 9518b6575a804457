#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/random_model.h"

namespace leeway::robots {
namespace {

using collision::ShapeType;
using testing::Random;

/// An SDF whose model holds `inside`, which begins in line 3.
std::string sdf(const std::string& inside, const std::string& version = "1.9") {
  return "<sdf version=\"" + version + "\">\n<model name=\"robot\">\n" + inside +
         "\n</model>\n</sdf>\n";
}

/// A joint of the links "a" and "b".
std::string joint(const std::string& inside, const std::string& type = "revolute") {
  return "<joint name=\"j\" type=\"" + type + "\"><parent>a</parent><child>b</child>" + inside +
         "</joint>";
}

std::shared_ptr<const Model> load(const std::string& text) {
  const Folder folder;
  return loadModel(folder.write("robot.sdf", text), "");
}

std::vector<Pose> posesOf(const Model& robot, const std::vector<double>& q) {
  std::vector<Pose> X_WL(robot.links.size());
  forwardKinematics(robot, q, X_WL);
  return X_WL;
}

Pose poseOf(const Model& robot, const std::vector<double>& q, const std::string& link) {
  return posesOf(robot, q).at(static_cast<std::size_t>(robot.findLink(link)));
}

const Geometry& geometryOf(const Model& robot, const std::string& link, std::size_t index = 0) {
  return robot.links.at(static_cast<std::size_t>(robot.findLink(link))).geometries.at(index);
}

const Variable& variableOf(const Model& robot, const std::string& name) {
  return robot.variables.at(static_cast<std::size_t>(robot.findVariable(name)));
}

void expectAt(const Pose& X, const Eigen::Vector3d& p, const Eigen::Matrix3d& R) {
  EXPECT_LE((X.translation - p).norm(), 1e-14) << X.translation.transpose();
  EXPECT_LE((X.rotation - R).norm(), 1e-14) << X.rotation;
}

Eigen::Matrix3d aboutZ(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

constexpr double kQuarter = std::numbers::pi / 2;

// Poses.

TEST(Sdf, PosesAreRelativeToTheFramesThatTheyName) {
  // Half turns and quarter turns about z, computed by hand.
  const auto robot = load(sdf(R"(
    <frame name="f"><pose degrees="true">1 0 0 0 0 90</pose></frame>
    <link name="a"/>
    <link name="b"><pose relative_to="f">2 0 0 0 0 0</pose>
      <collision name="c"><pose relative_to="f">0 0 1 0 0 0</pose>
        <geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
    <frame name="g" attached_to="b"><pose rotation_format="quat_xyzw">0 0 3 0 0 1 0</pose></frame>
    <link name="c"><pose relative_to="g">1 0 0 0 0 0</pose></link>
    <joint name="j" type="prismatic"><parent>a</parent><child>b</child>
      <axis><xyz expressed_in="f">1 0 0</xyz><limit><lower>0</lower><upper>1</upper></limit></axis></joint>
    <joint name="k" type="revolute"><pose relative_to="a">1 4 0 0 0 0</pose>
      <parent>g</parent><child>c</child><axis><xyz expressed_in="a">0 0 1</xyz></axis></joint>)"));
  EXPECT_EQ(robot->links[0].name, "a");
  ASSERT_EQ(robot->variables.size(), 2u);
  expectAt(poseOf(*robot, {0, 0}, "b"), {1, 2, 0}, aboutZ(kQuarter));
  expectAt(poseOf(*robot, {0, 0}, "c"), {1, 1, 3}, aboutZ(3 * kQuarter));
  expectAt(geometryOf(*robot, "b").X_BG, {-2, 0, 1}, Eigen::Matrix3d::Identity());
  // The axis of j is y of the world. That of k goes through (1, 4) and moves along with b.
  expectAt(poseOf(*robot, {0.5, 0}, "b"), {1, 2.5, 0}, aboutZ(kQuarter));
  expectAt(poseOf(*robot, {0, kQuarter}, "c"), {4, 4, 3}, aboutZ(0));
  expectAt(poseOf(*robot, {1, kQuarter}, "c"), {4, 5, 3}, aboutZ(0));
  EXPECT_EQ(robot->findLink("c/k"),
            robot->joints[static_cast<std::size_t>(robot->findLink("c"))].parent_link);
}

TEST(Sdf, JointPosesAreInTheChildUnlessTheySayOtherwise) {
  const auto robot = load(
      sdf("<link name=\"a\"/><link name=\"b\"><pose>1 0 0 0 0 1.5707963267948966</pose></link>" +
          joint("<pose>0 1 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis>")));
  // The anchor is at the world's origin.
  expectAt(poseOf(*robot, {0}, "b"), {1, 0, 0}, aboutZ(kQuarter));
  expectAt(poseOf(*robot, {kQuarter}, "b"), {0, 1, 0}, aboutZ(2 * kQuarter));
}

TEST(Sdf, AxesAreInTheFrameOfTheirVersion) {
  const std::string links =
      "<link name=\"a\"/><link name=\"b\"><pose>0 0 0 0 0 1.5707963267948966</pose></link>";
  const auto moved = [&](const std::string& version, const std::string& axis) {
    const auto robot = load(sdf(links + joint("<axis>" + axis + "</axis>", "prismatic"), version));
    return poseOf(*robot, {1}, "b").translation;
  };
  const std::string x = "<xyz>1 0 0</xyz>",
                    flag = "<use_parent_model_frame>1</use_parent_model_frame>";
  const Eigen::Vector3d model(1, 0, 0), own(0, 1, 0);
  EXPECT_LE((moved("1.4", x) - model).norm(), 1e-14);
  EXPECT_LE((moved("1.5", x) - own).norm(), 1e-14);
  EXPECT_LE((moved("1.6", x + flag) - model).norm(), 1e-14);
  EXPECT_LE((moved("1.7", x) - own).norm(), 1e-14);
  EXPECT_LE((moved("1.7", "<xyz expressed_in=\"__model__\">1 0 0</xyz>") - model).norm(), 1e-14);
}

/// Their frames have that name up to SDF 1.6.
TEST(Sdf, PosesOfOldFilesNameTheirFrame) {
  const std::string links =
      "<link name=\"a\"><pose>1 0 0 0 0 0</pose></link>"
      "<link name=\"b\"><pose frame=\"a\">0 1 0 0 0 0</pose></link>" +
      joint("", "fixed");
  expectAt(poseOf(*load(sdf(links, "1.6")), {}, "b"), {1, 1, 0}, aboutZ(0));
  expectAt(poseOf(*load(sdf(links, "1.7")), {}, "b"), {0, 1, 0}, aboutZ(0));
}

/// Each placement needs those of the models inside: once, or 2^40 times.
TEST(Sdf, PlacementsOfModelsInModelsAreComputedOnce) {
  std::string text = "<link name=\"l\"><pose>1 0 0 0 0 0</pose></link>", frame = "l";
  for (int depth = 0; depth < 40; ++depth) {
    text = "<model name=\"m\" placement_frame=\"" + frame + "\">" + text + "</model>";
    frame = "m::" + frame;
  }
  const auto robot = load("<sdf version=\"1.9\"><model name=\"r\" placement_frame=\"" + frame +
                          "\"><pose>0 2 0 0 0 0</pose>" + text + "</model></sdf>");
  expectAt(poseOf(*robot, {}, frame), {0, 2, 0}, aboutZ(0));
}

TEST(Sdf, RobotsStandWhereTheirModelStands) {
  const auto robot = load(
      "<sdf version=\"1.7\"><world name=\"w\"><light name=\"sun\"/><model name=\"m\"><pose>1 2 3 0 "
      "0 0</pose>"
      "<link name=\"a\"><pose>0 0 1 0 0 0</pose></link></model></world></sdf>");
  EXPECT_EQ(robot->name, "m");
  EXPECT_EQ(robot->links[0].name, "world");
  expectAt(poseOf(*robot, {}, "a"), {1, 2, 4}, Eigen::Matrix3d::Identity());
}

TEST(Sdf, OldFilesHaveAnotherRootAndFreerNames) {
  // A joint may have the name of a link, before it or after it, or "world".
  const auto robot = load(
      "<gazebo version=\"1.2\"><model name=\"m\"><link name=\"a\"/>"
      "<joint name=\"b\" type=\"prismatic\"><parent>a</parent><child>b</child><axis><xyz>1 0 "
      "0</xyz></axis></joint>"
      "<link name=\"b\"><pose>0 1 0 0 0 0</pose></link><link name=\"c\"><pose>0 2 0 0 0 "
      "0</pose></link>"
      "<link name=\"world_2\"/><joint name=\"c\" "
      "type=\"revolute\"><parent>b</parent><child>c</child>"
      "<axis><xyz>0 0 1</xyz></axis></joint>"
      "<joint name=\"world\" "
      "type=\"fixed\"><parent>a</parent><child>world_2</child></joint></model></gazebo>");
  expectAt(poseOf(*robot, {3, kQuarter}, "c"), {3, 2, 0}, aboutZ(kQuarter));
}

TEST(Sdf, WorldIsALinkWhereSomethingIsJoinedToIt) {
  const auto robot =
      load(sdf("<link name=\"b\"/><joint name=\"j\" type=\"continuous\"><parent>world</parent>"
               "<child>b</child><axis><xyz>0 0 1</xyz></axis></joint>"));
  EXPECT_EQ(robot->links[0].name, "world");
  EXPECT_EQ(robot->joints[1].type, JointType::kContinuous);
}

TEST(Sdf, TwoParentsAreToldByTheNamesOfTheFile) {
  const std::string two =
      "<link name=\"a\"/><link name=\"b\"><pose>1 0 0 0 0 0</pose></link><link name=\"c\"/>"
      "<joint name=\"ab\" type=\"revolute\"><pose>0 1 0 0 0 0</pose><parent>a</parent>"
      "<child>b</child><axis><xyz>0 0 1</xyz></axis></joint>"
      "<joint name=\"cb\" type=\"revolute\"><pose>0 1 0 0 0 0</pose><parent>c</parent>"
      "<child>b</child><axis><xyz>0 0 1</xyz></axis></joint>";
  try {
    load(sdf(two));
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("link \"b\" has two parents, through joint \"ab\" ("), std::string::npos)
        << what;
    EXPECT_NE(what.find(") and joint \"cb\""), std::string::npos) << what;
  }
}

TEST(Sdf, StaticModelsStandStill) {
  const auto robot = load(sdf(
      "<static>true</static><link name=\"a\"/><link name=\"b\"><pose>1 0 0 0 0 0</pose></link>" +
      joint("<axis><xyz>0 0 1</xyz></axis>")));
  EXPECT_TRUE(robot->variables.empty());
  EXPECT_EQ(robot->links.size(), 3u);
  expectAt(poseOf(*robot, {}, "b"), {1, 0, 0}, Eigen::Matrix3d::Identity());
  ASSERT_FALSE(robot->warnings.empty());
  EXPECT_NE(robot->warnings[0].find("1 joint moves links of a model with <static>"),
            std::string::npos)
      << robot->warnings[0];
}

// Shapes and joints.

TEST(Sdf, ShapesAreThoseThatCollide) {
  const auto shape = [](const std::string& text) {
    return "<collision name=\"c\"><geometry>" + text + "</geometry></collision>";
  };
  const auto robot = load(sdf("<link name=\"a\">" + shape("<box><size>1 2 3</size></box>") +
                              shape("<sphere><radius>0.5</radius></sphere>") +
                              shape("<cylinder><radius>0.5</radius><length>2</length></cylinder>") +
                              shape("<capsule><radius>0.5</radius><length>2</length></capsule>") +
                              shape("<ellipsoid><radii>1 2 3</radii></ellipsoid>") +
                              shape("<plane><normal>1 0 0</normal><size>1 1</size></plane>") +
                              shape("<empty/>") + "<visual name=\"v\"/></link>"));
  const std::vector<Geometry>& all = robot->links[0].geometries;
  ASSERT_EQ(all.size(), 6u);
  EXPECT_EQ(all[0].shape.halfExtents(), Eigen::Vector3d(0.5, 1, 1.5));
  EXPECT_EQ(all[1].shape.radius(), 0.5);
  EXPECT_EQ(all[2].shape.type(), ShapeType::kCylinder);
  EXPECT_EQ(all[2].shape.halfLength(), 1);
  EXPECT_EQ(all[3].shape.type(), ShapeType::kCapsule);
  EXPECT_EQ(all[4].shape.halfExtents(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(all[5].shape.type(), ShapeType::kHalfSpace);
  EXPECT_LE((all[5].X_BG.rotation.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-15);
}

TEST(Sdf, LimitsAreThoseOfTheFile) {
  const std::string links = "<link name=\"a\"/><link name=\"b\"/>";
  const auto of = [&](const std::string& limit, const std::string& type = "revolute") {
    return load(sdf(links + joint("<axis><xyz>0 0 1</xyz>" + limit + "</axis>", type)));
  };
  const auto narrow = of("<limit><lower>-1</lower><upper>2</upper><velocity>3</velocity></limit>");
  EXPECT_EQ(narrow->joints[1].type, JointType::kRevolute);
  EXPECT_EQ(variableOf(*narrow, "j").lower, -1);
  EXPECT_EQ(variableOf(*narrow, "j").upper, 2);
  EXPECT_EQ(variableOf(*narrow, "j").velocity, 3);
  for (const char* none :
       {"", "<limit/>", "<limit><lower>-1e16</lower><upper>1e16</upper></limit>",
        "<limit><lower>-inf</lower><upper>inf</upper><velocity>-1</velocity></limit>"}) {
    const auto free = of(none);
    EXPECT_EQ(free->joints[1].type, JointType::kContinuous) << none;
    EXPECT_TRUE(std::isinf(variableOf(*free, "j").velocity)) << none;
  }
  EXPECT_TRUE(std::isinf(variableOf(*of("", "prismatic"), "j").lower));
  const auto half = of("<limit><lower>1</lower></limit>");
  EXPECT_EQ(half->joints[1].type, JointType::kRevolute);
  EXPECT_EQ(variableOf(*half, "j").lower, 1);
  EXPECT_TRUE(std::isinf(variableOf(*half, "j").upper));
  EXPECT_EQ(half->defaultConfiguration().at(0), 1);
}

TEST(Sdf, MimicsFollow) {
  const auto robot =
      load(sdf("<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>" +
                   joint("<axis><xyz>0 0 1</xyz></axis>") +
                   "<joint name=\"k\" "
                   "type=\"revolute\"><parent>a</parent><child>c</child><axis><xyz>0 0 1</xyz>"
                   "<mimic "
                   "joint=\"j\"><multiplier>2</multiplier><offset>0.5</offset><reference>0.25</"
                   "reference></mimic>"
                   "</axis></joint>",
               "1.11"));
  ASSERT_EQ(robot->variables.size(), 1u);
  expectAt(poseOf(*robot, {1}, "c"), {0, 0, 0}, aboutZ(2 * (1 - 0.25) + 0.5));
}

TEST(Sdf, MimicsOfWhatIsLeftOut) {
  const std::string links =
      "<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>"
      "<joint name=\"k\" type=\"prismatic\"><parent>a</parent><child>c</child><axis><xyz>1 0 0"
      "</xyz><mimic joint=\"";
  const std::string numbers =
      "\"><multiplier>2</multiplier><offset>0.5</offset><reference>0.2</reference></mimic></axis>"
      "</joint>";
  const auto expectWarning = [](const Model& robot, const std::string& words) {
    EXPECT_TRUE(std::any_of(
        robot.warnings.begin(), robot.warnings.end(),
        [&](const std::string& warning) { return warning.find(words) != std::string::npos; }))
        << words;
  };
  const auto geared =
      load(sdf(links + "g" + numbers + joint("<axis><xyz>0 0 1</xyz></axis>") +
               "<joint name=\"g\" type=\"gearbox\"><parent>a</parent><child>b</child></joint>"));
  EXPECT_EQ(geared->variables.size(), 2u);
  expectWarning(*geared, "\"k\" mimics \"g\", which is left out: it is an independent joint");
  const auto still =
      load(sdf(links + "s::j" + numbers + joint("<axis><xyz>0 0 1</xyz></axis>") +
               "<model name=\"s\"><static>1</static><link name=\"a\"/><link name=\"b\"/>" +
               joint("<axis><xyz>0 0 1</xyz></axis>") +
               "</model><joint name=\"w\" type=\"fixed\">"
               "<parent>world</parent><child>a</child></joint>"));
  EXPECT_EQ(still->variables.size(), 1u);
  expectWarning(*still, "\"k\" mimics \"s::j\", which is left out: it stands still");
  expectAt(poseOf(*still, {0}, "c"), {0.5 - 2 * 0.2, 0, 0}, aboutZ(0));
}

TEST(Sdf, LinksThatAJointJoinsAreNotChecked) {
  const std::string box =
      "<collision name=\"c\"><geometry><box><size>1 1 1</size></box></geometry></collision>";
  const auto robot =
      load(sdf("<link name=\"a\">" + box + "</link><link name=\"b\">" + box + "</link>" +
               joint("<pose>1 0 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis>")));
  ASSERT_EQ(robot->disabled_pairs.size(), 1u);
  EXPECT_EQ(robot->disabled_pairs[0].link_a, robot->findLink("a"));
  EXPECT_EQ(robot->disabled_pairs[0].link_b, robot->findLink("b"));
  EXPECT_EQ(robot->disabled_pairs[0].reason, "joined by j");
}

TEST(Sdf, VisualsStandInOnlyWhenAsked) {
  const Folder folder;
  const std::string file =
      folder.write("robot.sdf", sdf("<link name=\"a\"><visual name=\"v\"><geometry><sphere>"
                                    "<radius>1</radius></sphere></geometry></visual></link>"));
  EXPECT_TRUE(loadModel(file, "")->links[0].geometries.empty());
  LoadOptions options;
  options.visual_as_collision = true;
  const auto robot = loadModel(file, "", options);
  EXPECT_EQ(robot->links[0].geometries.size(), 1u);
  EXPECT_NE(robot->warnings.at(0).find("stand in for it: \"a\""), std::string::npos);
}

// Models in models.

constexpr const char* kTool = R"(<sdf version="1.5"><model name="tool">
  <pose>0 0 5 0 0 0</pose>
  <link name="palm"><pose>0 0 0.1 0 0 0</pose>
    <collision name="c"><geometry><mesh><uri>meshes/palm.stl</uri><scale>2 2 2</scale></mesh></geometry></collision></link>
  <link name="finger"><pose>0 0 0.3 0 0 0</pose></link>
  <joint name="grip" type="prismatic"><parent>palm</parent><child>finger</child>
    <axis><xyz>1 0 0</xyz><limit><lower>0</lower><upper>1</upper></limit></axis></joint>
</model></sdf>)";

constexpr const char* kTetrahedron = R"(solid s
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid s
)";

/// Folders "arm" and "tool" beside each other.
class SdfIncludes : public ::testing::Test {
 protected:
  SdfIncludes() {
    folder_.write(
        "tool/model.config",
        "<model><name>t</name><sdf version=\"1.4\">old.sdf</sdf><sdf version=\"1.5\">model.sdf"
        "</sdf><sdf version=\"9.9\">new.sdf</sdf></model>");
    folder_.write("tool/model.sdf", kTool);
    folder_.write("tool/meshes/palm.stl", kTetrahedron);
  }
  std::shared_ptr<const Model> load(const std::string& inside) const {
    return loadModel(folder_.write("arm/arm.sdf", sdf("<link name=\"arm\"/>\n" + inside)), "");
  }
  Folder folder_;
};

TEST_F(SdfIncludes, PlaceModelsByTheirNames) {
  const std::string rest =
      "<pose>1 0 0 0 0 0</pose></include><joint name=\"w\" type=\"fixed\"><parent>arm</parent>"
      "<child>left::palm</child></joint>";
  for (const char* uri : {"model://tool", "model://tool/", "../tool", "package://tool/model.sdf"}) {
    const auto robot = load("<include><uri>" + std::string(uri) + "</uri><name>left</name>" + rest);
    ASSERT_EQ(robot->variables.size(), 1u) << uri;
    EXPECT_EQ(robot->variables[0].name, "left::grip");
    expectAt(poseOf(*robot, {0.5}, "left::finger"), {1.5, 0, 0.3}, Eigen::Matrix3d::Identity());
    EXPECT_EQ(geometryOf(*robot, "left::palm").shape.type(), ShapeType::kMesh);
  }
}

TEST_F(SdfIncludes, KeepTheirOwnPoseAndMayStandTwice) {
  const std::string joints =
      "<joint name=\"w\" type=\"fixed\"><parent>arm</parent><child>tool::palm</child></joint>"
      "<joint name=\"x\" type=\"fixed\"><parent>arm</parent><child>other</child></joint>";
  const auto robot = load(
      "<include><uri>model://tool</uri></include><include><uri>model://tool</uri>"
      "<name>other</name><placement_frame>finger</placement_frame>"
      "<pose relative_to=\"tool::finger\">0 0 1 0 0 0</pose></include>" +
      joints);
  expectAt(poseOf(*robot, {0, 0}, "tool::palm"), {0, 0, 5.1}, Eigen::Matrix3d::Identity());
  expectAt(poseOf(*robot, {0, 0}, "other::finger"), {0, 0, 6.3}, Eigen::Matrix3d::Identity());
  expectAt(poseOf(*robot, {0, 0}, "other::palm"), {0, 0, 6.1}, Eigen::Matrix3d::Identity());
}

TEST_F(SdfIncludes, MergeIntoTheModel) {
  const auto robot = load(
      "<include merge=\"true\"><uri>model://tool</uri><pose>1 0 0 0 0 0</pose></include>"
      "<joint name=\"w\" type=\"fixed\"><parent>arm</parent><child>palm</child></joint>");
  EXPECT_EQ(robot->variables[0].name, "grip");
  expectAt(poseOf(*robot, {0}, "finger"), {1, 0, 0.3}, Eigen::Matrix3d::Identity());
}

TEST_F(SdfIncludes, NestedModelsAreFramesOfTheirModel) {
  const auto robot = load(
      "<model name=\"m\"><pose>0 1 0 0 0 0</pose><link name=\"l\"><pose>0 0 1 0 0 0</pose></link>"
      "<model name=\"n\"><link name=\"l\"/></model></model>"
      "<joint name=\"j\" type=\"fixed\"><parent>arm</parent><child>m</child></joint>"
      "<joint name=\"k\" "
      "type=\"fixed\"><parent>m::l</parent><child>m::n::__model__</child></joint>");
  expectAt(poseOf(*robot, {}, "m::l"), {0, 1, 1}, Eigen::Matrix3d::Identity());
  expectAt(poseOf(*robot, {}, "m::n::l"), {0, 1, 0}, Eigen::Matrix3d::Identity());
}

TEST_F(SdfIncludes, SayWhatIsWrongInWhichFile) {
  const std::string arm = folder_.path("arm/arm.sdf"), tool = folder_.path("tool/model.sdf");
  const auto expect = [&](const std::string& inside, const std::string& file, int line,
                          std::initializer_list<std::string> words) {
    expectInputError([&] { load(inside); }, file, line, words);
  };
  expect("<include><uri>model://none</uri></include>", arm, 4,
         {"model \"model://none", "was not found"});
  expect("<include><uri>model://tool</uri>\n<experimental:params/></include>", arm, 5,
         {"experimental:params"});
  expect("<include><uri>arm.sdf</uri></include>", arm, 4, {"arm.sdf", "includes this file"});
  expect("<include><uri>x.urdf</uri></include>", arm, 4, {"URDF", "SDF would be accepted"});
  expect(
      "<include><uri>model://tool</uri><placement_frame>plam</placement_frame>"
      "<pose>0 0 0 0 0 0</pose></include>"
      "<joint name=\"w\" type=\"fixed\"><parent>arm</parent><child>tool::palm</child></joint>",
      tool, 1, {"\"tool::plam\"", "did you mean \"tool::palm\"?"});
  expect("<include><uri>model://tool</uri><placement_frame>palm</placement_frame></include>", arm,
         4, {"<placement_frame> \"palm\"", "no <pose>"});
  folder_.write("tool/model.sdf",
                "<sdf version=\"1.5\"><model name=\"tool\">\n<link/></model></sdf>");
  expect("<include><uri>model://tool</uri></include>", tool, 2, {"<link> has no name"});
  folder_.write("tool/model.sdf",
                "<sdf version=\"1.5\"><model name=\"tool\">\n<include><uri>model://tool</uri>"
                "<name>t</name></include></model></sdf>");
  expect("<include><uri>model://tool</uri></include>", tool, 2, {"includes this file"});
}

// A slow twin: the same random robot as URDF.

std::string numbers(const Eigen::VectorXd& values) {
  std::string text;
  char word[40];
  for (const double value : values) {
    std::snprintf(word, sizeof word, "%.17g ", value);
    text += word;
  }
  return text;
}

std::string quaternionPose(const Pose& X) {
  const Eigen::Quaterniond q(X.rotation);
  Eigen::VectorXd v(7);
  v << X.translation, q.x(), q.y(), q.z(), q.w();
  return " rotation_format=\"quat_xyzw\">" + numbers(v) + "</pose>";
}

Pose poseOfAngles(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
  Pose X;
  X.translation = xyz;
  X.rotation = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return X;
}

struct Twins {
  std::string urdf = "<robot name=\"robot\"><link name=\"l0\"/>", sdf;
  int beside = 0;  // joints beside the origin of their link
};

/// Writes each link in one of several ways, all of which mean the same.
Twins randomTwins(Random& random, int count) {
  Twins twins;
  std::string& s = twins.sdf;
  std::vector<Pose> X_WL(1);  // at rest
  s = "<link name=\"l0\"/>";
  static constexpr const char* kTypes[] = {"revolute", "prismatic", "continuous", "fixed"};
  for (int i = 1; i < count; ++i) {
    const int p = random.integer(i);
    const std::string link = "l" + std::to_string(i), parent = "l" + std::to_string(p),
                      name = "j" + std::to_string(i), type = kTypes[random.integer(4)];
    const Eigen::Vector3d xyz = random.vector(1), rpy = random.vector(3), axis = random.direction(),
                          at = random.vector(1);
    const Pose X_PL = poseOfAngles(xyz, rpy), X_WP = X_WL[static_cast<std::size_t>(p)];
    X_WL.push_back(X_WP * X_PL);
    Eigen::VectorXd six(6);
    six << xyz, rpy;
    const bool moves = type != "fixed", is_beside = moves && random.integer(3) == 0;
    twins.beside += is_beside && type != "prismatic" ? 1 : 0;
    const std::string child = is_beside ? link + "_joint" : link;
    const std::string sphere = "<geometry><sphere";
    twins.urdf += "<link name=\"" + link + "\"><collision><origin xyz=\"" + numbers(at) + "\"/>" +
                  sphere + " radius=\"0.1\"/></geometry></collision></link>";
    // The joint may be at X_LJ in the link, beside its origin.
    const Pose X_LJ = is_beside ? random.pose(1) : Pose();
    const Pose X_PJ = X_PL * X_LJ, X_JL = X_LJ.inverse();
    const auto origin = [](const Pose& X) {
      const Eigen::Vector3d ypr = X.rotation.eulerAngles(2, 1, 0);
      return "<origin xyz=\"" + numbers(X.translation) + "\" rpy=\"" + numbers(ypr.reverse()) +
             "\"/>";
    };
    twins.urdf += "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
                  "\"/><child link=\"" + child + "\"/>" + origin(X_PJ) + "<axis xyz=\"" +
                  numbers(axis) +
                  "\"/><limit lower=\"-1\" upper=\"2\" velocity=\"3\" effort=\"1\"/></joint>";
    if (is_beside)
      twins.urdf += "<link name=\"" + child + "\"/><joint name=\"" + name +
                    "_end\" type=\"fixed\"><parent link=\"" + child + "\"/><child link=\"" + link +
                    "\"/>" + origin(X_JL) + "</joint>";

    std::string link_pose, joint_pose, axis_frame;
    Eigen::Vector3d written = axis;
    const int way = is_beside ? 1 + random.integer(3) : random.integer(4);
    if (way == 0) {  // as converters of URDFs write it
      link_pose = "<pose relative_to=\"" + name + "\">0 0 0 0 0 0</pose>";
      joint_pose = "<pose relative_to=\"" + parent + "\">" + numbers(six) + "</pose>";
    } else if (way == 1) {
      link_pose = "<pose relative_to=\"" + parent + "\">" + numbers(six) + "</pose>";
    } else if (way == 2) {
      link_pose = "<pose" + quaternionPose(X_WL.back());
      axis_frame = " expressed_in=\"__model__\"";
      written = X_WL.back().rotation * X_LJ.rotation * axis;
    } else {
      s += "<frame name=\"f" + std::to_string(i) + "\" attached_to=\"" + parent + "\"><pose>" +
           numbers(six) + "</pose></frame>";
      link_pose = "<pose relative_to=\"f" + std::to_string(i) + "\"/>";
      axis_frame = " expressed_in=\"" + parent + "\"";
      written = X_PJ.rotation * axis;
    }
    if (is_beside) joint_pose = "<pose" + quaternionPose(X_LJ);
    s += "<joint name=\"" + name + "\" type=\"" + type + "\">" + joint_pose + "<parent>" + parent +
         "</parent><child>" + link + "</child>" +
         (moves ? "<axis><xyz" + axis_frame + ">" + numbers(written) +
                      "</xyz><limit><lower>-1</lower><upper>2</upper><velocity>3</velocity></"
                      "limit></axis>"
                : "") +
         "</joint><link name=\"" + link + "\">" + link_pose + "<collision name=\"c\"><pose>" +
         numbers(at) + " 0 0 0</pose>" + sphere +
         "><radius>0.1</radius></sphere></geometry></collision></link>";
  }
  twins.urdf += "</robot>";
  return twins;
}

TEST(Sdf, IsTheSameRobotAsItsUrdf) {
  Random random(20);
  int beside = 0;
  for (int round = 0; round < 60; ++round) {
    const Twins twins = randomTwins(random, 2 + random.integer(8));
    beside += twins.beside;
    const Folder folder;
    const auto urdf = loadModel(folder.write("robot.urdf", twins.urdf), "");
    const auto robot = loadModel(folder.write("robot.sdf", sdf(twins.sdf)), "");
    ASSERT_EQ(robot->variables.size(), urdf->variables.size()) << twins.sdf;
    for (int look = 0; look < 5; ++look) {
      std::vector<double> q(urdf->variables.size()), mine(q.size());
      for (std::size_t v = 0; v < q.size(); ++v) {
        const Variable& variable = urdf->variables[v];
        q[v] = random.uniform(-1, 2);
        const int same = robot->findVariable(variable.name);
        ASSERT_GE(same, 0) << variable.name;
        const Variable& other = robot->variables[static_cast<std::size_t>(same)];
        EXPECT_EQ(other.lower, variable.lower);
        EXPECT_EQ(other.upper, variable.upper);
        EXPECT_EQ(other.velocity, variable.velocity);
        mine[static_cast<std::size_t>(same)] = q[v];
      }
      for (const Link& link : urdf->links) {
        if (link.name.ends_with("_joint")) continue;
        const Pose X = poseOf(*urdf, q, link.name), Y = poseOf(*robot, mine, link.name);
        ASSERT_LE((X.translation - Y.translation).norm(), 1e-13) << link.name << '\n' << twins.sdf;
        ASSERT_LE((X.rotation - Y.rotation).norm(), 1e-13) << link.name << '\n' << twins.sdf;
        if (link.geometries.empty()) continue;
        EXPECT_EQ(geometryOf(*robot, link.name).X_BG.translation,
                  link.geometries[0].X_BG.translation);
      }
    }
  }
  EXPECT_GT(beside, 20);
}

// Warnings and messages.

TEST(Sdf, UnknownPartsAreLeftOutWithTheirLine) {
  const auto robot =
      load(sdf("<link name=\"a\"><wheel_slip/>\n<pose frame=\"x\">0 0 0 0 0 0</pose>"
               "<drake:rigid/></link><plugin name=\"p\" filename=\"q\"><x/></plugin>"));
  ASSERT_EQ(robot->warnings.size(), 3u);
  std::string all;
  for (const std::string& warning : robot->warnings) all += warning + '\n';
  for (const char* words : {"robot.sdf:3: <wheel_slip> in <link> is not known and is left out",
                            "robot.sdf:4: <pose> has the unknown attribute \"frame\"",
                            "robot.sdf:4: <drake:rigid> in <link> is not known and is left out"})
    EXPECT_NE(all.find(words), std::string::npos) << words << '\n' << all;
}

/// What bears on geometry, kinematics or limits is read, refused or named.
TEST(Sdf, PartsThatAreNotReadAreNamed) {
  const std::string axis = joint(
      "\n<axis2/>\n<axis><xyz>1 0 0</xyz>\n<initial_position>1</initial_position>\n"
      "<use_parent_model_frame>1</use_parent_model_frame>\n<limit><lower>1</lower>"
      "<velocity>0</velocity></limit></axis>",
      "continuous");
  const auto robot = load(
      "<sdf version=\"1.9\">\n<actor name=\"p\"/><world name=\"w\">\n<state "
      "world_name=\"w\"/>\n<population name=\"p\"/>\n<model "
      "name=\"m\">\n<model_state name=\"m\"/><link name=\"a\"><visual "
      "name=\"v\"><collision><geometry/>"
      "</collision></visual></link><link "
      "name=\"b\"><collision name=\"c\">\n<surface><collision name=\"d\"><geometry/></collision>"
      "<contact><collide_bitmask>1</collide_bitmask></contact></surface><geometry><sphere><radius>1"
      "</radius></sphere></geometry></collision></link>" +
      axis + "</model></world></sdf>");
  std::string all;
  for (const std::string& warning : robot->warnings) all += warning + '\n';
  for (const char* words :
       {":2: <actor> in <sdf> is left out", ":3: <state> in <world> is left out",
        ":4: <population> in <world> is left out", ":6: <model_state> in <model> is left out",
        ":6: <collision> in <visual> is left out; one in a <link> would be read",
        ":7: <collision> in <surface> is left out; one in a <link> would be read",
        ":7: <collide_bitmask> in <contact> is left out", ":8: <axis2> in <joint> is left out",
        ":10: <initial_position> in <axis> is left out",
        ":11: <use_parent_model_frame> in <axis> is left out",
        ":12: joint \"j\" is continuous: its <lower> and <upper> are left out",
        ":12: the velocity limit \"0\" of joint \"j\" is taken for none"})
    EXPECT_NE(all.find(words), std::string::npos) << words << '\n' << all;
}

struct BadSdf {
  const char* name;
  std::string text;
  int line;
  std::initializer_list<std::string> words;
};

void PrintTo(const BadSdf& bad, std::ostream* stream) { *stream << bad.text; }

class SdfMessage : public ::testing::TestWithParam<BadSdf> {};

TEST_P(SdfMessage, SaysWhereWhatAndWhatInstead) {
  const Folder folder;
  const std::string file = folder.write("bad.sdf", GetParam().text);
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

/// Two links in line 3, and `inside` in line 4.
std::string two(const std::string& inside, const std::string& version = "1.9") {
  return sdf("<link name=\"a\"/><link name=\"b\"/>\n" + inside, version);
}

/// A link with a shape in line 4.
std::string shaped(const std::string& shape) {
  return sdf("<link name=\"a\"><collision name=\"c\"><geometry>\n" + shape +
             "</geometry></collision></link>");
}

std::string axis(const std::string& inside) { return joint("<axis>" + inside + "</axis>"); }

const BadSdf kBad[] = {
    {"Version", "<sdf version=\"2.0\">\n</sdf>", 1, {"\"2.0\"", "1.2 to 1.12"}},
    {"NoVersion", "<sdf>\n</sdf>", 1, {"no version"}},
    {"NoModel", "<sdf version=\"1.9\">\n</sdf>", 1, {"no <model>"}},
    {"NoLink", sdf(""), 1, {"no <link>"}},
    {"Element", two("<lnik name=\"c\"/>"), 4, {"<lnik>", "did you mean <link>?"}},
    {"Reserved", two("<frame name=\"__x__\"/>"), 4, {"\"__x__\"", "reserved"}},
    {"World", two("<link name=\"world\"/>"), 4, {"\"world\"", "reserved"}},
    {"Twice", two("<frame name=\"a\"/>"), 4, {"second \"a\"", "line 3", "unique"}},
    {"PoseNumbers",
     two("<frame name=\"f\"><pose>1 2 3</pose></frame>"),
     4,
     {"<pose>", "\"1 2 3\"", "6 numbers"}},
    {"PoseWord",
     two("<frame name=\"f\"><pose>1 2 3 x 0 0</pose></frame>"),
     4,
     {"\"x\"", "finite number"}},
    {"PoseWithXyz",
     two("<frame name=\"f\"><pose xyz=\"1 0 0\"/></frame>"),
     4,
     {"<pose> has the attribute xyz", "x y z roll pitch yaw"}},
    {"PoseFar", two("<frame name=\"f\"><pose>1e10 2 3 0 0 0</pose></frame>"), 4, {"<pose>", "1e9"}},
    {"PoseTwice", two("<frame name=\"f\"><pose/><pose/></frame>"), 4, {"second <pose>"}},
    {"PoseFormat",
     two("<frame name=\"f\"><pose rotation_format=\"rpy\"/></frame>"),
     4,
     {"\"rpy\"", "quat_xyzw"}},
    {"PoseAttribute",
     two("<link name=\"c\"><pose relative_too=\"a\"/></link>"),
     4,
     {"\"relative_too\"", "relative_to"}},
    {"Quaternion",
     two("<frame name=\"f\"><pose rotation_format=\"quat_xyzw\">0 0 0 0 0 0 0</pose></frame>"),
     4,
     {"quaternion", "zero"}},
    {"Relative",
     sdf("<link name=\"arm\"/>\n<link name=\"b\"><pose relative_to=\"arn\"/></link>" +
         std::string(
             "<joint name=\"j\" type=\"fixed\"><parent>arm</parent><child>b</child></joint>")),
     4,
     {"\"arn\"", "did you mean \"arm\"?"}},
    {"Circle",
     sdf("<link name=\"a\"><pose relative_to=\"f\"/></link>\n<frame name=\"f\"><pose "
         "relative_to=\"a\"/></frame>"),
     3,
     {"\"a\"", "circle"}},
    {"AttachedCircle",
     two("<frame name=\"f\" attached_to=\"g\"/><frame name=\"g\" attached_to=\"f\"><pose "
         "relative_to=\"a\"/></frame><joint name=\"j\" "
         "type=\"fixed\"><parent>f</parent><child>b</child></joint>"),
     4,
     {"\"f\"", "attached to itself"}},
    {"Roots", two(""), 3, {"2 roots", "fixed joint"}},
    {"NoParent",
     two("<joint name=\"j\" type=\"fixed\"><child>b</child></joint>"),
     4,
     {"no <parent>"}},
    {"Parent",
     two("<joint name=\"j\" type=\"fixed\"><parent>c</parent><child>b</child></joint>"),
     4,
     {"<parent>", "\"c\"", "not defined"}},
    {"Loop",
     two(joint("", "fixed") +
         "<joint name=\"k\" type=\"fixed\"><parent>a</parent><child>b</child></joint>"),
     4,
     {"two parents"}},
    {"Ball", two(joint("", "ball")), 4, {"\"ball\"", "not read", "in series"}},
    {"Screw", two(joint("", "screw")), 4, {"\"screw\"", "not read"}},
    {"Type", two(joint("", "fixd")), 4, {"\"fixd\"", "did you mean \"fixed\"?"}},
    {"Axis", two(axis("<xyz>0 0 0</xyz>")), 4, {"axis", "\"0 0 0\"", "zero"}},
    {"AxisFrame", two(axis("<xyz expressed_in=\"c\">0 0 1</xyz>")), 4, {"\"c\"", "not defined"}},
    {"Limits",
     two(axis("<limit><lower>1</lower><upper>0</upper></limit>")),
     4,
     {"lower limit \"1\"", "upper limit \"0\""}},
    {"LimitWord", two(axis("<limit><lower>low</lower></limit>")), 4, {"<lower>", "\"low\""}},
    {"LimitEndless",
     two(axis("<limit><lower>1e16</lower></limit>")),
     4,
     {"<lower> is \"1e16\"", "-1e16 to 1e16"}},
    {"LimitAttribute",
     two(axis("<limit lower=\"-1\" upper=\"1\"/>")),
     4,
     {"<limit> has the attribute", "lower=\"-1\"", "<lower>-1</lower> would be accepted"}},
    {"AxisInTwoFrames",
     two(axis("<xyz expressed_in=\"a\">0 0 1</xyz>"), "1.4"),
     4,
     {"expressed_in is \"a\"", "this version of SDF"}},
    {"Mimic", two(axis("<mimic joint=\"k\"/>")), 4, {"<mimic>", "\"k\"", "not defined"}},
    {"MimicLink", two(axis("<mimic joint=\"a\"/>")), 4, {"\"a\"", "no joint"}},
    {"MimicItself", two(axis("<mimic joint=\"j\"/>")), 4, {"\"j\"", "mimics itself"}},
    {"Geometry", shaped("<cone/>"), 4, {"<cone>", "not read", "capsule"}},
    {"NoGeometry", shaped(""), 3, {"<geometry> is empty"}},
    {"NoRadius", shaped("<sphere/>"), 4, {"no <radius>"}},
    {"Radius",
     shaped("<sphere><radius>-1</radius></sphere>"),
     4,
     {"<radius>", "\"-1\"", "zero or more"}},
    {"Size", shaped("<box><size>1 2</size></box>"), 4, {"<size>", "\"1 2\"", "3 numbers"}},
    {"Edges", shaped("<box><size>1 2 -1</size></box>"), 4, {"\"1 2 -1\"", "zero or more"}},
    {"Normal", shaped("<plane><normal>0 0 0</normal></plane>"), 4, {"<normal>", "direction"}},
    {"Uri", shaped("<mesh><uri/></mesh>"), 4, {"<uri>", "empty"}},
    {"MissingMesh", shaped("<mesh><uri>m.stl</uri></mesh>"), 4, {"mesh \"m.stl\"", "not found"}},
    {"Scale",
     shaped("<mesh><uri>m.stl</uri><scale>1 0 1</scale></mesh>"),
     4,
     {"\"1 0 1\"", "other than zero"}},
    {"Submesh",
     shaped("<mesh><uri>m.stl</uri><submesh><name>x</name></submesh></mesh>"),
     4,
     {"<submesh>", "not read"}},
    {"Optimization",
     shaped("<mesh optimization=\"hull\"><uri>m.stl</uri></mesh>"),
     4,
     {"\"hull\"", "convex_hull"}},
    {"MovingPlane",
     sdf("<link name=\"a\"/><link name=\"b\"><collision "
         "name=\"c\"><geometry>\n<plane/></geometry></collision></link>" +
         joint("<axis><xyz>0 0 1</xyz></axis>")),
     4,
     {"plane moves", "\"b\""}},
    {"Static", two("<static>maybe</static>"), 4, {"<static>", "\"maybe\"", "true or false"}},
    {"WorldJoint",
     "<sdf version=\"1.11\"><world name=\"w\">\n<joint name=\"j\" type=\"fixed\"/></world></sdf>",
     2,
     {"<joint> of the <world>"}},
    {"WorldAndModel",
     "<sdf version=\"1.11\"><world name=\"w\"><model name=\"a\"><link "
     "name=\"l\"/></model></world>\n"
     "<model name=\"b\"><link name=\"l\"/></model></sdf>",
     2,
     {"<model> beside <world>", "one robot would be accepted"}},
    {"WorldModels",
     "<sdf version=\"1.9\"><world name=\"w\"><model name=\"a\"/>\n<model "
     "name=\"b\"/></world></sdf>",
     2,
     {"second model", "line 1"}},
};

INSTANTIATE_TEST_SUITE_P(All, SdfMessage, ::testing::ValuesIn(kBad),
                         [](const ::testing::TestParamInfo<BadSdf>& bad) {
                           return std::string(bad.param.name);
                         });

}  // namespace
}  // namespace leeway::robots
