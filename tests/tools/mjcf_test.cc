#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

/// The arm of arm.urdf, in MuJoCo's XML, on a floor.
constexpr const char* kMjcf = R"(<mujoco model="twolink">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" pos="0 0 -0.3"/>
    <body name="base">
      <body name="upper">
        <joint name="shoulder" axis="0 0 1" range="-3 3"/>
        <geom type="box" size="0.2 0.02 0.02" pos="0.25 0 0"/>
        <body name="lower" pos="0.5 0 0">
          <joint name="elbow" axis="0 0 1" range="-2.5 2.5"/>
          <geom type="box" size="0.2 0.02 0.02" pos="0.25 0 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <keyframe>
    <key name="right" qpos="-1 0"/>
    <key name="left" qpos="1 0.25"/>
  </keyframe>
</mujoco>
)";

class Mjcf : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("arm.xml", kMjcf);
  }
};

TEST_F(Mjcf, IsDescribed) {
  const json document = run("info arm.xml --json").document();
  EXPECT_EQ(document["robot"]["name"], "twolink");
  EXPECT_EQ(document["robot"]["links"], 4);
  EXPECT_EQ(document["robot"]["disabled_pairs"], 1);
  EXPECT_EQ(document["robot"]["variables"][0]["lower"], -3);
  EXPECT_EQ(run("info arm.xml").status, 0);
}

TEST_F(Mjcf, PlansAsItsUrdfDoes) {
  std::string text = kReach;
  text.replace(text.find("{urdf"),
               std::string("{urdf: arm.urdf, srdf: arm.srdf, group: arm}").size(),
               "{urdf: arm.xml}");
  write("mjcf.yaml", text);
  const Answer answer = run("plan mjcf.yaml --output path.json --json");
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  EXPECT_EQ(run("verify mjcf.yaml path.json").status, 0);
  // The same path, of the same robot from its URDF.
  EXPECT_EQ(run("verify reach.yaml path.json").status, 0);
  EXPECT_EQ(run("plan --robot arm.xml --group all --start right --goal left").status, 0);
}

/// Nothing could be planned for a pair that always touches, so it is left out, and named.
TEST_F(Mjcf, PairsThatAlwaysTouchAreNamed) {
  std::string text = kMjcf;
  const std::string geom = "<geom type=\"box\" size=\"0.2 0.02 0.02\" pos=\"0.25 0 0\"/>";
  for (const char* named :
       {"<geom name=\"g\" type=\"box\" size=\"0.3 0.02 0.02\" pos=\"0.25 0 0\"/>",
        "<geom name=\"h\" type=\"box\" size=\"0.3 0.02 0.02\" pos=\"0.25 0 0\"/>"})
    text.replace(text.find(geom), geom.size(), named);
  text.replace(text.find("  <keyframe>"), 0,
               "  <contact><pair geom1=\"g\" geom2=\"h\"/></contact>\n");
  write("always.xml", text);
  const Answer answer = run("plan --robot always.xml --group all --start right --goal left");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.err.find("links 'upper' and 'lower' are not checked although the robot's file "
                            "has a <pair> of them: they are touching"),
            std::string::npos)
      << answer.err;
}

TEST_F(Mjcf, CollidesWithItsFloor) {
  std::string text = kMjcf;
  text.replace(text.find("axis=\"0 0 1\""), 12, "axis=\"0 1 0\"");
  write("arm.xml", text);
  EXPECT_EQ(run("check --robot arm.xml --state shoulder=0").status, 0);
  const Answer down = run("check --robot arm.xml --state shoulder=1");
  EXPECT_EQ(down.status, 1) << down.out << down.err;
  EXPECT_NE(down.out.find("world"), std::string::npos) << down.out;
}

TEST_F(Mjcf, SaysWhatIsWrong) {
  write("arm.xml",
        std::string(kMjcf).replace(std::string(kMjcf).find("type=\"box\""), 10, "type=\"bx\"  "));
  expectRefused("info arm.xml", {"arm.xml:8: type of <geom> is \"bx\"", "box"});
  expectRefused("plan --robot arm.xml --group all --start right --goal left", {"arm.xml:8:"});
  write("arm.xml", "<robt>\n</robt>");
  expectRefused("info arm.xml", {"arm.xml:1:", "<robot>", "<mujoco>", "<sdf>"});
}

}  // namespace
}  // namespace leeway::tools::testing
