#include "robots/load/visual_shapes.h"

#include <gtest/gtest.h>

#include <string>

#include "leeway/robots/input_error.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

bool mentions(const VisualShapes& visuals, const std::string& text) {
  for (const std::string& why : visuals.left_out)
    if (why.find(text) != std::string::npos) return true;
  return false;
}

TEST(VisualShapes, OfAUrdf) {
  const Folder folder;
  static_cast<void>(folder.write("skin.obj", kTetrahedron));
  const std::string urdf = folder.write("robot.urdf", R"(<robot name="two">
<link name="base"><visual><geometry><box size="1 2 3"/></geometry></visual></link>
<link name="arm">
  <visual><origin xyz="0 0 0.5"/><geometry><mesh filename="skin.obj" scale="2 2 2"/></geometry></visual>
  <visual><geometry><mesh filename="gone.obj"/></geometry></visual>
  <visual><geometry><teapot/></geometry></visual>
  <visual><geometry><cylinder radius="-1" length="1"/></geometry></visual>
  <collision><geometry><sphere radius="0.1"/></geometry></collision>
</link>
<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>
)");
  const auto robot = loadModel(urdf, "");
  const VisualShapes visuals = loadVisualShapes(*robot);
  ASSERT_EQ(visuals.shapes.size(), 2u);
  EXPECT_EQ(visuals.shapes[0].link, robot->findLink("base"));
  ASSERT_TRUE(visuals.shapes[0].shape);
  EXPECT_EQ(visuals.shapes[0].shape->type(), collision::ShapeType::kBox);
  EXPECT_EQ(visuals.shapes[1].link, robot->findLink("arm"));
  EXPECT_FALSE(visuals.shapes[1].shape);
  EXPECT_EQ(visuals.shapes[1].mesh.triangles.size(), 4u);
  EXPECT_EQ(visuals.shapes[1].mesh.vertices[1], Eigen::Vector3d(0.2, 0, 0));
  EXPECT_EQ(visuals.shapes[1].X_LV.translation, Eigen::Vector3d(0, 0, 0.5));
  // The others are left out, each with its line.
  EXPECT_EQ(visuals.left_out.size(), 3u);
  EXPECT_TRUE(mentions(visuals, "gone.obj"));
  EXPECT_TRUE(mentions(visuals, "robot.urdf:6"));
  EXPECT_TRUE(mentions(visuals, "teapot"));
  // The robot itself is what it was: what is checked has no visual shape.
  EXPECT_EQ(robot->links[static_cast<std::size_t>(robot->findLink("arm"))].geometries.size(), 1u);
}

TEST(VisualShapes, OfAnSdf) {
  const Folder folder;
  static_cast<void>(folder.write("tool/skin.obj", kTetrahedron));
  static_cast<void>(folder.write("tool/tool.sdf", R"(<sdf version="1.9"><model name="tool">
<link name="palm"><visual name="v"><geometry><mesh><uri>skin.obj</uri></mesh></geometry></visual></link>
</model></sdf>)"));
  const std::string file = folder.write("robot.sdf", R"(<sdf version="1.9"><model name="two">
<link name="base">
  <visual name="v"><pose>0 0 1 0 0 0</pose><material/><geometry><plane><size>2 3</size></plane></geometry></visual>
  <visual name="w"><geometry><heightmap/></geometry></visual>
</link>
<frame name="f" attached_to="base"><pose>0 1 0 0 0 0</pose></frame>
<link name="arm"><visual name="v"><pose relative_to="f"/><geometry><sphere><radius>1</radius></sphere></geometry></visual></link>
<include><uri>tool/tool.sdf</uri></include>
<joint name="j" type="fixed"><parent>base</parent><child>arm</child></joint>
<joint name="k" type="fixed"><parent>arm</parent><child>tool</child></joint>
</model></sdf>
)");
  const auto robot = loadModel(file, "");
  const VisualShapes visuals = loadVisualShapes(*robot);
  ASSERT_EQ(visuals.shapes.size(), 3u) << testing::PrintToString(visuals.left_out);
  ASSERT_TRUE(visuals.shapes[0].shape);  // a plane that is drawn has its size
  EXPECT_EQ(visuals.shapes[0].shape->halfExtents(), Eigen::Vector3d(1, 1.5, 0));
  EXPECT_EQ(visuals.shapes[0].X_LV.translation, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(visuals.shapes[1].X_LV.translation, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(visuals.shapes[2].link, robot->findLink("tool::palm"));
  EXPECT_EQ(visuals.shapes[2].mesh.triangles.size(), 4u);  // beside the file that names it
  EXPECT_EQ(visuals.left_out.size(), 1u);
  EXPECT_TRUE(mentions(visuals, "robot.sdf:4"));
}

TEST(VisualShapes, OfMjcf) {
  const Folder folder;
  static_cast<void>(folder.write("skin.obj", kTetrahedron));
  const std::string file = folder.write("robot.xml", R"(<mujoco>
<asset><mesh name="skin" file="skin.obj"/></asset>
<worldbody>
  <geom type="plane" size="1 1 1"/>
  <body name="arm"><joint type="hinge" axis="0 0 1" range="-90 90"/>
    <geom type="mesh" mesh="skin" contype="0" conaffinity="0"/>
    <geom type="sphere" size="0.1" group="3"/>
    <geom type="box" size="0.1 0.2 0.3" pos="0 0 1"/>
    <geom type="mesh" mesh="shin" contype="0" conaffinity="0"/>
  </body>
</worldbody>
</mujoco>
)");
  const auto robot = loadModel(file, "");
  const VisualShapes visuals = loadVisualShapes(*robot);
  // MuJoCo's viewer hides group 3; planes are left out.
  ASSERT_EQ(visuals.shapes.size(), 2u);
  EXPECT_EQ(visuals.shapes[0].mesh.triangles.size(), 4u);
  EXPECT_EQ(visuals.shapes[0].link, robot->findLink("arm"));
  ASSERT_TRUE(visuals.shapes[1].shape);
  EXPECT_EQ(visuals.shapes[1].X_LV.translation, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(visuals.left_out.size(), 1u);
  EXPECT_TRUE(mentions(visuals, "robot.xml:9"));
}

TEST(VisualShapes, OfARobotThatHasNone) {
  const auto body =
      freeBody("body", {}, JointType::kFloating, -Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones());
  EXPECT_TRUE(mentions(loadVisualShapes(*body), "not read from a file"));
  const Folder folder;
  const std::string urdf =
      folder.write("bare.urdf", "<robot name=\"bare\"><link name=\"a\"/></robot>");
  const auto robot = loadModel(urdf, "");
  EXPECT_TRUE(mentions(loadVisualShapes(*robot), "has no visual shapes"));
  // A file that is no longer there.
  std::filesystem::remove(urdf);
  EXPECT_THROW(loadVisualShapes(*robot), InputError);
  // Stopped.
  static_cast<void>(folder.write(
      "bare.urdf",
      "<robot name=\"bare\"><link name=\"a\"><visual><geometry><sphere radius=\"1\"/></geometry>"
      "</visual></link></robot>"));
  EXPECT_THROW(loadVisualShapes(*robot, [] { return true; }), Stopped);
}

}  // namespace
}  // namespace leeway::robots
