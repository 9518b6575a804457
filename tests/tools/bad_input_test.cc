// Output for every kind of bad file: one line with file and line, what is wrong and what would be
// accepted; status 2.

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class BadInput : public CommandTest {
 protected:
  /// Plans reach.yaml with one piece of text replaced.
  void expectProblemRefused(const std::string& from, const std::string& to,
                            const std::vector<std::string>& words) const {
    write("bad.yaml", replaced(kReach, from, to));
    expectRefused("plan bad.yaml --json", words);
  }
  void expectUrdfRefused(const std::string& from, const std::string& to,
                         const std::vector<std::string>& words) const {
    write("arm.urdf", replaced(kUrdf, from, to));
    expectRefused("plan reach.yaml --json", words);
    write("arm.urdf", kUrdf);
  }
  void expectSrdfRefused(const std::string& from, const std::string& to,
                         const std::vector<std::string>& words) const {
    write("arm.srdf", replaced(kSrdf, from, to));
    expectRefused("plan reach.yaml --json", words);
    write("arm.srdf", kSrdf);
  }
  static std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
};

TEST_F(BadInput, ProblemFiles) {
  expectRefused("plan missing.yaml", {"missing.yaml"});
  expectProblemRefused("goal: left", "goal: [1, 2", {"bad.yaml:"});
  expectProblemRefused("goal: left", "gaol: left", {"bad.yaml:5:", "gaol", "goal"});
  expectProblemRefused("seed: 7", "seed: 7\nseed: 8", {"bad.yaml:10:", "seed"});
  expectProblemRefused("time: 20", "time: soon", {"bad.yaml:8:", "soon"});
  expectProblemRefused("time: 20", "time: .nan", {"bad.yaml:8:", "nan"});
  expectProblemRefused("radius: 0.05", "radius: .inf", {"bad.yaml:7:", "inf"});
  expectProblemRefused("radius: 0.05", "radius: -0.05", {"bad.yaml:7:", "-0.05"});
  expectProblemRefused("position: [0.85, 0, 0]",
                       "position: [0.85, 0, 0], orientation: [0, 0, 0, 0.9]",
                       {"bad.yaml:7:", "0.9"});
  expectProblemRefused("cylinder: {radius: 0.05, length: 1}", "mesh: {file: nowhere.stl}",
                       {"bad.yaml:7:", "nowhere.stl"});
  expectProblemRefused("start: right", "start: [9, 0]", {"bad.yaml:4:", "shoulder", "9", "-3"});
  expectProblemRefused("group: arm", "group: leg", {"bad.yaml:3:", "leg", "arm"});
  expectProblemRefused("arm.urdf", "nowhere.urdf", {"bad.yaml:3:", "nowhere.urdf"});
  expectProblemRefused("seed: 7", "planner: {name: RRTConect}",
                       {"bad.yaml:9:", "RRTConect", "RRTConnect"});
  expectProblemRefused("seed: 7", "planner: {parameters: {rnge: 1}}",
                       {"bad.yaml:9:", "rnge", "range"});
  expectProblemRefused("[0.85, 0, 0]", "[1e300, 0, 0]", {"bad.yaml:7:", "1e+300", "1000000000"});
}

/// Regression: TinyXML2 reads past a root element, and a second one was silently dropped.
TEST_F(BadInput, ASecondRobotInAFileIsRefused) {
  expectUrdfRefused("</robot>\n", "</robot>\n<robot name=\"other\"/>\n",
                    {"arm.urdf:18:", "second root element", "<robot>"});
  expectSrdfRefused("</robot>\n", "</robot>\n<group name=\"more\"/>\n",
                    {"arm.srdf:7:", "second root element", "<group>"});
}

TEST_F(BadInput, StatesGiveEachJointOnce) {
  expectRefused("check reach.yaml --state elbow=1,elbow=2 --json", {"'elbow' twice"});
  write("arm.srdf", std::string(kSrdf).insert(
                        std::string(kSrdf).find("  <group_state"),
                        "  <group_state name=\"1 0\" group=\"arm\"><joint name=\"shoulder\" "
                        "value=\"-1\"/><joint name=\"elbow\" value=\"0.2\"/></group_state>\n"));
  EXPECT_EQ(run("check reach.yaml --state '1 0' --json").document()["states"][0]["positions"],
            json({1, 0}));
  // As --start.
  for (const char* state : {"shoulder=1, elbow=0", "arm=1 0", "1, +0", "1 +0"})
    EXPECT_EQ(run("check reach.yaml --state '" + std::string(state) + "'").status, 0) << state;
  EXPECT_EQ(run("check reach.yaml --state '1,,0'").status, 2);
}

TEST_F(BadInput, UnknownStatesNameTheNearest) {
  expectRefused("check reach.yaml --state rihgt", {"'rihgt'", "did you mean 'right'?"});
  expectRefused("check reach.yaml --state gaol", {"did you mean 'goal'?"});
  expectRefused("check reach.yaml --state nowhere", {"known: start, goal, right, left"});
  expectRefused("check reach.yaml --state elbo=1", {"'elbo'", "did you mean 'elbow'?"});
  expectRefused("fk arm.urdf --srdf arm.srdf --state rihgt", {"did you mean 'right'?"});
  expectRefused("fk arm.urdf --state elbo=1", {"did you mean 'elbow'?"});
  // Numbers name nothing.
  for (const char* state : {"1", "1,2,3", "nan"}) {
    const Answer answer = run(std::string("check reach.yaml --state ") + state);
    EXPECT_EQ(answer.status, 2) << state;
    EXPECT_EQ(answer.err.find("mean"), std::string::npos) << answer.err;
    EXPECT_EQ(answer.err.find("known"), std::string::npos) << answer.err;
  }
}

/// As large as the command line's.
TEST_F(BadInput, SeedsOfFilesGoUpToTheLargest) {
  write("seed.yaml", replaced(kReach, "seed: 7", "seed: 18446744073709551615"));
  const Answer answer = run("plan seed.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.document()["seed"].get<std::uint64_t>(), 18446744073709551615U);
  expectProblemRefused("seed: 7", "seed: 18446744073709551616", {"bad.yaml:9:", "seed", "1615"});
}

TEST_F(BadInput, MarginBelowZeroIsAWarning) {
  write("warn.yaml", replaced(kReach, "seed: 7", "margin: -0.01\nseed: 7"));
  const Answer answer = run("plan warn.yaml --json");
  EXPECT_EQ(answer.status, 0);
  EXPECT_NE(answer.err.find("warning: warn.yaml:9: margin is -0.01"), std::string::npos)
      << answer.err;
}

/// JSON cannot hold invalid UTF-8, but files contain it.
TEST_F(BadInput, NamesThatAreNotUtf8AreShownSomehow) {
  write("latin.yaml", replaced(kReach, "post", "p\xF6st"));
  for (const char* verb : {"plan", "check", "batch", "info"}) {
    const bool json_flag = std::string(verb) != "batch";
    const Answer answer = run(std::string(verb) + " latin.yaml" + (json_flag ? " --json" : ""));
    EXPECT_EQ(answer.status, 0) << verb << answer.err;
    EXPECT_TRUE(json::parse(answer.out, nullptr, false).is_object()) << verb << answer.out;
  }
}

TEST_F(BadInput, Meshes) {
  write("empty.obj", "");
  expectProblemRefused("cylinder: {radius: 0.05, length: 1}", "mesh: {file: empty.obj}",
                       {"bad.yaml:7:", "empty.obj"});
  write("broken.stl", "solid broken\nfacet normal 0 0\n");
  expectProblemRefused("cylinder: {radius: 0.05, length: 1}", "mesh: {file: broken.stl}",
                       {"bad.yaml:7:", "broken.stl"});
}

TEST_F(BadInput, AlmostUnitQuaternionIsAWarning) {
  write("warn.yaml", replaced(kReach, "position: [0.85, 0, 0]",
                              "position: [0.85, 0, 0], orientation: [0, 0, 0, 0.9995]"));
  const Answer answer = run("plan warn.yaml --json");
  EXPECT_EQ(answer.status, 0);
  EXPECT_NE(answer.err.find("warning: "), std::string::npos) << answer.err;
  EXPECT_NE(answer.err.find("warn.yaml:7"), std::string::npos) << answer.err;
}

TEST_F(BadInput, Robots) {
  expectUrdfRefused("<link name=\"base\"/>", "<link name=\"base\"/>\n  <link name=\"island\"/>",
                    {"arm.urdf", "island"});
  expectUrdfRefused("<parent link=\"base\"/>", "<parent link=\"lower\"/>", {"arm.urdf"});
  expectUrdfRefused("    <limit lower=\"-3\" upper=\"3\" velocity=\"1\" effort=\"1\"/>\n", "",
                    {"arm.urdf:9:", "shoulder", "limit"});
  expectUrdfRefused("<box size=\"0.4 0.04 0.04\"/>", "<box size=\"0.4 -0.04 0.04\"/>",
                    {"arm.urdf:4:", "-0.04"});
  expectUrdfRefused("<box size=\"0.4 0.04 0.04\"/>", "<mesh filename=\"package://gone/link.stl\"/>",
                    {"arm.urdf:4:", "package://gone/link.stl"});
  expectUrdfRefused("</robot>", "", {"arm.urdf"});
  expectUrdfRefused("xyz=\"0.5 0 0\"", "xyz=\"1e200 0 0\"", {"arm.urdf:14:", "1e200", "1e9"});
  expectUrdfRefused("upper=\"2.5\"", "upper=\"1e308\"",
                    {"arm.urdf:15:", "upper", "1e308", "\"elbow\"", "1e16"});
  expectSrdfRefused("<joint name=\"elbow\"/></group>", "<link name=\"knee\"/></group>",
                    {"arm.srdf:2:", "knee"});
  expectSrdfRefused("<joint name=\"elbow\"/></group>", "<group name=\"knees\"/></group>",
                    {"arm.srdf:2:", "knees"});
}

TEST_F(BadInput, VelocityZeroIsAWarning) {
  write("arm.urdf",
        replaced(kUrdf, "upper=\"2.5\" velocity=\"1\"", "upper=\"2.5\" velocity=\"0\""));
  const Answer answer = run("check reach.yaml");
  EXPECT_EQ(answer.status, 0);
  EXPECT_NE(answer.err.find("warning: arm.urdf:15: the velocity limit \"0\" of joint \"elbow\""),
            std::string::npos)
      << answer.err;
}

TEST_F(BadInput, MoveitFiles) {
  write("scene.yaml", kScene);
  write("request.yaml", replaced(kRequest, "group_name: arm", "group_name: leg"));
  const std::string plan =
      "plan --robot arm.urdf --srdf arm.srdf --scene scene.yaml --request request.yaml";
  expectRefused(plan, {"request.yaml:1:", "leg"});
  write("request.yaml", replaced(kRequest, "joint_name: elbow", "joint_name: knee"));
  expectRefused(plan, {"request.yaml:", "knee"});
  write("request.yaml", kRequest);
  write("scene.yaml", replaced(kScene, "type: cylinder", "type: teapot"));
  expectRefused(plan, {"scene.yaml:7:", "teapot"});
}

/// Several groups may have states of one name: the one is meant that gives every planned joint.
TEST_F(BadInput, StatesOfOtherGroupsAreNotTakenInPart) {
  std::string srdf = kSrdf;
  srdf.insert(srdf.find("  <group_state"),
              "  <group name=\"first\"><joint name=\"shoulder\"/></group>\n"
              "  <group_state name=\"left\" group=\"first\"><joint name=\"shoulder\" "
              "value=\"-1\"/></group_state>\n  <group_state name=\"half\" group=\"first\"><joint "
              "name=\"shoulder\" value=\"-1\"/></group_state>\n");
  srdf.insert(srdf.find("  <group_state"),
              "  <group name=\"second\"><joint name=\"elbow\"/></group>\n  <group_state "
              "name=\"half\" group=\"second\"><joint name=\"elbow\" value=\"1\"/></group_state>\n"
              "  <group_state name=\"bent\" group=\"second\"><joint name=\"elbow\" "
              "value=\"1\"/></group_state>\n");
  write("arm.srdf", srdf);
  for (const char* verb : {"check", "fk", "ik"}) {
    const std::string call =
        std::string(verb) + " reach.yaml --json " +
        (std::string(verb) == "ik" ? "--link lower --position 0.6 0.4 0 " : "");
    expectRefused(call + "--state half", {"group state 'half' lacks joint"});
  }
  const json state = run("check reach.yaml --json --state left").document();
  EXPECT_EQ(state["states"][0]["positions"], json({1, 0.25})) << state;
  EXPECT_EQ(run("fk reach.yaml --json --state left").document()["links"],
            run("fk reach.yaml --json --state shoulder=1,elbow=0.25").document()["links"]);
  EXPECT_EQ(run("fk arm.urdf --srdf arm.srdf --json --state bent").document()["links"],
            run("fk arm.urdf --srdf arm.srdf --json --state elbow=1").document()["links"]);
}

}  // namespace
}  // namespace leeway::tools::testing
