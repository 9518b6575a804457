// Any bytes as an SDF file: a model that checkModel() accepts, or an InputError.

#include "tests/fuzz/check_robot.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  return {R"(<sdf version="1.11">
  <model name="r" canonical_link="base" placement_frame="f">
    <pose degrees="true">0 0 1 0 0 90</pose>
    <static>false</static>
    <frame name="f" attached_to="one"><pose rotation_format="quat_xyzw">1 0 0 0 0 0 1</pose></frame>
    <link name="base">
      <collision name="c"><geometry><box><size>1 2 3</size></box></geometry></collision>
      <collision name="p"><geometry><plane><normal>0 1 0</normal></plane></geometry></collision>
    </link>
    <link name="one">
      <pose relative_to="base">0 0 1 0 0 0</pose>
      <collision name="c"><pose relative_to="f"/><geometry><capsule><radius>1</radius><length>2</length></capsule></geometry></collision>
    </link>
    <model name="tool">
      <pose relative_to="one">0 1 0 0 0 0</pose>
      <link name="palm"><collision name="c"><geometry><ellipsoid><radii>1 2 3</radii></ellipsoid></geometry></collision></link>
      <link name="jaw"><visual name="v"><geometry><sphere><radius>1</radius></sphere></geometry></visual></link>
      <joint name="grip" type="prismatic"><parent>palm</parent><child>jaw</child>
        <axis><xyz expressed_in="__model__">1 0 0</xyz><limit><lower>0</lower><upper>1</upper></limit></axis></joint>
    </model>
    <joint name="a" type="revolute"><pose>1 0 0 0 0 0</pose><parent>world</parent><child>base</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper><velocity>1</velocity></limit></axis></joint>
    <joint name="b" type="continuous"><parent>base</parent><child>f</child>
      <axis><xyz>0 1 0</xyz><mimic joint="a"><multiplier>2</multiplier><offset>1</offset><reference>1</reference></mimic></axis></joint>
    <joint name="w" type="fixed"><parent>one</parent><child>tool</child></joint>
  </model>
</sdf>
)",
          R"(<sdf version="1.4"><world name="w"><model name="m"><static>1</static>
  <link name="a"><pose>1 0 0 0 0 0</pose></link><link name="j"><pose>2 0 0 0 0 0</pose></link>
  <joint name="j" type="gearbox"><parent>a</parent><child>j</child><axis><xyz>1 0 0</xyz></axis></joint>
</model></world></sdf>
)"};
}

std::vector<std::string> dictionary() {
  return {"<link name=\"x\">",
          "</link>",
          "<joint name=\"j\" type=\"revolute\">",
          "</joint>",
          "<frame name=\"g\"/>",
          "<model name=\"m\">",
          "</model>",
          "<include><uri>input.sdf</uri></include>",
          "<include merge=\"true\"><uri>",
          "relative_to=\"f\"",
          "attached_to=\"f\"",
          "expressed_in=\"f\"",
          "tool::palm",
          "__model__",
          "world",
          "<parent>",
          "<child>",
          "<static>true</static>",
          "placement_frame=\"f\"",
          "<pose>",
          "-1e16",
          "inf",
          "<!--",
          "-->"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  leeway::fuzz::checkRobot(leeway::fuzz::writeInput("input.sdf", {data, size}));
  return 0;
}
