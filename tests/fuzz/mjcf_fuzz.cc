// Any bytes as an MJCF file: a model or an InputError. A model that loads has finite kinematics,
// and states and pairs of existing things.

#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "tests/fuzz/both_ways.h"
#include "tests/fuzz/shapes.h"
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
          "mocap=\"true\"",
          "<exclude",
          "<key name=\"k\" ",
          "<!--",
          "-->"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  try {
    const std::string path = fuzz::writeInput("input.xml", {data, size});
    const auto model = fuzz::loadBothWays([&](robots::InputErrors* errors) {
      robots::LoadOptions options;
      options.errors = errors;
      return robots::loadModel(path, "", options);
    });
    const std::vector<double> q = model->defaultConfiguration();
    std::vector<robots::Pose> X_WL(model->links.size());
    robots::forwardKinematics(*model, q, X_WL);
    for (std::size_t i = 0; i < X_WL.size(); ++i) {
      const robots::Link& link = model->links[i];
      if (!X_WL[i].rotation.allFinite() || !X_WL[i].translation.allFinite())
        fuzz::fail("link '%s' has no finite pose", link.name.c_str());
      if (model->findLink(link.name) != static_cast<int>(i))
        fuzz::fail("two links '%s'", link.name.c_str());
      for (const robots::Geometry& geometry : link.geometries)
        if (!geometry.X_BG.rotation.allFinite() || !geometry.X_BG.translation.allFinite())
          fuzz::fail("a geometry of '%s' has no finite pose", link.name.c_str());
    }
    for (const robots::GroupState& state : model->group_states)
      for (const auto& [variable, value] : state.values)
        if (variable < 0 || static_cast<std::size_t>(variable) >= q.size() || !(value - value == 0))
          fuzz::fail("state '%s' sets variable %d to %g", state.name.c_str(), variable, value);
    const auto isLink = [&](int link) {
      return link >= 0 && static_cast<std::size_t>(link) < X_WL.size();
    };
    for (const robots::DisabledPair& pair : model->disabled_pairs)
      if (!isLink(pair.link_a) || !isLink(pair.link_b) || pair.link_a >= pair.link_b)
        fuzz::fail("disabled pair %d %d", pair.link_a, pair.link_b);
  } catch (const robots::InputError& error) {
    if (error.what()[0] == '\0') fuzz::fail("an error without a message");
  }
  return 0;
}
