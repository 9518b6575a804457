// Any bytes as the SRDF of a small robot: a model, referring to existing things only, or an
// InputError.

#include "tests/fuzz/check_robot.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace {

const char* const kUrdf = R"(<robot name="r">
  <link name="base"/><link name="one"/><link name="two"/><link name="tool"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="b" type="continuous"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/></joint>
  <joint name="c" type="fixed"><parent link="two"/><child link="tool"/></joint>
</robot>
)";

}  // namespace

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  std::vector<std::string> seeds = sourceTextsUnder("robots", ".srdf");
  seeds.push_back(R"(<?xml version="1.0"?>
<robot name="r">
  <virtual_joint name="world" type="fixed" parent_frame="world" child_link="base"/>
  <group name="arm"><chain base_link="base" tip_link="tool"/></group>
  <group name="part"><joint name="a"/><link name="two"/></group>
  <group name="both"><group name="arm"/><group name="part"/></group>
  <group_state name="home" group="arm"><joint name="a" value="0.5"/><joint name="b" value="-0.5"/></group_state>
  <end_effector name="hand" parent_link="two" group="part"/>
  <passive_joint name="b"/>
  <disable_collisions link1="base" link2="one" reason="Adjacent"/>
</robot>
)");
  return seeds;
}

std::vector<std::string> dictionary() {
  return {"<group name=\"arm\">",
          "</group>",
          "<group name=\"both\"/>",
          "<chain base_link=\"tool\" tip_link=\"base\"/>",
          "<joint name=\"z\"/>",
          "type=\"floating\"",
          "type=\"planar\"",
          "value=\"nan\"",
          "value=\"\"",
          "<disable_collisions link1=\"x\" link2=\"base\"/>",
          "<!--",
          "-->"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  static const std::string urdf = [] {
    const std::string text = kUrdf;
    return fuzz::writeInput("robot.urdf",
                            {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }();
  fuzz::checkRobot(urdf, fuzz::writeInput("input.srdf", {data, size}));
  return 0;
}
