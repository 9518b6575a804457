// Any bytes as an MJCF file: a model that checkModel() accepts, or an InputError.

#include "tests/fuzz/check_robot.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  return {R"(<mujoco model="r">
  <compiler angle="degree" eulerseq="zYx" meshdir="meshes"/>
  <default>
    <geom size="0.1"/>
    <default class="arm">
      <joint axis="0 1 0" range="-90 90"/>
      <geom type="capsule" size="0.05 0.1"/>
    </default>
  </default>
  <asset><mesh name="m" file="m.stl" scale="1 1 1" refpos="0 0 1" refquat="1 0 0 0"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base" pos="0 0 1" euler="10 20 30" childclass="arm">
      <joint name="a" pos="0 0 0.1" ref="5"/>
      <geom name="g" fromto="0 0 0 0 0 1"/>
      <frame pos="1 0 0" zaxis="1 0 0">
        <geom type="box" size="1 1 1" axisangle="0 0 1 90"/>
        <body name="two" xyaxes="1 0 0 0 1 0">
          <joint name="b" type="slide" range="0 1"/>
          <joint name="c"/>
          <geom name="h" type="ellipsoid" size="1 2 3" contype="2" conaffinity="2"/>
        </body>
      </frame>
    </body>
    <body name="free"><freejoint/><geom class="arm"/></body>
  </worldbody>
  <contact><exclude body1="base" body2="free"/><pair geom1="g" geom2="h"/></contact>
  <equality><joint joint1="c" joint2="a" polycoef="0 2"/><weld body1="two" body2="free"/></equality>
  <keyframe><key name="home" qpos="1 0.5 2 0 0 0 1 0 0 0"/></keyframe>
</mujoco>
)"};
}

std::vector<std::string> dictionary() {
  return {"<body name=\"x\">",
          "</body>",
          "<frame>",
          "</frame>",
          "<joint/>",
          "<freejoint/>",
          "<geom/>",
          "type=\"mesh\"",
          "type=\"slide\"",
          "type=\"ball\"",
          "childclass=\"arm\"",
          "class=\"arm\"",
          "<default>",
          "</default>",
          "<include file=\"input.xml\"/>",
          "quat=\"0 0 0 0\"",
          "fromto=\"",
          "limited=\"true\"",
          "range=\"1 0\"",
          "<joint joint1=\"a\"/>",
          "mocap=\"true\"",
          "<exclude",
          "<key name=\"k\" ",
          "<!--",
          "-->"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  leeway::fuzz::checkRobot(leeway::fuzz::writeInput("input.xml", {data, size}));
  return 0;
}
