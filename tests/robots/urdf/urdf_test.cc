#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/kinematics.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::robots {
namespace {

/// A robot with link "a" (line 2); `rest` starts in line 3.
std::string robot(const std::string& rest) {
  return "<robot name=\"r\">\n<link name=\"a\"/>\n" + rest + "\n</robot>\n";
}

std::string jointLine(const std::string& name, const std::string& type, const std::string& parent,
                      const std::string& child, const std::string& rest = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + rest + "</joint>\n";
}

const std::string kLimit = "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";

struct BadUrdf {
  const char* name;
  std::string text;
  int line;
  std::initializer_list<std::string> words;
};

void PrintTo(const BadUrdf& bad, std::ostream* stream) { *stream << bad.text; }

class UrdfMessage : public testing::TestWithParam<BadUrdf> {};

TEST_P(UrdfMessage, SaysWhereWhatAndWhatInstead) {
  const Folder folder;
  const std::string file = folder.write("bad.urdf", GetParam().text);
  expectInputError([&] { loadModel(file, ""); }, file, GetParam().line, GetParam().words);
}

const BadUrdf kBad[] = {
    {"SyntaxError",
     "<robot name=\"r\">\n<link name=\"a\">\n</robot>\n",
     2,
     {"XML syntax error", "well-formed XML"}},
    {"Empty", "", 0, {"empty", "URDF file"}},
    {"OtherRoot", "<scene>\n</scene>", 1, {"<scene>", "<robot>", "<sdf>"}},
    {"NoLinks", "<robot name=\"r\">\n</robot>", 1, {"no <link>", "at least one"}},
    {"Xacro",
     "<robot name=\"r\">\n<link name=\"a\"/>\n<xacro:arm side=\"left\"/></robot>",
     3,
     {"xacro:arm", "expand it first: xacro ", " > "}},
    {"XInclude",
     "<robot name=\"r\">\n<link name=\"a\"/>\n<xi:include href=\"x.xml\"/></robot>",
     3,
     {"<xi:include> brings in what is not in this file", "would be accepted"}},
    {"LinkWithoutName", robot("<link/>"), 3, {"<link> has no name"}},
    {"LinkTwice", robot("<link name=\"a\"/>"), 3, {"second link \"a\"", "line 2", "unique"}},
    {"JointTwice",
     robot("<link name=\"b\"/><link name=\"c\"/>\n" + jointLine("j", "fixed", "a", "b") +
           jointLine("j", "fixed", "a", "c")),
     5,
     {"second joint \"j\"", "line 4"}},
    {"JointWithoutType",
     robot("<link name=\"b\"/>\n<joint name=\"j\"><parent link=\"a\"/><child link=\"b\"/></joint>"),
     4,
     {"has no type"}},
    {"UnknownType",
     robot("<link name=\"b\"/>\n" + jointLine("j", "revolut", "a", "b")),
     4,
     {"\"revolut\"", "did you mean \"revolute\"?", "prismatic"}},
    {"UnknownParent",
     robot("<link name=\"shoulder\"/>\n" + jointLine("j", "fixed", "sholder", "a")),
     4,
     {"parent link \"sholder\"", "did you mean \"shoulder\"?"}},
    {"UnknownChild",
     robot("\n" + jointLine("j", "fixed", "a", "qqqqqq")),
     4,
     {"child link \"qqqqqq\"", "name of a <link>"}},
    {"NoParent",
     robot("<link name=\"b\"/>\n<joint name=\"j\" type=\"fixed\"><child link=\"b\"/></joint>"),
     4,
     {"<joint> has no <parent>", "exactly one"}},
    {"TwoParentElements",
     robot("<link name=\"b\"/>\n<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/>\n<parent "
           "link=\"b\"/><child link=\"b\"/></joint>"),
     5,
     {"second <parent>", "line 4"}},
    {"TwoRoots",
     robot("<link name=\"b\"/>\n<link name=\"c\"/>\n" + jointLine("j", "fixed", "a", "b")),
     4,
     {"2 roots", "\"a\" (line 2)", "\"c\"", "fixed joint"}},
    {"TwoParents",
     robot("<link name=\"b\"/><link name=\"c\"/>\n" + jointLine("j", "fixed", "a", "b") +
           jointLine("k", "fixed", "c", "b") + jointLine("l", "fixed", "a", "c")),
     5,
     {"link \"b\" has two parents", "\"j\" (line 4)", "\"k\""}},
    {"Cycle",
     robot("<link name=\"b\"/>\n" + jointLine("j", "fixed", "a", "b") +
           jointLine("k", "fixed", "b", "a")),
     5,
     {"cycle", "\"a\"", "\"b\"", "tree"}},
    {"DetachedCycle",
     robot("<link name=\"b\"/><link name=\"c\"/>\n" + jointLine("j", "fixed", "b", "c") +
           jointLine("k", "fixed", "c", "b")),
     5,
     {"cycle", "\"b\"", "\"c\""}},
    {"TwoVariablesOfOneName",
     robot("<link name=\"b\"/><link name=\"c\"/>\n" + jointLine("p", "planar", "a", "b") +
           jointLine("p/x", "continuous", "b", "c")),
     5,
     {"'p/x' is there twice"}},
    {"JoinedToItself",
     robot(jointLine("j", "fixed", "a", "a")),
     3,
     {"\"a\" to itself", "two different links"}},
    {"MissingLimit",
     robot("<link name=\"b\"/>\n" + jointLine("j", "revolute", "a", "b")),
     4,
     {"\"j\" has no <limit>", "lower=", "continuous"}},
    {"LowerAboveUpper",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b",
                     "\n<limit lower=\"2\" upper=\"1.5\" effort=\"1\" velocity=\"1\"/>")),
     5,
     {"lower limit \"2\"", "above", "\"1.5\"", "\"j\""}},
    {"NanLimit",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b",
                     "\n<limit lower=\"nan\" upper=\"1.5\" effort=\"1\" velocity=\"1\"/>")),
     5,
     {"lower of <limit> holds \"nan\"", "finite number"}},
    {"InfiniteLimit",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b",
                     "\n<limit lower=\"0\" upper=\"inf\" effort=\"1\" velocity=\"1\"/>")),
     5,
     {"\"inf\"", "finite"}},
    {"HugeLimit",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b",
                     "\n<limit lower=\"0\" upper=\"1e999\" effort=\"1\" velocity=\"1\"/>")),
     5,
     {"\"1e999\"", "finite"}},
    {"HugeAngles",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b", "\n<origin rpy=\"1e200 0 0\"/>" + kLimit)),
     5,
     {"rpy", "\"1e200 0 0\"", "1e9"}},
    {"ZeroAxis",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b", "\n<axis xyz=\"0 0 0\"/>" + kLimit)),
     5,
     {"axis \"0 0 0\"", "\"j\"", "other than zero"}},
    {"ShortAxis",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b", "\n<axis xyz=\"0 1\"/>" + kLimit)),
     5,
     {"2 numbers", "three"}},
    {"NanAxis",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "revolute", "a", "b", "\n<axis xyz=\"0 nan 0\"/>" + kLimit)),
     5,
     {"\"nan\"", "finite"}},
    {"WordInOrigin",
     robot("<link name=\"b\"/>\n" + jointLine("j", "fixed", "a", "b", "\n<origin xyz=\"0 x 0\"/>")),
     5,
     {"xyz of <origin> holds \"x\""}},
    {"UnknownOriginAttribute",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "fixed", "a", "b", "\n<origin xyz=\"0 0 0\" quat=\"0 0 0 1\"/>")),
     5,
     {"\"quat\"", "xyz, rpy, quat_xyzw"}},
    {"ZeroQuaternion",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "fixed", "a", "b", "\n<origin quat_xyzw=\"0 0 0 0\"/>")),
     5,
     {"quat_xyzw of <origin> is \"0 0 0 0\"", "four numbers x y z w that are not all 0"}},
    {"ThreeNumbersOfAQuaternion",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "fixed", "a", "b", "\n<origin quat_xyzw=\"0 0 1\"/>")),
     5,
     {"quat_xyzw of <origin> is \"0 0 1\"", "four numbers"}},
    {"AnglesBesideAQuaternion",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "fixed", "a", "b", "\n<origin rpy=\"0 0 1\" quat_xyzw=\"0 0 0 1\"/>")),
     5,
     {"both rpy and quat_xyzw"}},
    {"UnknownMimicMaster",
     robot("<link name=\"b\"/><link name=\"c\"/>" + jointLine("elbow", "continuous", "a", "b") +
           "\n" + jointLine("elbou", "continuous", "b", "c", "\n<mimic joint=\"elbo\"/>")),
     6,
     {"\"elbou\" mimics \"elbo\"", "not defined", "\"elbow\""}},
    {"MimicsItself",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "continuous", "a", "b", "\n<mimic joint=\"j\"/>")),
     5,
     {"mimics itself"}},
    {"MimicCycle",
     robot("<link name=\"b\"/><link name=\"c\"/>\n" +
           jointLine("j", "continuous", "a", "b", "<mimic joint=\"k\"/>") +
           jointLine("k", "continuous", "b", "c", "<mimic joint=\"j\"/>")),
     4,
     {"\"j\" mimics itself", "by way of others"}},
    {"MimicsFixed",
     robot("<link name=\"b\"/><link name=\"c\"/>\n" + jointLine("j", "fixed", "a", "b") +
           jointLine("k", "continuous", "b", "c", "<mimic joint=\"j\"/>")),
     5,
     {"\"k\" mimics \"j\"", "no single position"}},
    {"PlanarMimics",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "planar", "a", "b", "<axis xyz=\"0 0 1\"/><mimic joint=\"j\"/>")),
     4,
     {"planar", "cannot mimic"}},
    {"UnknownGeometry",
     robot("<link name=\"b\"><collision><geometry><box size=\"1 1 "
           "1\"/></geometry></collision>\n<collision><geometry><torus "
           "radius=\"1\"/></geometry></collision></link>"),
     4,
     {"<torus> is not known", "<box>, <sphere>, <cylinder>, <capsule> or <mesh>"}},
    {"EmptyGeometry",
     robot("<link name=\"b\"><collision>\n<geometry/></collision></link>"),
     4,
     {"<geometry> is empty", "<box>"}},
    {"NoGeometry", robot("<link name=\"b\">\n<collision/></link>"), 4, {"no <geometry>"}},
    {"TwoShapes",
     robot("<link name=\"b\"><collision><geometry><sphere radius=\"1\"/>\n<sphere "
           "radius=\"2\"/></geometry></collision></link>"),
     4,
     {"second shape <sphere>", "collisions of their own"}},
    {"NegativeBox",
     robot("<link name=\"b\"><collision><geometry>\n<box size=\"1 -1 "
           "1\"/></geometry></collision></link>"),
     4,
     {"\"1 -1 1\"", "zero or more"}},
    {"NegativeRadius",
     robot("<link name=\"b\"><collision><geometry>\n<sphere "
           "radius=\"-0.5\"/></geometry></collision></link>"),
     4,
     {"radius of <sphere> is \"-0.5\"", "zero or more"}},
    {"LargeRadius",
     robot("<link name=\"b\"><collision><geometry>\n<sphere "
           "radius=\"1e18\"/></geometry></collision></link>\n" +
           jointLine("j", "fixed", "a", "b")),
     4,
     {"sphere: radius is 1e+18", "at most 1e+09 [m]"}},
    {"SmallBox",
     robot("<link name=\"b\"><collision><geometry>\n<box size=\"0 1e-12 "
           "0\"/></geometry></collision></link>\n" +
           jointLine("j", "fixed", "a", "b")),
     4,
     {"box: half extent in y is 4.9999999999999999e-13", "from 1e-09 to 1e+09 [m]"}},
    {"InfiniteLength",
     robot("<link name=\"b\"><collision><geometry>\n<cylinder radius=\"1\" "
           "length=\"inf\"/></geometry></collision></link>"),
     4,
     {"length of <cylinder> holds \"inf\"", "finite"}},
    {"NoRadius",
     robot("<link name=\"b\"><collision><geometry>\n<cylinder "
           "length=\"1\"/></geometry></collision></link>"),
     4,
     {"<cylinder> has no radius"}},
    {"MisspeltSize",
     robot("<link name=\"b\"><collision><geometry>\n<cylinder radius=\"1\" "
           "lenght=\"1\"/></geometry></collision></link>"),
     4,
     {"\"lenght\"", "did you mean \"length\"?", "radius, length"}},
    {"MisspeltRotation",
     robot("<link name=\"b\"/>\n" +
           jointLine("j", "fixed", "a", "b", "\n<origin xyz=\"0 0 0\" ryp=\"0 0 1\"/>")),
     5,
     {"\"ryp\"", "did you mean \"rpy\"?"}},
    {"MisspeltCollision",
     robot("<link name=\"b\">\n<colision/></link>"),
     4,
     {"<colision> in <link>", "did you mean <collision>?"}},
    {"MisspeltLimit",
     robot("<link name=\"b\"/>\n" + jointLine("j", "continuous", "a", "b", "\n<limits/>")),
     5,
     {"<limits> in <joint>", "did you mean <limit>?"}},
    {"ExtensionInPlaceOfAShape",
     robot("<link name=\"b\"><collision><geometry>\n<drake:torus a=\"1\" b=\"1\" "
           "c=\"1\"/></geometry></collision></link>"),
     4,
     {"<drake:torus> is not known", "<capsule>"}},
    {"MeshNotFound",
     robot("<link name=\"b\"><collision><geometry>\n<mesh "
           "filename=\"package://arm/meshes/b.stl\"/></geometry></collision></link>\n" +
           jointLine("j", "fixed", "a", "b")),
     4,
     {"package://arm/meshes/b.stl", "not found", "--package arm=FOLDER"}},
    {"MeshScheme",
     robot("<link name=\"b\"><collision><geometry>\n<mesh "
           "filename=\"http://x.org/b.stl\"/></geometry></collision></link>\n" +
           jointLine("j", "fixed", "a", "b")),
     4,
     {"http://", "package://NAME/PATH"}},
    {"ZeroScale",
     robot("<link name=\"b\"><collision><geometry>\n<mesh filename=\"b.stl\" scale=\"1 0 "
           "1\"/></geometry></collision></link>"),
     4,
     {"\"1 0 1\"", "other than zero"}},
};

INSTANTIATE_TEST_SUITE_P(Urdf, UrdfMessage, testing::ValuesIn(kBad),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Urdf, MissingFileAndFolder) {
  const Folder folder;
  expectInputError([&] { loadModel(folder.path("none.urdf"), ""); }, folder.path("none.urdf"), 0,
                   {"no such file", "URDF"});
  expectInputError([&] { loadModel(folder.path(""), ""); }, folder.path(""), 0,
                   {"is a folder", "URDF"});
}

/// Puts a program named `xacro` first in the search path.
class WithXacro {
 public:
  explicit WithXacro(const Folder& folder, const std::string& script) : path_(::getenv("PATH")) {
    const std::filesystem::path bin = folder.path("bin");
    std::filesystem::create_directory(bin);
    if (!script.empty()) {
      writeText(bin / "xacro", "#!/bin/sh\n" + script);
      std::filesystem::permissions(bin / "xacro", std::filesystem::perms::owner_all);
    }
    ::setenv("PATH", script.empty() ? bin.c_str() : (bin.string() + ":" + path_).c_str(), 1);
  }
  ~WithXacro() { ::setenv("PATH", path_.c_str(), 1); }

 private:
  std::string path_;
};

TEST(Urdf, XacroIsExpandedByItsOwnCommand) {
  const Folder folder;
  const std::string file = folder.write("arm $(x).urdf.xacro", "<robot name=\"r\"/>");
  {
    const WithXacro xacro(folder,
                          "echo warned >&2; echo '<robot name=\"made\"><link name=\"a\"/>'\n"
                          "[ $# = 1 ] && [ -f \"$1\" ] && echo '</robot>'\n");
    EXPECT_EQ(loadModel(file, "")->name, "made");
  }
  {
    const WithXacro xacro(folder, "yes line | head -c 300000 >&2; echo undefined: x >&2; exit 2\n");
    expectInputError([&] { loadModel(file, ""); }, file, 0,
                     {"xacro cannot expand it: line | line", "undefined: x;"});
  }
  {
    // Regression: the program was waited for, even if the caller wanted to stop.
    const WithXacro xacro(folder, "exec sleep 50\n");
    LoadOptions options;
    int asked = 0;
    options.stop = [&] { return ++asked > 2; };
    EXPECT_THROW(loadModel(file, "", options), Stopped);
  }
  const WithXacro xacro(folder, "kill -9 $$\n");
  expectInputError([&] { loadModel(file, ""); }, file, 0, {"it fails without a word"});
}

TEST(Urdf, XacroFileNamesTheCommandThatExpandsIt) {
  const Folder folder;
  const WithXacro none(folder, "");
  const std::string file = folder.write("arm.urdf.xacro", "<robot name=\"r\"/>");
  expectInputError([&] { loadModel(file, ""); }, file, 0,
                   {"xacro file", "pip install xacro", "ros-",
                    "xacro " + file + " > " + folder.path("arm.urdf")});
}

TEST(Urdf, ShapesPosesLimitsAndWarnings) {
  const Folder folder;
  const auto model = loadModel(folder.write("good.urdf", R"(<?xml version="1.0"?>
<robot name="good">
  <material name="red"/>
  <link name="tip">
    <collision name="ball"><origin xyz="1 2 3"/><geometry><sphere radius=".5"/></geometry></collision>
    <collision><geometry><cylinder radius="+0.25" length="2e0"/></geometry></collision>
  </link>
  <link name="base"><visual><geometry><capsule radius="1" length="2"/></geometry></visual></link>
  <link name="middle"><collision><origin rpy="0 0 1.5"/><geometry><box size="1 2 4"/></geometry></collision><blob/></link>
  <joint name="j2" type="prismatic"><parent link="middle"/><child link="tip"/><axis xyz="0 0 -2"/><limit upper="0.5" effort="1" velocity="3"/></joint>
  <joint name="j1" type="continuous"><parent link="base"/><child link="middle"/></joint>
  <loop_joint name="x"/>
</robot>)"),
                               "");
  ASSERT_EQ(model->links.size(), 3u);
  EXPECT_EQ(model->links[0].name, "base");
  EXPECT_EQ(model->links[1].name, "middle");
  EXPECT_EQ(model->links[2].name, "tip");
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(model->links[static_cast<std::size_t>(i)].joint, i);
    EXPECT_EQ(model->joints[static_cast<std::size_t>(i)].child_link, i);
  }
  EXPECT_EQ(model->joints[0].type, JointType::kFixed);
  EXPECT_EQ(model->joints[0].parent_link, -1);
  ASSERT_EQ(model->variables.size(), 2u);
  EXPECT_EQ(model->variables[0].name, "j1");
  EXPECT_TRUE(std::isinf(model->variables[0].lower) && std::isinf(model->variables[0].velocity));
  EXPECT_EQ(model->joints[1].axis, Eigen::Vector3d::UnitX());  // URDF's default
  EXPECT_EQ(model->joints[2].axis, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(model->variables[1].lower, 0);
  EXPECT_EQ(model->variables[1].upper, 0.5);
  EXPECT_EQ(model->variables[1].velocity, 3);
  const auto& tip = model->links[2].geometries;
  ASSERT_EQ(tip.size(), 2u);
  EXPECT_EQ(tip[0].name, "ball");
  EXPECT_EQ(tip[0].X_BG.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(tip[0].shape.radius(), 0.5);
  EXPECT_EQ(tip[1].shape.type(), collision::ShapeType::kCylinder);
  EXPECT_EQ(tip[1].shape.halfLength(), 1);
  const auto& box = model->links[1].geometries.at(0);
  EXPECT_EQ(box.shape.halfExtents(), Eigen::Vector3d(0.5, 1, 2));
  EXPECT_NEAR(box.X_BG.rotation(0, 0), std::cos(1.5), 1e-16);
  EXPECT_EQ(model->groups.back().name, "all");
  ASSERT_EQ(model->warnings.size(), 3u);
  EXPECT_NE(model->warnings[0].find("good.urdf:12: <loop_joint>"), std::string::npos)
      << model->warnings[0];
  EXPECT_NE(model->warnings[2].find("good.urdf:8: link \"base\" has a <visual>"), std::string::npos)
      << model->warnings[2];
  EXPECT_NE(model->warnings[1].find("good.urdf:9: <blob>"), std::string::npos)
      << model->warnings[1];
}

// A master joint is limited by the slowest of its followers.
TEST(Urdf, VelocityLimitsOfMimicJointsBoundTheirMaster) {
  const Folder folder;
  const auto limit = [](const char* velocity) {
    return std::string("<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"") + velocity +
           "\"/>";
  };
  const auto velocity = [&](const char* own, const std::string& follower,
                            const std::string& second) {
    const std::string file =
        folder.write("mimic.urdf", robot("<link name=\"b\"/><link name=\"c\"/><link name=\"d\"/>" +
                                         jointLine("m", "revolute", "a", "b", limit(own)) +
                                         jointLine("f", "revolute", "a", "c", follower) +
                                         jointLine("g", "revolute", "a", "d", second)));
    const auto model = loadModel(file, "");
    EXPECT_EQ(model->variables.size(), 1U);
    return model->variables.front().velocity;
  };
  const std::string half = "<mimic joint=\"m\" multiplier=\"-2\"/>";
  const std::string chained = "<mimic joint=\"f\" multiplier=\"4\"/>";
  EXPECT_EQ(velocity("3", limit("5") + half, limit("100") + chained), 2.5);
  EXPECT_EQ(velocity("3", limit("5") + half, limit("10") + chained), 1.25);  // -8 times the master
  EXPECT_EQ(velocity("1", limit("5") + half, limit("100") + chained), 1);
  // Cases without a limit on the master, on the follower, or on a fixed joint.
  EXPECT_EQ(velocity("0", limit("5") + half, limit("100") + chained), 2.5);
  EXPECT_EQ(velocity("3", limit("0") + half, limit("0") + chained), 3);
  EXPECT_EQ(velocity("3", limit("5") + "<mimic joint=\"m\" multiplier=\"0\"/>",
                     limit("4") + "<mimic joint=\"m\"/>"),
            3);
}

TEST(Urdf, RollPitchYawTurnsAboutFixedAxes) {
  const Folder folder;
  const auto model = loadModel(
      folder.write("r.urdf",
                   robot("<link name=\"b\"/>" +
                         jointLine("j", "fixed", "a", "b", "<origin rpy=\"0.3 -0.7 2.1\"/>"))),
      "");
  const auto about = [](int axis, double angle) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    R(i, i) = R(j, j) = std::cos(angle);
    R(i, j) = -std::sin(angle);
    R(j, i) = std::sin(angle);
    return R;
  };
  const Eigen::Matrix3d expected = about(2, 2.1) * about(1, -0.7) * about(0, 0.3);
  EXPECT_LT((model->joints[1].X_PJ.rotation - expected).norm(), 1e-15);
}

TEST(Urdf, DeepChainsAndWideTreesKeepTreeOrder) {
  const Folder folder;
  std::string text;
  for (int i = 0; i < 3000; ++i) text += "<link name=\"l" + std::to_string(i) + "\"/>";
  for (int i = 0; i < 3000; ++i)
    text += jointLine("j" + std::to_string(i), "fixed",
                      i % 3 == 0 || i == 0 ? "a" : "l" + std::to_string(i - 1),
                      "l" + std::to_string(i));
  const auto model = loadModel(folder.write("r.urdf", robot(text)), "");
  ASSERT_EQ(model->links.size(), 3001u);
  for (int i = 1; i < 3001; ++i)
    EXPECT_LT(model->joints[static_cast<std::size_t>(i)].parent_link, i);
  EXPECT_EQ(model->links[3000].name, "l2999");
}

TEST(Urdf, TheFirstMeshThatFailsIsTold) {
  const Folder folder;
  std::string text;
  for (int i = 0; i < 6; ++i) {
    const std::string name = "m" + std::to_string(i);
    // The broken files are not the largest, which are read first.
    folder.write(name + ".obj",
                 i % 2 == 0 ? std::string(1000, '#') + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
                            : "v 0 0 0 but no face");
    text += "<link name=\"" + name + "\"><collision><geometry>\n<mesh filename=\"" + name +
            ".obj\"/></geometry></collision></link>\n" +
            jointLine("j" + std::to_string(i), "fixed", "a", name);
  }
  const std::string file = folder.write("r.urdf", robot(text));
  for (int i = 0; i < 20; ++i) {
    try {
      loadModel(file, "");
      FAIL();
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("m1.obj"), std::string::npos) << error.what();
      EXPECT_EQ(error.line(), 7);
    }
  }
}

// Meshes are built in parallel; a single core gives the same bytes.
TEST(Urdf, OneCoreLoadsTheSame) {
  LEEWAY_NEEDS_DATA("robots/panda");
  const std::string folder = dataFolder() + "/robots/";
  const auto load = [&] {
    return loadModel(folder + "panda/panda.urdf", folder + "panda/panda.srdf");
  };
  const auto many = load();
  cpu_set_t allowed, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
  CPU_ZERO(&one);
  for (std::size_t cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
    if (CPU_ISSET(cpu, &allowed)) CPU_SET(cpu, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  const auto single = load();
  ASSERT_EQ(sched_setaffinity(0, sizeof allowed, &allowed), 0);
  ASSERT_EQ(many->links.size(), single->links.size());
  int meshes = 0;
  for (std::size_t i = 0; i < many->links.size(); ++i) {
    ASSERT_EQ(many->links[i].geometries.size(), single->links[i].geometries.size());
    for (std::size_t k = 0; k < many->links[i].geometries.size(); ++k) {
      const auto *a = many->links[i].geometries[k].shape.mesh(),
                 *b = single->links[i].geometries[k].shape.mesh();
      ASSERT_EQ(a == nullptr, b == nullptr);
      if (a == nullptr) continue;
      ++meshes;
      EXPECT_TRUE(std::equal(a->vertices().begin(), a->vertices().end(), b->vertices().begin(),
                             b->vertices().end()));
      EXPECT_TRUE(std::equal(a->triangles().begin(), a->triangles().end(), b->triangles().begin(),
                             b->triangles().end()));
      EXPECT_EQ(a->hullExcess(), b->hullExcess());
      EXPECT_EQ(a->pieces().pieces, b->pieces().pieces);
      EXPECT_EQ(a->pieces().excess, b->pieces().excess);
      EXPECT_EQ(a->bytes(), b->bytes());
    }
  }
  EXPECT_GT(meshes, 10);
  ASSERT_EQ(many->linkGaps().size(), single->linkGaps().size());
  for (std::size_t i = 0; i < many->linkGaps().size(); ++i) {
    EXPECT_EQ(many->linkGaps()[i].gaps, single->linkGaps()[i].gaps);
    EXPECT_EQ(many->linkGaps()[i].cells, single->linkGaps()[i].cells);
  }
}

TEST(Urdf, RealRobots) {
  LEEWAY_NEEDS_DATA("robots/panda");
  const std::string folder = dataFolder() + "/robots/";
  const auto panda = loadModel(folder + "panda/panda.urdf", folder + "panda/panda.srdf");
  EXPECT_EQ(panda->links.size(), 13u);
  EXPECT_EQ(panda->links[1].geometries.at(0).shape.type(), collision::ShapeType::kMesh);
  const auto finger = [&](const char* name) {
    return panda->links[static_cast<std::size_t>(panda->findLink(name))]
        .geometries.at(0)
        .shape.mesh();
  };
  EXPECT_EQ(finger("panda_leftfinger"), finger("panda_rightfinger"))
      << "the same file was loaded twice";
  // Published forward kinematics at zero: the flange (link 8) is 0.088 from the wrist's axis, and
  // so on.
  std::vector<Pose> X_WL(panda->links.size());
  forwardKinematics(*panda, panda->defaultConfiguration(), X_WL);
  const Pose& flange = X_WL[static_cast<std::size_t>(panda->findLink("panda_link8"))];
  EXPECT_LT((flange.translation - Eigen::Vector3d(0.088, 0, 0.333 + 0.316 + 0.384 - 0.107)).norm(),
            1e-10);
  const auto ur5 = loadModel(folder + "ur5/ur5.urdf", folder + "ur5/ur5.srdf");
  std::size_t triangles = 0;
  for (const Link& link : ur5->links)
    for (const Geometry& g : link.geometries)
      if (g.shape.mesh() != nullptr) triangles += g.shape.mesh()->triangles().size();
  EXPECT_GT(triangles, 100000u);
}

}  // namespace
}  // namespace leeway::robots
