#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "leeway/robots/model.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::robots {
namespace {

/// base - j1 - l1 - j2 - l2 - tool_joint (fixed) - tool, and base - k1 - m1 - k2 (mimics k1) - m2.
constexpr const char* kUrdf = R"(<robot name="two_arms">
<link name="base"/><link name="l1"><collision><geometry><sphere radius="0.1"/></geometry></collision></link><link name="l2"/><link name="tool"/><link name="m1"/><link name="m2"/>
<joint name="j1" type="continuous"><parent link="base"/><child link="l1"/></joint>
<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="tool_joint" type="fixed"><parent link="l2"/><child link="tool"/></joint>
<joint name="k1" type="continuous"><parent link="base"/><child link="m1"/></joint>
<joint name="k2" type="continuous"><parent link="m1"/><child link="m2"/><mimic joint="k1"/></joint>
</robot>)";

std::string srdf(const std::string& rest) {
  return "<robot name=\"two_arms\">\n" + rest + "\n</robot>";
}

class Srdf : public testing::Test {
 protected:
  std::shared_ptr<const Model> load(const std::string& rest, const LoadOptions& options = {}) {
    return loadModel(folder_.write("r.urdf", kUrdf), folder_.write("r.srdf", srdf(rest)), options);
  }
  /// Expects these warnings, each the beginning of ":LINE: text".
  void expectWarnings(const Model& model, const std::vector<std::string>& expected) {
    ASSERT_EQ(model.warnings.size(), expected.size()) << testing::PrintToString(model.warnings);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(model.warnings[i].rfind(folder_.path("r.srdf") + expected[i], 0), 0U)
          << model.warnings[i] << " should begin with " << expected[i];
  }
  std::vector<std::string> variables(const Model& model, const std::string& group) {
    std::vector<std::string> names;
    for (int v : model.groups.at(static_cast<std::size_t>(model.findGroup(group))).variables)
      names.push_back(model.variables[static_cast<std::size_t>(v)].name);
    return names;
  }
  void expectError(const std::string& rest, int line, std::initializer_list<std::string> words) {
    expectInputError([&] { load(rest); }, folder_.path("r.srdf"), line, words);
  }
  Folder folder_;
};

using Names = std::vector<std::string>;

TEST_F(Srdf, GroupsByChainJointLinkAndSubgroup) {
  const auto model = load(R"(<group name="both"><group name="arm"/><group name="second"/></group>
<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group name="second"><joint name="k1"/></group>
<group name="upper"><chain base_link="l1" tip_link="tool"/></group>
<group name="linked"><link name="l2"/><link name="base"/></group>
<group name="across"><chain base_link="m1" tip_link="l1"/></group>
<group name="frozen"><joint name="tool_joint"/></group>)");
  EXPECT_TRUE(model->has_srdf);
  EXPECT_EQ(variables(*model, "arm"), (Names{"j1", "j2"}));
  EXPECT_EQ(variables(*model, "second"), (Names{"k1"}));
  EXPECT_EQ(variables(*model, "both"), (Names{"j1", "j2", "k1"}));
  EXPECT_EQ(variables(*model, "upper"), (Names{"j2"}));
  EXPECT_EQ(variables(*model, "linked"), (Names{"j2"}));  // and the root's fixed joint
  EXPECT_EQ(variables(*model, "across"), (Names{"j1", "k1"}));
  EXPECT_EQ(variables(*model, "frozen"), Names{});
  EXPECT_EQ(variables(*model, "all"), (Names{"j1", "j2", "k1"}));
  EXPECT_EQ(model->groups.back().name, "all");
  const Group& arm = model->groups[static_cast<std::size_t>(model->findGroup("arm"))];
  EXPECT_EQ(arm.links, (std::vector<int>{model->findLink("l1"), model->findLink("l2"),
                                         model->findLink("tool")}));
}

TEST_F(Srdf, AGroupNamedAllStaysTheUsers) {
  const auto model = load(R"(<group name="all"><joint name="j1"/></group>)");
  ASSERT_EQ(model->groups.size(), 1u);
  EXPECT_EQ(variables(*model, "all"), (Names{"j1"}));
}

TEST_F(Srdf, StatesPairsAndVirtualJoint) {
  const auto model =
      load(R"(<virtual_joint name="floor" type="planar" parent_frame="odom" child_link="base"/>
<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group name="whole"><joint name="floor"/><group name="arm"/><link name="m2"/></group>
<group_state name="home" group="arm"><joint name="j2" value="0.5"/><joint name="j1" value="-3"/><joint name="tool_joint" value="0"/></group_state>
<group_state name="away" group="whole"><joint name="floor" value="1 2 0.5"/></group_state>
<disable_collisions link1="l2" link2="l1" reason="Adjacent"/>
<disable_collisions link1="l1" link2="l2" reason="Again"/>
<end_effector name="hand" parent_link="tool" group="arm"/>
<passive_joint name="k1"/>)");
  EXPECT_EQ(model->joints[0].name, "floor");
  EXPECT_EQ(model->joints[0].type, JointType::kPlanar);
  EXPECT_EQ(model->joints[0].axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(variables(*model, "whole"), (Names{"floor/x", "floor/y", "floor/theta", "j1", "j2"}));
  ASSERT_EQ(model->group_states.size(), 2u);
  const auto value = [&](const GroupState& state, const char* name) {
    for (const auto& [v, x] : state.values)
      if (v == model->findVariable(name)) return x;
    return -99.0;
  };
  EXPECT_EQ(model->group_states[0].group, "arm");
  EXPECT_EQ(model->group_states[0].values.size(), 2u);
  EXPECT_EQ(value(model->group_states[0], "j2"), 0.5);
  EXPECT_EQ(value(model->group_states[0], "j1"), -3);
  EXPECT_EQ(value(model->group_states[1], "floor/theta"), 0.5);
  ASSERT_EQ(model->disabled_pairs.size(), 1u);
  EXPECT_LT(model->disabled_pairs[0].link_a, model->disabled_pairs[0].link_b);
  EXPECT_EQ(model->disabled_pairs[0].reason, "Adjacent");
  EXPECT_TRUE(model->warnings.empty()) << model->warnings[0];
}

/// The order in which MoveIt's matrix is filled: defaults first, then enabled pairs, then disabled
/// ones.
TEST_F(Srdf, DefaultsOfLinksGiveWayToPairs) {
  const auto model = load(R"(<enable_collisions link1="m1" link2="l2"/>
<enable_collisions link1="l2" link2="tool"/>
<disable_collisions link1="tool" link2="l2" reason="Never"/>
<disable_default_collisions link="l2"/>
<disable_default_collisions link="l2"/>
<enable_collisions link1="l1" link2="base"/>)");
  const int l2 = model->findLink("l2");
  EXPECT_EQ(model->unchecked_links, std::vector<int>{l2});
  EXPECT_EQ(model->enabled_pairs,
            (std::vector<std::pair<int, int>>{
                std::minmax(model->findLink("m1"), l2),
                std::minmax(model->findLink("base"), model->findLink("l1"))}));
  std::map<std::string, std::string> reasons;
  for (const DisabledPair& pair : model->disabled_pairs) {
    EXPECT_TRUE(pair.link_a == l2 || pair.link_b == l2);
    reasons[model->links[static_cast<std::size_t>(pair.link_a == l2 ? pair.link_b : pair.link_a)]
                .name] = pair.reason;
  }
  EXPECT_EQ(reasons, (std::map<std::string, std::string>{{"tool", "Never"},
                                                         {"base", "disable_default_collisions"},
                                                         {"l1", "disable_default_collisions"},
                                                         {"m2", "disable_default_collisions"}}));
  EXPECT_TRUE(model->warnings.empty()) << model->warnings[0];
}

TEST_F(Srdf, UnknownLinksOfDefaultsAreLeftOut) {
  const auto model = load(R"(<disable_default_collisions link="l9"/>
<enable_collisions link1="l1" link2="l8"/>
<enable_collisions link1="l1" link2="l1"/>
<disable_default_collisions/>)");
  expectWarnings(*model, {":3: the link \"l8\" in <enable_collisions> is not defined",
                          ":4: <enable_collisions> names the link \"l1\" twice",
                          ":2: the link \"l9\" in <disable_default_collisions> is not defined",
                          ":5: <disable_default_collisions> has no link"});
  EXPECT_TRUE(model->disabled_pairs.empty());
}

TEST_F(Srdf, FixedVirtualJointAddsNothingToPlan) {
  EXPECT_EQ(load(R"(<virtual_joint name="v" type="fixed" parent_frame="w" child_link="base"/>)")
                ->variables.size(),
            3u);
  EXPECT_EQ(load(R"(<virtual_joint name="v" type="floating" parent_frame="w" child_link="base"/>)")
                ->variables.size(),
            10u);
}

TEST_F(Srdf, Warnings) {
  const auto model = load(R"(<disable_collisions link1="l1" link2="l9" reason="Never"/>
<disable_collisions link1="l1" link2="l1"/>
<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group_state name="far" group="arm"><joint name="j2" value="1.5"/><joint name="tool_joint" value="2"/></group_state>
<passive_joint name="j1"/><passive_joint name="q"/>
<wheel/>
<disable_collisions link1="l2" link2="l9" reason="Never"/>)");
  expectWarnings(
      *model,
      {":7: <wheel> is not known and is left out", ":5: value \"1.5\" of joint \"j2\"",
       ":5: joint \"tool_joint\" is fixed",
       ":2: the link \"l9\" in <disable_collisions> is not defined; did you mean \"l1\"?; the "
       "disabled pair is left out (and in 1 more place)",
       ":3: <disable_collisions> names the link \"l1\" twice",
       ":6: the passive joint \"j1\" is in the group \"arm\"",
       ":6: the joint \"q\" in <passive_joint> is not defined"});
}

TEST_F(Srdf, AValueThatAJointDoesNotFollowHasAWarning) {
  const auto state = [](const std::string& master, const std::string& follower) {
    return "<group name=\"pair\"><joint name=\"k1\"/><joint name=\"k2\"/></group>\n"
           "<group_state name=\"s\" group=\"pair\">" +
           master + "<joint name=\"k2\" value=\"" + follower + "\"/></group_state>";
  };
  const std::string master = "<joint name=\"k1\" value=\"0.2\"/>";
  expectWarnings(*load(state(master, "0.20001")), {});
  const std::string warning =
      ":3: joint \"k2\" follows \"k1\": its value \"0.9\" in the group "
      "state \"s\" is left out";
  expectWarnings(*load(state(master, "0.9")), {warning});
  expectWarnings(*load(state("", "0.9")), {warning});
}

/// Their names mean something else where states are asked for by name.
TEST_F(Srdf, NamesOfStatesThatReadAsValues) {
  for (const char* name : {"0 0 0", "2", "1,-0.5", "a=b", "start", "goal"})
    expectWarnings(
        *load("<group name=\"arm\"><chain base_link=\"base\" tip_link=\"tool\"/></group>\n"
              "<group_state name=\"" +
              std::string(name) +
              "\" group=\"arm\"><joint name=\"j1\" value=\"0\"/></group_state>"),
        {":3: the name \"" + std::string(name) + "\" of a group state may be read as"});
}

TEST_F(Srdf, OtherRobotIsAWarning) {
  const auto model =
      loadModel(folder_.write("r.urdf", kUrdf), folder_.write("r.srdf", "<robot name=\"other\"/>"));
  ASSERT_EQ(model->warnings.size(), 1u);
  EXPECT_NE(model->warnings[0].find("\"other\""), std::string::npos);
}

/// An SRDF with one entry that is left out, and the text of its only warning.
struct BadEntry {
  const char* name;
  std::string srdf;
  int line;
  std::initializer_list<const char*> words;
};

const std::string kArm =
    "<group name=\"arm\"><chain base_link=\"base\" tip_link=\"tool\"/></group>\n";

std::string state(const std::string& joints) {
  return kArm + "<group_state name=\"s\" group=\"arm\">" + joints + "</group_state>";
}

const BadEntry kBadEntries[] = {
    {"GroupWithoutName", "<group/>", 2, {"<group> has no name", "the group is left out"}},
    {"UnknownLink",
     "<group name=\"arm\">\n<link name=\"tol\"/></group>",
     3,
     {"link \"tol\"", "did you mean \"tool\"?", "the group \"arm\" is left out"}},
    {"UnknownJoint",
     "<group name=\"arm\">\n<joint name=\"j9\"/></group>",
     3,
     {"joint \"j9\"", "did you mean \"j1\"?", "the group \"arm\" is left out"}},
    {"UnknownTip",
     "<group name=\"arm\">\n<chain base_link=\"base\" tip_link=\"tip_of_tool\"/></group>",
     3,
     {"link \"tip_of_tool\" in <chain>", "not defined"}},
    {"NoTip",
     "<group name=\"arm\">\n<chain base_link=\"base\"/></group>",
     3,
     {"<chain> has no tip_link"}},
    {"UnknownSubgroup",
     "<group name=\"arm\">\n<group name=\"amr\"/></group>",
     3,
     {"group \"amr\"", "did you mean \"arm\"?"}},
    {"ContainsItself",
     "<group name=\"arm\">\n<group name=\"arm\"/></group>",
     3,
     {"contains itself", "\"arm\""}},
    {"UnknownMember",
     "<group name=\"arm\">\n<plane/></group>",
     3,
     {"<plane> in <group>", "chain, joint, link and group"}},
    {"StateOfUnknownGroup",
     kArm + "<group_state name=\"s\" group=\"arn\"/>",
     3,
     {"group \"arn\" in <group_state>", "did you mean \"arm\"?", "group state \"s\" is left out"}},
    {"StateWithUnknownJoint",
     state("\n<joint name=\"j3\" value=\"0\"/>"),
     4,
     {"joint \"j3\"", "did you mean"}},
    {"StateWithJointOfAnotherGroup",
     state("<joint name=\"j1\" value=\"0\"/>\n<joint name=\"k1\" value=\"0\"/>"),
     4,
     {"\"k1\" is not in the group \"arm\"", "the group state \"s\" is left out"}},
    {"StateWithRootJoint",
     state(
         "<joint name=\"j1\" value=\"0\"/>\n<joint name=\"root_joint\" value=\"0 0 1 0 0 0 1\"/>"),
     4,
     {"\"root_joint\" is not in the group \"arm\""}},
    {"StateWithNan", state("\n<joint name=\"j1\" value=\"nan\"/>"), 4, {"\"nan\"", "finite"}},
    {"StateWithTwoNumbers",
     state("\n<joint name=\"j1\" value=\"0 1\"/>"),
     4,
     {"\"0 1\"", "2 numbers; 1 would"}},
    {"StateWithTwoValues",
     state("<joint name=\"j1\" value=\"0\"/>\n<joint name=\"j1\" value=\"0\"/>"),
     4,
     {"second value", "line 3"}},
    {"UnknownVirtualJoint",
     "<virtual_joint name=\"v\" type=\"hinge\" child_link=\"base\"/>",
     2,
     {"\"hinge\"", "fixed, planar or floating", "the virtual joint \"v\" is left out"}},
    {"VirtualJointOfAnotherLink",
     "<virtual_joint name=\"v\" type=\"planar\" child_link=\"l1\"/>",
     2,
     {"\"l1\"", "root link \"base\""}},
    {"VirtualJointNamedAsAnother",
     "<virtual_joint name=\"j1\" type=\"planar\" child_link=\"base\"/>",
     2,
     {"\"j1\"", "another name"}},
    {"EndEffectorOfUnknownGroup",
     "<end_effector name=\"e\" group=\"hand\" parent_link=\"tool\"/>",
     2,
     {"group \"hand\" in <end_effector>", "the end effector \"e\" is left out"}},
    {"EndEffectorOfUnknownLink",
     kArm + "<end_effector name=\"e\" group=\"arm\" parent_link=\"toll\"/>",
     3,
     {"link \"toll\" in <end_effector>", "did you mean \"tool\"?"}},
    {"PairOfOne", "<disable_collisions link1=\"l1\"/>", 2, {"has no link2"}},
    {"PassiveJointWithoutName", "<passive_joint/>", 2, {"<passive_joint> has no name"}},
};

void PrintTo(const BadEntry& bad, std::ostream* stream) { *stream << bad.srdf; }

class SrdfEntry : public Srdf, public testing::WithParamInterface<BadEntry> {};

TEST_P(SrdfEntry, IsLeftOutWithAWarning) {
  const auto model = load(GetParam().srdf);
  ASSERT_EQ(model->warnings.size(), 1U) << testing::PrintToString(model->warnings);
  const std::string& warning = model->warnings[0];
  EXPECT_EQ(warning.rfind(folder_.path("r.srdf") + ":" + std::to_string(GetParam().line) + ": ", 0),
            0U)
      << warning;
  for (const char* word : GetParam().words)
    EXPECT_NE(warning.find(word), std::string::npos) << "no \"" << word << "\" in: " << warning;
  ASSERT_EQ(model->left_out.size(), 1U);
  EXPECT_EQ(warning.rfind(model->left_out[0].why, 0), 0U);
  EXPECT_TRUE(model->group_states.empty());
  EXPECT_TRUE(model->disabled_pairs.empty());
  EXPECT_EQ(model->joints[0].type, JointType::kFixed);
}

TEST_P(SrdfEntry, IsAnErrorWhereErrorsAreGathered) {
  InputErrors errors;
  LoadOptions options;
  options.errors = &errors;
  const auto model = load(GetParam().srdf, options);
  EXPECT_TRUE(model->warnings.empty());
  ASSERT_EQ(errors.list().size(), 1U);
  EXPECT_EQ(errors.list()[0].line(), GetParam().line);
}

INSTANTIATE_TEST_SUITE_P(Srdf, SrdfEntry, testing::ValuesIn(kBadEntries),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_F(Srdf, AllThatIsWrongWithAnEntryIsGathered) {
  InputErrors errors;
  LoadOptions options;
  options.errors = &errors;
  load("<group name=\"arm\">\n<link name=\"x\"/>\n<joint name=\"y\"/></group>", options);
  ASSERT_EQ(errors.list().size(), 2U);
  EXPECT_EQ(errors.list()[1].line(), 4);
}

TEST_F(Srdf, OthersAreKept) {
  const auto model = load(R"(<group name="bad"><joint name="nothing"/></group>
<group name="worse"><group name="bad"/></group>
<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group_state name="home" group="bad"/>
<group_state name="home" group="arm"><joint name="j1" value="1"/><joint name="j2" value="1"/></group_state>
<group_state name="away" group="arm"><joint name="k1" value="1"/></group_state>
<disable_collisions link1="l1" link2="l2"/>)");
  expectWarnings(*model, {":2: the joint \"nothing\" in <joint> is not defined",
                          ":3: the group \"bad\" in <group> is left out itself",
                          ":5: the group \"bad\" in <group_state> is left out itself",
                          ":7: joint \"k1\" is not in the group \"arm\""});
  ASSERT_EQ(model->groups.size(), 2U);
  EXPECT_EQ(variables(*model, "arm"), (Names{"j1", "j2"}));
  ASSERT_EQ(model->group_states.size(), 1U);
  EXPECT_EQ(model->disabled_pairs.size(), 1U);
  EXPECT_NE(model->whyLeftOut("group", "worse").find("r.srdf:3: the group \"bad\""),
            std::string::npos);
  EXPECT_EQ(model->whyLeftOut("group", "arm"), "");
  // A state that is left out hides another group's state of the same name only for a group to which
  // it applies.
  const std::vector<int> arm = {0, 1}, second = {2};
  EXPECT_NE(model->whyStateLeftOut("away", arm).find("r.srdf:7: "), std::string::npos);
  EXPECT_EQ(model->whyStateLeftOut("away", second), "");
  EXPECT_EQ(model->whyStateLeftOut("home", arm), "");
}

// It cannot be determined which of two is meant.
TEST_F(Srdf, TwoOfOneNameAreBothLeftOut) {
  const auto model = load(R"(<group name="g"><joint name="j1"/></group>
<group name="g"><joint name="j2"/></group>
<group name="arm"><chain base_link="base" tip_link="tool"/></group>
<group_state name="s" group="arm"><joint name="j1" value="1"/></group_state>
<group_state name="s" group="arm"><joint name="j1" value="2"/></group_state>
<virtual_joint name="v" type="planar" child_link="base"/>
<virtual_joint name="w" type="floating" child_link="base"/>
<virtual_joint name="u" type="floating" child_link="l1"/>)");
  EXPECT_EQ(model->groups.size(), 2U);  // arm and all
  EXPECT_TRUE(model->group_states.empty());
  EXPECT_EQ(model->joints[0].type, JointType::kFixed);
  EXPECT_EQ(model->left_out.size(), 7U);
  EXPECT_NE(model->whyLeftOut("group", "g").find("line 3, too"), std::string::npos);
}

TEST_F(Srdf, VirtualJointOfTheRootAmongOthers) {
  const auto model = load(R"(<virtual_joint name="u" type="floating" child_link="l1"/>
<virtual_joint name="v" type="planar" child_link="base"/>
<group name="base"><joint name="u"/></group>)");
  EXPECT_EQ(model->joints[0].name, "v");
  EXPECT_EQ(model->joints[0].type, JointType::kPlanar);
  expectWarnings(*model, {":2: the virtual joint's child_link is \"l1\"",
                          ":4: the joint \"u\" in <joint> is left out itself"});
}

TEST_F(Srdf, AGroupNamedAllThatIsLeftOutStaysTheUsers) {
  const auto model = load(R"(<group name="all"><joint name="nothing"/></group>)");
  EXPECT_EQ(model->findGroup("all"), -1);
  EXPECT_NE(model->whyLeftOut("group", "all"), "");
}

TEST_F(Srdf, Messages) {
  expectError("<group name=\"arm\">", 2, {"XML syntax error"});
  expectError("<link name=\"base\"/>", 2, {"the file is a URDF"});
  expectInputError([&] { loadModel(folder_.write("r.urdf", kUrdf), folder_.path("none.srdf")); },
                   folder_.path("none.srdf"), 0, {"no such file", "SRDF"});
  const std::string xacro = folder_.write("r.srdf.xacro", "<robot/>");
  if (std::system("command -v xacro >/dev/null") != 0)
    expectInputError([&] { loadModel(folder_.write("r.urdf", kUrdf), xacro); }, xacro, 0,
                     {"xacro " + xacro + " > " + folder_.path("r.srdf")});
}

TEST_F(Srdf, RealRobots) {
  LEEWAY_NEEDS_DATA("robots/panda");
  const std::string folder = dataFolder() + "/robots/";
  const auto panda = loadModel(folder + "panda/panda.urdf", folder + "panda/panda.srdf");
  EXPECT_EQ(variables(*panda, "panda_arm"),
            (Names{"panda_joint1", "panda_joint2", "panda_joint3", "panda_joint4", "panda_joint5",
                   "panda_joint6", "panda_joint7"}));
  EXPECT_EQ(panda->joints[0].type, JointType::kFloating);
  EXPECT_EQ(panda->disabled_pairs.size(), 34u);
  EXPECT_EQ(panda->group_states.size(), 5u);
  const auto ur5 = loadModel(folder + "ur5/ur5.urdf", folder + "ur5/ur5.srdf");
  EXPECT_EQ(variables(*ur5, "manipulator"),
            (Names{"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint",
                   "wrist_2_joint", "wrist_3_joint"}));
}

}  // namespace
}  // namespace leeway::robots
