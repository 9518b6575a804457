#include "leeway/robots/named_states.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

std::vector<std::string> namesOf(const Model& model) {
  std::vector<std::string> names;
  for (const GroupState& state : namedStates(model)) names.push_back(state.name);
  return names;
}

TEST(NamedStates, AFreeBodyIsInTheMiddleOfItsBoundsAndStaysUpright) {
  const auto body = freeBody("body", {}, JointType::kFloating, {-1, 0, 2}, {3, 1, 6});
  const std::vector<GroupState> states = namedStates(*body);
  ASSERT_EQ(namesOf(*body), (std::vector<std::string>{"zero", "middle"}));
  std::vector<double> zero, middle;
  for (const auto& [v, value] : states[0].values) zero.push_back(value);
  for (const auto& [v, value] : states[1].values) middle.push_back(value);
  EXPECT_EQ(zero, body->defaultConfiguration());
  EXPECT_EQ(middle, (std::vector<double>{1, 0.5, 4, 0, 0, 0, 1}));
}

TEST(NamedStates, NamesOfTheSrdfAreTheSrdfs) {
  const Folder folder;
  const auto model =
      loadModel(folder.write("r.urdf", R"(<robot name="r"><link name="a"/><link name="b"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>)"),
                folder.write("r.srdf", R"(<robot name="r"><group name="g"><joint name="j"/></group>
<group_state name="zero" group="g"><joint name="j" value="1"/></group_state>
<group_state name="middle" group="g"><joint name="k" value="1"/></group_state></robot>)"));
  EXPECT_EQ(namesOf(*model), (std::vector<std::string>{"zero"})) << "middle is left out";
  EXPECT_EQ(namedStates(*model)[0].values[0].second, 1);
}

TEST(NamedStates, WhatAStateLacksIsNamed) {
  const Folder folder;
  const auto model = loadModel(
      folder.write("r.urdf", R"(<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/></joint></robot>)"),
      folder.write("r.srdf", R"(<robot name="r"><group name="g"><joint name="j"/></group>
<group name="h"><joint name="k"/></group>
<group_state name="up" group="g"><joint name="j" value="1"/></group_state></robot>)"));
  EXPECT_EQ(stateLackFault(*model, "up", std::vector{0}), "");
  EXPECT_EQ(stateLackFault(*model, "nobody", std::vector{0}), "");
  EXPECT_EQ(stateLackFault(*model, "up", std::vector{0, 1}),
            "group state 'up' lacks joint 'k'; a state with a value for each planned joint is "
            "expected");
  EXPECT_EQ(stateLackFault(*model, "zero", std::vector{0, 1}), "");
}

}  // namespace
}  // namespace leeway::robots
