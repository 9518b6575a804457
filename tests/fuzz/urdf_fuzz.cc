// Any bytes as a URDF: a model that checkModel() accepts, or an InputError.

#include "tests/fuzz/check_robot.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  std::vector<std::string> seeds = sourceTextsUnder("robots", ".urdf");
  seeds.push_back(R"(<?xml version="1.0"?>
<robot name="r">
  <link name="base"><collision><origin xyz="0 0 0.1" rpy="0 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="one"><collision><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
  <link name="two"><collision name="c"><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="three"><collision><geometry><mesh filename="package://r/three.stl" scale="1 1 1"/></geometry></collision></link>
  <link name="four"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="b" type="prismatic"><parent link="one"/><child link="two"/><origin xyz="0 0 0.4"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" velocity="1" effort="1"/><mimic joint="a" multiplier="2" offset="0.1"/></joint>
  <joint name="c" type="continuous"><parent link="two"/><child link="four"/></joint>
  <joint name="d" type="floating"><parent link="four"/><child link="three"/></joint>
</robot>
)");
  return seeds;
}

std::vector<std::string> dictionary() {
  return {"<link name=\"x\"/>",
          "<joint name=\"j\" type=\"fixed\">",
          "</joint>",
          "<parent link=\"base\"/>",
          "<child link=\"base\"/>",
          "<child link=\"one\"/>",
          "type=\"planar\"",
          "type=\"revolute\"",
          "type=\"ball\"",
          "<axis xyz=\"0 0 0\"/>",
          "<capsule radius=\"1\" length=\"1\"/>",
          "xyz=\"1 2\"",
          "rpy=\"nan 0 0\"",
          "<mimic joint=\"b\"/>",
          "<limit/>",
          "<!--",
          "-->",
          "&amp;",
          "&#0;",
          "<![CDATA[",
          "package://",
          "../"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  leeway::fuzz::checkRobot(leeway::fuzz::writeInput("input.urdf", {data, size}));
  return 0;
}
