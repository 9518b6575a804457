// Robot files as they are found: with extensions, with wrong entries that planning does not need,
// without meshes, as xacro.

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class RobotFiles : public CommandTest {
 protected:
  static std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
  }
  void expectWarned(const Answer& answer, const std::vector<std::string>& words) const {
    EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
    for (const std::string& word : words)
      EXPECT_NE(answer.err.find(word), std::string::npos)
          << "no '" << word << "' in: " << answer.err;
  }
  /// A program named `xacro`, first where programs are looked for.
  std::string withXacro(const std::string& script) const {
    write("bin/xacro", "#!/bin/sh\n" + script);
    fs::permissions(path("bin/xacro"), fs::perms::owner_all);
    return "PATH=\"$PWD/bin:$PATH\" '" + leeway::commandFile() + "' ";
  }
};

constexpr const char* kOneJoint = R"(<robot name="r"><link name="a"/><link name="b"><collision>
<origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>
)";

TEST_F(RobotFiles, AnEntryOfTheSrdfThatNobodyNeedsIsLeftOut) {
  write("arm.srdf",
        replaced(kSrdf, "<group_state name=\"left\"",
                 "<group_state name=\"up\" group=\"arm\"><joint name=\"shoulder\" "
                 "value=\"0.1\"/><joint name=\"root_joint\" value=\"0\"/></group_state>\n"
                 "  <group name=\"hand\"><joint name=\"finger\"/></group>\n"
                 "  <group_state name=\"left\""));
  const std::string state = "arm.srdf:4: joint \"root_joint\" is not in the group \"arm\"";
  const std::string group = "arm.srdf:5: the joint \"finger\" in <joint> is not defined";
  expectWarned(run("plan reach.yaml"),
               {"warning: " + state, "the group state \"up\" is left out", "warning: " + group});
  expectWarned(run("info arm.urdf --srdf arm.srdf"), {"warning: " + state});
  EXPECT_EQ(run("info arm.srdf --json").document()["robot"]["warnings"].size(), 2U);

  const Answer lint = run("lint arm.srdf reach.yaml");
  EXPECT_EQ(lint.status, 1);
  EXPECT_NE(lint.out.find("arm.srdf:4: error: joint \"root_joint\""), std::string::npos)
      << lint.out;
  EXPECT_NE(lint.out.find("arm.srdf:5: error: "), std::string::npos) << lint.out;
  EXPECT_NE(lint.out.find("2 files, 2 findings"), std::string::npos) << lint.out;

  // By name.
  write("up.yaml", replaced(kReach, "goal: left", "goal: up"));
  expectRefused("plan up.yaml",
                {"up.yaml:5: group state 'up' is not known; it is left out: " + state});
  write("hand.yaml", replaced(kReach, "group: arm", "group: hand"));
  expectRefused("plan hand.yaml",
                {"hand.yaml:3: ", "no group or joint 'hand'; it is left out: " + group});
  const std::string robot = "--robot arm.urdf --srdf arm.srdf ";
  const std::vector<std::pair<std::string, std::string>> asked = {
      {"plan " + robot + "--group arm --start up --goal left", state},
      {"plan " + robot + "--group hand --start left --goal right", group},
      {"fk reach.yaml --state up", state},
      {"check reach.yaml --state up", state},
      {"fk arm.urdf --srdf arm.srdf --state up", state},
      {"ik arm.srdf --group hand --link lower --position 0 0 0", group},
      {"check " + robot + "--group hand --state 0", group}};
  for (const auto& [command, why] : asked) {
    const Answer refused = run(command);
    EXPECT_EQ(refused.status, 2) << command << refused.out;
    EXPECT_NE(refused.err.find("it is left out: " + why), std::string::npos) << command << "\n"
                                                                             << refused.err;
  }
}

TEST_F(RobotFiles, ExtensionsOfTheUrdfAreLeftOut) {
  write("arm.urdf", replaced(replaced(kUrdf, "<box size=\"0.4 0.04 0.04\"/>",
                                      "<box size=\"0.4 0.04 0.04\"/><drake:declare_convex/>"),
                             "effort=\"1\"/>", "effort=\"1\" drake:acceleration=\"5\"/>"));
  expectWarned(run("plan reach.yaml"), {"arm.urdf:4: <drake:declare_convex>",
                                        "arm.urdf:11: <limit> has the unknown attribute"});
  const Answer lint = run("lint arm.urdf");
  EXPECT_EQ(lint.status, 1);
  EXPECT_NE(lint.out.find("arm.urdf:11: error: "), std::string::npos) << lint.out;
}

TEST_F(RobotFiles, LimitsThatLeaveNothingAreFound) {
  write("still.urdf", replaced(kOneJoint, "lower=\"-1\" upper=\"1\" ", ""));
  const Answer lint = run("lint still.urdf");
  EXPECT_EQ(lint.status, 1);
  EXPECT_NE(lint.out.find("still.urdf:4: warning: joint \"j\" cannot move"), std::string::npos)
      << lint.out;
  expectWarned(run("info still.urdf"), {"joint \"j\" cannot move"});
}

TEST_F(RobotFiles, SoftLimitsAreNamedAndThoseOfMimicJointsUsed) {
  write("soft.urdf", replaced(kOneJoint, "velocity=\"1\"/>",
                              "velocity=\"1\"/>\n<safety_controller soft_lower_limit=\"-0.5\" "
                              "soft_upper_limit=\"0.5\" k_velocity=\"1\"/>"));
  write("soft.yaml",
        "leeway: 1\nrobot: {urdf: soft.urdf}\nstart: [0]\ngoal: [0.9]\n"
        "objects: [{name: ball, position: [-3, 0, 0], sphere: {radius: 0.1}}]\n");
  expectWarned(run("plan soft.yaml"),
               {"soft.urdf:5: soft limits are not used, joints move within their <limit>: \"j\""});
  write("mimic.urdf",
        replaced(
            kOneJoint, "</joint>",
            "</joint>\n<link name=\"c\"/><joint name=\"f\" type=\"revolute\"><parent link=\"a\"/>"
            "<child link=\"c\"/><limit lower=\"0\" upper=\"0.4\" effort=\"1\" velocity=\"1\"/>"
            "<mimic joint=\"j\"/></joint>"));
  write("mimic.yaml", "leeway: 1\nrobot: {urdf: mimic.urdf}\nstart: [0]\ngoal: [0.7]\n");
  expectRefused("plan mimic.yaml",
                {"mimic.yaml:4: ", "0.7", "0 to 0.4", "joint \"f\"", "mimic.urdf:5"});
  EXPECT_NE(run("info mimic.urdf").out.find("j: narrowed by the limits of joint \"f\""),
            std::string::npos);
}

TEST_F(RobotFiles, AnyOfAVastRangeNamesTheLimits) {
  write("wide.urdf",
        replaced(kOneJoint, "lower=\"-1\" upper=\"1\"", "lower=\"-1e16\" upper=\"1e16\""));
  write("wide.yaml", "leeway: 1\nrobot: {urdf: wide.urdf}\nstart: [0]\ngoal: [any]\n");
  expectRefused("plan wide.yaml",
                {"wide.yaml:4: ", "'any'", "limits of joint 'j' are -1e+16 to 1e+16"});
}

TEST_F(RobotFiles, VisualShapesStandInByOption) {
  write("visual.urdf",
        replaced(replaced(kOneJoint, "<collision>", "<visual>"), "</collision>", "</visual>"));
  write("visual.yaml",
        "leeway: 1\nrobot: {urdf: visual.urdf, visual_as_collision: true}\nstart: [-1]\ngoal: [1]\n"
        "objects: [{name: room, box: {size: [10, 10, 10]}}]\n");
  const std::string warning =
      "the <visual> shapes of links without <collision> stand in for it: \"b\"";
  const Answer answer = run("plan visual.yaml --time 1");
  EXPECT_EQ(answer.status, 1) << answer.out;  // in the room's middle
  EXPECT_NE(answer.err.find(warning), std::string::npos) << answer.err;
  expectWarned(run("info visual.urdf --visual-as-collision"), {warning});
  EXPECT_EQ(run("info visual.urdf --visual-as-collision --json").document()["geometries"].size(),
            1U);
}

TEST_F(RobotFiles, KinematicsNeedNoMeshes) {
  write("gone.urdf", replaced(kOneJoint, "<sphere radius=\"0.1\"/>",
                              "<mesh filename=\"package://gone/b.stl\"/>"));
  const Answer fk = run("fk gone.urdf --link b --state 0.5 --json");
  EXPECT_EQ(fk.status, 0) << fk.err;
  EXPECT_EQ(fk.err, "");
  write("gone.yaml", "leeway: 1\nrobot: {urdf: gone.urdf}\nstart: [0]\ngoal: [1]\n");
  EXPECT_EQ(run("fk gone.yaml --link b").status, 0);
  for (const char* file : {"gone.urdf", "gone.yaml"}) {
    const std::string ask = "ik " + std::string(file) + " --link b --position 0 0 0 --rpy 0 0 0.5 ";
    const Answer ik = run(ask + "--json");
    EXPECT_EQ(ik.status, 1);  // none is known to keep the margins
    EXPECT_NE(ik.err.find("gone.urdf:2: the mesh"), std::string::npos) << ik.err;
    EXPECT_NE(ik.err.find("solutions are not checked for collisions"), std::string::npos) << ik.err;
    const json document = ik.document();
    EXPECT_EQ(document["status"], "nothing_checked");
    EXPECT_NEAR(document["solutions"][0]["positions"][0], 0.5, 1e-6);
    EXPECT_FALSE(document["solutions"][0]["free"]);
    EXPECT_TRUE(document["solutions"][0]["clearance_lower"].is_null());
    EXPECT_NE(run(ask).out.find("not checked for collisions"), std::string::npos);
    expectRefused(ask + "--order clearance", {"gone.urdf:2: the mesh"});
  }
  for (const char* verb : {"info gone.urdf", "check gone.yaml", "plan gone.yaml"})
    expectRefused(verb, {"gone.urdf:2: the mesh \"package://gone/b.stl\" was not found"});
  // An error that has nothing to do with meshes is reported.
  write("bad.urdf", replaced(read("gone.urdf"), "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>"));
  expectRefused("ik bad.urdf --link b --position 0 0 0", {"bad.urdf:3: the axis"});
}

TEST_F(RobotFiles, XacroGetsArguments) {
  write("arm.urdf.xacro", "<robot/>");
  // If a name has two values, xacro takes the last.
  const std::string leeway = withXacro(
      "[ $# -gt 1 ] || { echo 'error: undefined argument length' >&2; echo ' in arm' >&2; exit 1; "
      "}\n"
      "echo '<robot name=\"made\"><link name=\"'\"$*\"'\"/><link name=\"b\"/><joint name=\"j\" "
      "type=\"continuous\"><parent link=\"'\"$*\"'\"/><child link=\"b\"/></joint></robot>'\n");
  const std::string info = leeway + "info arm.urdf.xacro --json ";
  const auto root = [&](const std::string& line) {
    const Answer answer = shell(line);
    EXPECT_EQ(answer.status, 0) << line << answer.err;
    return answer.document()["links"][0]["link"].get<std::string>();
  };
  EXPECT_EQ(root(leeway + "fk arm.urdf.xacro --xacro length:=0.5 --xacro 'name:=a b' --json"),
            "arm.urdf.xacro length:=0.5 name:=a b");
  const Answer failed = shell(info);
  EXPECT_EQ(failed.status, 2);
  EXPECT_NE(failed.err.find("xacro cannot expand it: error: undefined argument length | in arm;"),
            std::string::npos)
      << failed.err;
  write("x.yaml",
        "leeway: 1\nrobot: {urdf: arm.urdf.xacro, xacro: {prefix: \"\", length: 0.5, on: "
        "true}}\nstart: [0]\n"
        "goal: [1]\n");
  const std::string arguments = root(leeway + "fk x.yaml --xacro on:=false --json");
  EXPECT_TRUE(arguments.ends_with("arm.urdf.xacro prefix:= length:=0.5 on:=true on:=false"))
      << arguments;
  for (const auto& [command, word] :
       {std::pair("info arm.urdf --xacro a:=1", "arm.urdf: is no xacro file"),
        std::pair("info arm.urdf.xacro --xacro a=1", "--xacro 'a=1' is not NAME:=VALUE"),
        std::pair("info arm.urdf.xacro --xacro -o:=file", "\"-o\" is no name")}) {
    const Answer refused = shell(leeway + command);
    EXPECT_EQ(refused.status, 2) << command;
    EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err;
  }
}

TEST_F(RobotFiles, AllJointsArePlannedUnlessSomeAreNamed) {
  write("one.urdf", kOneJoint);
  const Answer answer = run("plan --robot one.urdf --start 0 --goal 1 --json");
  EXPECT_NE(answer.status, 2) << answer.err;
  expectRefused("plan --robot one.urdf --start 0", {"--robot without --goal, --goal-pose"});
  expectRefused("plan --robot one.urdf --goal 1", {"--robot without --start (or"});
  expectRefused("plan --robot one.urdf", {"--robot without --start and --goal, --goal-pose"});
  expectRefused("fk one.urdf --robot one.urdf", {"are two robots; one is expected"});
}

TEST_F(RobotFiles, AChainIsPlannedBetweenJointValues) {
  write("arm.urdf", replaced(kUrdf, "<link name=\"base\"/>",
                             "<link name=\"base\"><collision><origin xyz=\"-0.8 0 0\"/><geometry>"
                             "<sphere radius=\"0.1\"/></geometry></collision></link>"));
  const std::string robot = "--robot arm.urdf --chain base lower ";
  const std::string ends = "--start '-1 0' --goal '1, 0.25' ";
  const Answer plan = run("plan " + robot + ends + "--output p.json --json");
  EXPECT_EQ(plan.status, 0) << plan.out << plan.err;
  EXPECT_EQ(plan.document()["path"]["joint_names"], json({"shoulder", "elbow"}));
  const Answer verify = run("verify " + robot + ends + "p.json");
  EXPECT_EQ(verify.status, 0) << verify.out << verify.err;
  EXPECT_EQ(run("check " + robot + "--state '-1,0'").status, 0);
  const Answer part = run("plan --robot arm.urdf --chain upper lower --start 0.5 --goal -1 --json");
  EXPECT_EQ(part.status, 0) << part.out << part.err;
  EXPECT_EQ(part.document()["path"]["joint_names"], json({"elbow"}));
  // As a group of the SRDF.
  EXPECT_EQ(
      run("plan --robot arm.urdf --srdf arm.srdf --group arm --start '-1 0' --goal left").status,
      0);
  for (const auto& [arguments, words] : std::vector<std::pair<std::string, std::string>>{
           {"--chain base lowr " + ends, "no link 'lowr'; did you mean 'lower'?"},
           {"--chain lower lower " + ends, "no joint between"},
           {"--chain base lower --group all " + ends, "--group and --chain"},
           {"--chain base lower --start '1 2 3' --goal '0 0'",
            "start '1 2 3' is 3 numbers; 2 are expected, of shoulder, elbow"},
           {"--chain base lower --start '0 0' --goal '9 0'", "goal has joint 'shoulder' at 9"},
           {"--chain base lower --start '0 nan' --goal '0 0'", "no group state '0 nan'"},
           {"--chain base lower --start '0 0'", "--goal"}})
    expectRefused("plan --robot arm.urdf " + arguments, {words});
  expectRefused("plan reach.yaml --chain base lower", {"reach.yaml names its robot"});
}

TEST_F(RobotFiles, ARobotInWhichNothingMovesIsDescribed) {
  write("box.urdf",
        "<robot name=\"box\"><link name=\"a\"><collision><geometry><sphere radius=\"1\"/>"
        "</geometry></collision></link></robot>");
  const Answer text = run("info box.urdf");
  EXPECT_EQ(text.status, 0) << text.err;
  EXPECT_NE(text.out.find("no joint can move"), std::string::npos) << text.out;
  const json document = run("info box.urdf --json").document();
  EXPECT_EQ(document["geometries"].size(), 1U);
  EXPECT_TRUE(document["compiled"].is_null());
}

TEST_F(RobotFiles, UrdfdomPrintsNothing) {
  write("tab.urdf", replaced(kOneJoint, "xyz=\"0 0 1\"", "xyz=\"0\t0 1\""));
  const Answer tab = run("info tab.urdf");
  EXPECT_EQ(tab.status, 0);
  EXPECT_EQ(tab.err, "");
  write("version.urdf", replaced(kOneJoint, "name=\"r\"", "name=\"r\" version=\"3.0\""));
  expectRefused("info version.urdf", {"urdfdom refuses this file: ", "version"});
}

/// `hub` is inside `base` wherever its two joints stand; `rest` touches `base` with all joints at
/// zero; `neck` and `rest` can never meet; `far` meets others now and then.
std::string touchingUrdf() {
  std::string text = "<robot name=\"touching\">\n";
  const auto link = [&](const char* name, const char* radius, const char* x) {
    text += std::string("<link name=\"") + name + "\"><collision><origin xyz=\"" + x +
            " 0 0\"/><geometry><sphere radius=\"" + radius + "\"/></geometry></collision></link>\n";
  };
  const auto joint = [&](const char* parent, const char* child, const char* type, const char* xyz) {
    text += std::string("<joint name=\"to_") + child + "\" type=\"" + type + "\"><parent link=\"" +
            parent + "\"/><child link=\"" + child + "\"/><origin xyz=\"" + xyz +
            "\"/><axis xyz=\"" + (std::string(type) == "prismatic" ? "1 0 0" : "0 0 1") +
            "\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\n";
  };
  link("base", "0.1", "0");
  link("neck", "0.05", "0");
  link("hub", "0.02", "0");
  link("rest", "0.05", "-0.06");
  link("far", "0.05", "0");
  link("plate", "0.05", "0");
  joint("base", "neck", "revolute", "0 0 0");
  joint("neck", "hub", "revolute", "0 0 0");
  joint("hub", "rest", "revolute", "0.2 0 0");
  joint("base", "far", "prismatic", "0.5 0 0");
  joint("base", "plate", "fixed", "-0.2 0 0");
  return text + "</robot>\n";
}

TEST_F(RobotFiles, WhatIsTooNearNamesTheMargin) {
  write("one.urdf", kOneJoint);
  write("one.yaml",
        "leeway: 1\nrobot: {urdf: one.urdf}\nstart: [0]\ngoal: [1]\nmargin: 0.03\n"
        "objects: [{name: ball, position: [0.8, 0, 0], sphere: {radius: 0.19}}]\n");
  const Answer near = run("plan one.yaml");
  EXPECT_EQ(near.status, 1);
  EXPECT_NE(near.out.find("The start is too near: b and ball, 10"), std::string::npos) << near.out;
  EXPECT_NE(near.out.find("; more than 30 mm is required.\n"), std::string::npos) << near.out;
  EXPECT_EQ(run("plan one.yaml --json").document()["offending"]["margin"], 0.03);
}

TEST_F(RobotFiles, EmptyValuesOfStatesNameTheirPlace) {
  write("one.urdf", kOneJoint);
  expectRefused("plan --robot one.urdf --group j --start 0, --goal 1",
                {"value 2 of start '0,' is empty"});
  expectRefused("fk one.urdf --state ,", {"--state ','"});
  write("t.urdf", touchingUrdf());
  expectRefused("fk t.urdf --state 0,,0,0", {"value 2 of --state '0,,0,0' is empty"});
}

TEST_F(RobotFiles, AutoAllowsWhatTouchesAtRest) {
  write("t.urdf", touchingUrdf());
  const std::string plan = "plan --robot t.urdf --chain base rest --start 0,0,0 --goal 1,0,0 ";
  const Answer refused = run(plan);
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.out.find("All 2 pairs that are too near there: hub and base; rest and base."),
            std::string::npos)
      << refused.out;
  EXPECT_NE(refused.out.find(
                "Too near in nearly all random configurations: hub and base.\nIf they may touch"),
            std::string::npos)
      << refused.out;
  EXPECT_NE(
      refused.out.find("They touch at rest (zero, or MJCF's qpos0) as well: hub and base; rest and "
                       "base.\nIf they may touch, wherever the joints are: --allowed auto"),
      std::string::npos)
      << refused.out;
  const json offending = run(plan + "--json").document()["offending"];
  EXPECT_EQ(offending["pairs"], json::parse(R"([["hub", "base"], ["rest", "base"]])"));
  const Answer check = run("check --robot t.urdf --chain base rest --state 0,0,0");
  EXPECT_NE(check.out.find("all 2 pairs that are too near: hub and base; rest and base"),
            std::string::npos)
      << check.out;

  const std::string what =
      "'auto' allows 2 pairs of links, which touch with all joints at zero (MJCF: qpos0), or at "
      "the nearest "
      "limit: base and hub; base and rest";
  const Answer solved = run(plan + "--allowed auto --json --output path.json");
  expectWarned(solved, {"warning: " + what});
  EXPECT_NE(solved.document()["certificate"]["not_checked"].dump().find("allowed by the problem"),
            std::string::npos)
      << solved.out;
  EXPECT_EQ(run("verify --robot t.urdf --chain base rest --start 0,0,0 --goal 1,0,0 --allowed auto "
                "path.json")
                .status,
            0);
  const std::string text =
      "leeway: 1\nrobot: {urdf: t.urdf}\nstart: [0, 0, 0, 0]\n"
      "goal: [1, 0, 0, 0]\nallowed: ";
  write("auto.yaml", text + "auto\n");
  write("list.yaml", text + "[[far, plate], auto]\n");
  for (const char* file : {"auto.yaml", "list.yaml"})
    expectWarned(run(std::string("plan ") + file), {std::string(file) + ":5: " + what});
  write("but.yaml", text + "auto\nchecked: [[rest, base]]\n");
  const Answer but = run("plan but.yaml");
  EXPECT_EQ(but.status, 1) << but.out << but.err;
  EXPECT_NE(but.err.find("but.yaml:5: 'auto' allows a pair of links, which touch with all joints "
                         "at zero (MJCF: qpos0), or at the nearest limit: base and hub\n"),
            std::string::npos)
      << but.err;
  EXPECT_NE(but.out.find("rest and base"), std::string::npos) << but.out;
  write("wrong.yaml", text + "all\n");
  expectRefused("plan wrong.yaml",
                {"wrong.yaml:5: ", "allowed is 'all'; 'auto' or a list of pairs is expected"});
  expectRefused(plan + "--allowed all", {"--allowed", "auto"});
}

TEST_F(RobotFiles, SrdfProposesPairs) {
  write("t.urdf", touchingUrdf());
  const Answer answer = run("srdf t.urdf --json --output t.srdf");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  const json& counts = document["counts"];
  EXPECT_EQ(counts["adjacent"], 4);
  EXPECT_EQ(counts["rigid"], 1);
  EXPECT_EQ(counts["always"], 1);
  EXPECT_EQ(counts["rest"], 1);
  EXPECT_GE(counts["never"], 2);
  EXPECT_GE(counts["sometimes"], 2);
  EXPECT_EQ(document["pairs"].size(), 15U);
  int proposed = 0;
  json whys;
  for (const json& pair : document["pairs"]) {
    whys[pair["a"].get<std::string>() + " " + pair["b"].get<std::string>()] = pair["why"];
    EXPECT_EQ(pair["proposed"], pair["why"] != "sometimes" && pair["why"] != "never_sampled");
    proposed += pair["proposed"].get<bool>() ? 1 : 0;
  }
  EXPECT_EQ(whys["base hub"], "always");
  EXPECT_EQ(whys["base rest"], "rest");
  EXPECT_EQ(whys["neck rest"], "never");
  EXPECT_EQ(whys["neck far"], "sometimes");
  // What is written is what is read.
  EXPECT_EQ(run("info t.urdf --srdf t.srdf --json").document()["robot"]["disabled_pairs"],
            proposed);
  EXPECT_EQ(
      run("plan --robot t.urdf --srdf t.srdf --chain base rest --start 0,0,0 --goal 1,0,0").status,
      0);
  EXPECT_NE(read("t.srdf").find("link1=\"base\" link2=\"hub\" reason=\"Always\"/>  <!-- touch "
                                "always (proven); in 1000 of 1000 samples -->"),
            std::string::npos)
      << read("t.srdf");
  const std::string first = read("t.srdf");
  run("srdf t.urdf --output t.srdf");
  EXPECT_EQ(read("t.srdf"), first);

  const std::string text = run("srdf t.urdf --output pairs.yaml").out;
  EXPECT_EQ(text.find(std::to_string(proposed) + " of 15 pairs of links need no check"), 0U)
      << text;
  EXPECT_EQ(read("pairs.yaml").find("allowed:\n  - [\"base\", \"hub\"]  # touch always"), 0U)
      << read("pairs.yaml");
  write("p.yaml", "leeway: 1\nrobot: {urdf: t.urdf}\nstart: [0, 0, 0, 0]\ngoal: [1, 0, 0, 0]\n" +
                      read("pairs.yaml"));
  EXPECT_EQ(run("plan p.yaml").status, 0);

  write("one.urdf", "<robot name=\"one\"><link name=\"a\"/></robot>");
  expectRefused("srdf one.urdf", {"one.urdf", "no joint can move"});
  expectRefused("srdf t.urdf --srdf t.srdf", {"without an SRDF"});
  expectRefused("srdf t.srdf", {"one URDF, MJCF or SDF file"});
  expectRefused("srdf t.urdf --output t.txt", {"t.txt", ".srdf"});
}

/// A pair that samples never saw touching is proposed only where a user asks for it.
TEST_F(RobotFiles, SrdfLeavesSampledPairsChecked) {
  // `far` reaches `plate` in a share of 1e-4 of its range.
  std::string text = touchingUrdf();
  text = replaced(text, "<origin xyz=\"0.5 0 0\"/>", "<origin xyz=\"2 0 0\"/>");
  text = replaced(text, "xyz=\"-0.2 0 0\"", "xyz=\"-0.0997 0 0\"");
  write("t.urdf", text);
  const auto whyOf = [&](const std::string& options) {
    const json document = run("srdf t.urdf --json --samples 100 " + options).document();
    for (const json& pair : document["pairs"])
      if (pair["a"] == "far" && pair["b"] == "plate") return pair;
    return json();
  };
  EXPECT_EQ(whyOf("")["why"], "never_sampled");
  EXPECT_EQ(whyOf("")["proposed"], false);
  EXPECT_EQ(whyOf("--sampled")["proposed"], true);
}

}  // namespace
}  // namespace leeway::tools::testing
