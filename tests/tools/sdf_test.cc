#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

/// The arm of arm.urdf, as SDF.
constexpr const char* kSdf = R"(<sdf version="1.9">
  <model name="twolink">
    <link name="base"/>
    <link name="upper">
      <collision name="c">
        <pose>0.25 0 0 0 0 0</pose>
        <geometry><box><size>0.4 0.04 0.04</size></box></geometry>
      </collision>
    </link>
    <link name="lower">
      <pose relative_to="elbow"/>
      <collision name="c">
        <pose>0.25 0 0 0 0 0</pose>
        <geometry><box><size>0.4 0.04 0.04</size></box></geometry>
      </collision>
    </link>
    <joint name="shoulder" type="revolute">
      <parent>base</parent><child>upper</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-3</lower><upper>3</upper></limit></axis>
    </joint>
    <joint name="elbow" type="revolute">
      <pose relative_to="upper">0.5 0 0 0 0 0</pose>
      <parent>upper</parent><child>lower</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-2.5</lower><upper>2.5</upper></limit></axis>
    </joint>
  </model>
</sdf>
)";

class Sdf : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("arm.sdf", kSdf);
  }
};

TEST_F(Sdf, IsDescribed) {
  const json document = run("info arm.sdf --json").document();
  EXPECT_EQ(document["robot"]["name"], "twolink");
  EXPECT_EQ(document["robot"]["links"], 3);
  EXPECT_EQ(document["robot"]["variables"][0]["lower"], -3);
  EXPECT_EQ(run("lint arm.sdf").status, 0);
}

TEST_F(Sdf, PlansAsItsUrdfDoes) {
  std::string text = kReach;
  text.replace(text.find("{urdf: arm.urdf"), std::string("{urdf: arm.urdf").size(),
               "{urdf: arm.sdf");
  write("sdf.yaml", text);
  const Answer answer = run("plan sdf.yaml --output path.json --json");
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  EXPECT_EQ(run("verify sdf.yaml path.json").status, 0);
  // The same path, of the same robot from its URDF.
  EXPECT_EQ(run("verify reach.yaml path.json").status, 0);
  EXPECT_EQ(run("plan --robot arm.sdf --chain base lower --start -1,0 --goal 1,0.25").status, 0);
  const json fk = run("fk arm.sdf --joints 0,0 --link lower --json").document();
  EXPECT_EQ(run("srdf arm.sdf --output out.srdf").status, 0);
  EXPECT_EQ(run("info arm.sdf --srdf out.srdf").status, 0);
}

TEST_F(Sdf, SaysWhatIsWrong) {
  std::string text = kSdf;
  text.replace(text.find("<box>"), 5, "<bx>");
  text.replace(text.find("</box>"), 6, "</bx>");
  write("arm.sdf", text);
  expectRefused("info arm.sdf", {"arm.sdf:7:", "<bx>", "box"});
  expectRefused("plan --robot arm.sdf --chain base lower --start 0,0 --goal 1,0", {"arm.sdf:7:"});
}

}  // namespace
}  // namespace leeway::tools::testing
