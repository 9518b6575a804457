#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Lint : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("odd.yaml", std::string(kReach) + "margin: -0.01\n");
    std::string wrong = kReach;
    write("wrong.yaml", wrong.replace(wrong.find("goal"), 4, "gaol"));
    write("contact.yaml", kInvalidStart);
  }
};

TEST_F(Lint, NothingOddIsStatus0) {
  const Answer answer = run("lint reach.yaml arm.urdf arm.srdf");
  EXPECT_EQ(answer.status, 0) << answer.out;
  EXPECT_EQ(answer.out, "3 files, 0 findings\n");
  EXPECT_EQ(answer.err, "");
}

TEST_F(Lint, FindingsHaveFileLineAndLevel) {
  const Answer answer = run("lint odd.yaml wrong.yaml contact.yaml nowhere.urdf notes.doc");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.err, "");
  for (const char* line : {"odd.yaml:10: warning: margin is -0.01", "wrong.yaml:5: error: ",
                           "'gaol'", "contact.yaml: warning: start: lower and post collide\n",
                           "nowhere.urdf: error: ", "notes.doc: error: ", "5 files, 5 findings\n"})
    EXPECT_NE(answer.out.find(line), std::string::npos) << line << "\n" << answer.out;
  const json document = run("lint odd.yaml --json").document();
  EXPECT_EQ(document["status"], "findings");
  EXPECT_EQ(document["findings"][0]["file"], "odd.yaml");
  EXPECT_EQ(document["findings"][0]["line"], 10);
}

/// A warning about a robot as a whole names the robot's file, once, and the line of the link.
TEST_F(Lint, WarningsOfTheRobotNameItsFile) {
  write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  std::string urdf = kUrdf;
  urdf.replace(urdf.find("<box size"), std::string("<box size=\"0.4 0.04 0.04\"/>").size(),
               "<mesh filename=\"open.obj\" scale=\"0.01 0.01 0.01\"/>");
  write("open.urdf", urdf);
  std::string text = kReach;
  write("open.yaml", text.replace(text.find("arm.urdf"), 8, "open.urdf"));
  const Answer answer = run("lint open.yaml");
  EXPECT_NE(answer.out.find("open.urdf:3: warning: a mesh is not closed: upper"), std::string::npos)
      << answer.out;
  EXPECT_EQ(answer.out.find("warning: open.urdf"), std::string::npos) << answer.out;
  text = kReach;
  write("open.yaml",
        text.replace(text.find("limits"), 0,
                     "  - {name: shell, position: [0, -2, 0], mesh: {file: open.obj}}\n"));
  const json finding = run("lint open.yaml --json").document()["findings"][0];
  EXPECT_EQ(finding["file"], "open.yaml");
  EXPECT_EQ(finding["message"].get<std::string>().rfind("a mesh is not closed: shell", 0), 0U);
}

TEST_F(Lint, AMarginWithoutEffectIsToldByEveryVerb) {
  write("idle.yaml", std::string(kReach) + "margins: [{between: [upper, lower], margin: 0.1}]\n");
  const std::string words =
      "the margin of 'upper' and 'lower' has no effect: the pair is not checked (adjacent)";
  EXPECT_EQ(run("plan idle.yaml --output path.csv").status, 0);
  for (const char* verb :
       {"plan idle.yaml", "verify idle.yaml path.csv", "clearance idle.yaml path.csv",
        "check idle.yaml --state start", "info idle.yaml"}) {
    const Answer answer = run(verb);
    EXPECT_EQ(answer.status, 0) << verb << answer.err;
    EXPECT_NE(answer.err.find(words), std::string::npos) << verb << "\n" << answer.err;
  }
  const Answer lint = run("lint idle.yaml");
  EXPECT_NE(lint.out.find("idle.yaml: warning: " + words), std::string::npos) << lint.out;
  // Where one pair of a group is checked, the margin has an effect.
  write("whole.yaml", std::string(kReach) + "margins: [{between: [robot, post], margin: 0.01}]\n");
  EXPECT_EQ(run("check whole.yaml --state start").err, "");
}

TEST_F(Lint, LimitsThatLookLikeDegreesAreOdd) {
  const std::string robot =
      "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"><collision><geometry><sphere "
      "radius=\"0.1\"/></geometry></collision></link><joint name=\"j\" type=\"revolute\"><parent "
      "link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/><limit upper=\"6.3\" velocity=\"1\" "
      "effort=\"1\" lower=\"";
  write("turns.urdf", robot + "-12.566370614359172\"/></joint></robot>");
  write("degrees.urdf", robot + "-180\"/></joint></robot>");
  const Answer answer = run("lint turns.urdf degrees.urdf");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.out,
            "2 files, 1 finding\ndegrees.urdf: warning: joint 'j' has limits of -180 to 6.3 rad, "
            "more than two turns: they look like degrees; radians are expected\n");
}

TEST_F(Lint, LooksAtConstraints) {
  const std::string keep =
      "constraints: [{name: ahead, frame: lower, axis: [1, 0, 0], direction: [0, 1, 0], "
      "angle: 0.1}]\n";
  write("tilted.yaml", std::string(kReach) + keep);
  const Answer lint = run("lint tilted.yaml"), plan = run("plan tilted.yaml --json");
  EXPECT_EQ(lint.status, 1);
  EXPECT_NE(lint.out.find("start: " + plan.document()["reason"].get<std::string>()),
            std::string::npos)
      << lint.out << plan.out;
}

TEST_F(Lint, LooksForGoalsInWhichConstraintsHold) {
  std::string text = kReach;
  const std::size_t at = text.find("goal: ");
  text.erase(at, text.find('\n', at) + 1 - at);
  const auto lint = [&](const std::string& goal, double angle) {
    write("held.yaml", text + goal +
                           "constraints: [{name: ahead, frame: lower, axis: [1, 0, 0], direction: "
                           "[0, 0, 1], angle: " +
                           std::to_string(angle) + "}]\n");
    const std::string out = run("lint held.yaml").out;
    return out.find("goal") == std::string::npos ? std::string() : out;
  };
  for (const char* goal : {"goal: {shoulder: [1.2, 1.4], elbow: [1, 1.2]}\n",
                           "goal: {pose: {frame: lower, position: [0.4, 0.3, 0]}}\n"}) {
    EXPECT_NE(lint(goal, 0.05).find("ahead"), std::string::npos)
        << goal << run("lint held.yaml").out;
    EXPECT_EQ(lint(goal, 3.1), "") << goal;
  }
}

TEST_F(Lint, ControlCharactersOfNamesDoNotReachTheTerminal) {
  std::string text = kReach;
  text.replace(text.find("{name: post, position: [0.85, 0, 0]"), 35,
               "{name: \"a\\e[31mb\", position: [0.6, -0.6, 0]");
  write("escape.yaml", text + "margin: 1\n");
  for (const char* verb : {"lint escape.yaml", "check escape.yaml"}) {
    const Answer answer = run(verb);
    EXPECT_EQ((answer.out + answer.err).find('\x1b'), std::string::npos) << verb;
    EXPECT_NE((answer.out + answer.err).find("a\\x1b[31mb"), std::string::npos) << verb;
  }
}

TEST_F(Lint, TellsEveryErrorOfAFile) {
  std::string urdf = kUrdf;
  urdf.replace(urdf.find("size=\"0.4"), 9, "size=\"none");
  urdf.replace(urdf.find("velocity=\"1\""), 12, "velocity=\"x\"");
  write("bad.urdf", urdf);
  write("bad.yaml", R"(leeway: 1
robot: {urdf: bad.urdf}
objects:
  - {name: one, box: {size: [1, 2]}}
  - {name: two, ball: {radius: 1}}
  - {name: three, sphere: {radius: -1}}
start: home
limits: {time: never}
sead: 1
)");
  const Answer answer = run("lint bad.urdf bad.yaml");
  EXPECT_EQ(answer.status, 1);
  for (const char* line : {"bad.urdf:", "size of <box> holds \"none\"",
                           "bad.urdf:11: error: velocity of <limit> holds \"x\"",
                           "bad.yaml:9: error: unknown key 'sead'",
                           "bad.yaml:4: error: ", "bad.yaml:5: error: ", "bad.yaml:6: error: ",
                           "bad.yaml:8: error: limits.time is 'never'", "2 files, 8 findings\n"})
    EXPECT_NE(answer.out.find(line), std::string::npos) << line << "\n" << answer.out;
}

TEST_F(Lint, EndsAtAHundredErrors) {
  std::string text = std::string(kReach);
  for (int i = 0; i < 200; ++i) text += "no_key_" + std::to_string(i) + ": 1\n";
  write("many.yaml", text);
  const Answer answer = run("lint many.yaml");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.out.find("has more errors than are told"), std::string::npos) << answer.out;
  EXPECT_NE(answer.out.find("1 file, 101 findings\n"), std::string::npos) << answer.out;
}

TEST_F(Lint, TextScenesNeedNoRobot) {
  write("shelf.scene", "shelf\n* board\n1\nbox\n1 1 0.1\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n");
  EXPECT_EQ(run("lint shelf.scene").out, "1 file, 0 findings\n");
  write("wrong.scene", "shelf\n* board\n1\nteapot\n1 1 0.1\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n");
  const Answer answer = run("lint wrong.scene");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.out.find("wrong.scene:4: error: "), std::string::npos) << answer.out;
}

TEST_F(Lint, WishesOfPairsThatMayTouchAreOdd) {
  write("wish.yaml", std::string(kReach) +
                         "margins: [{between: [upper, lower], wish: 0.1}, "
                         "{between: [lower, post], wish: 0.1}]\n");
  const Answer answer = run("lint wish.yaml");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.out,
            "1 file, 1 finding\n"
            "wish.yaml: warning: wish of 0.1 m between upper and lower: none of its pairs is "
            "checked\n");
}

/// What a robot is warned of is found once.
TEST_F(Lint, FilesThatShareARobotFindItsOdditiesOnce) {
  std::string urdf = kUrdf;
  write("arm.urdf", urdf.replace(urdf.find("velocity=\"1\""), 12, "velocity=\"0\""));
  const Answer answer = run("lint reach.yaml empty.yaml");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.out.find("arm.urdf:11: warning: the velocity limit"), std::string::npos)
      << answer.out;
  EXPECT_NE(answer.out.find("2 files, 1 finding\n"), std::string::npos) << answer.out;
}

TEST_F(Lint, ScenesAreReadWithTheirRequests) {
  write("scene0001.yaml", kScene);
  write("request0001.yaml", kRequest);
  const std::string robot = "lint --robot arm.urdf --srdf arm.srdf ";
  EXPECT_EQ(run(robot + "scene0001.yaml").status, 0) << run(robot + "scene0001.yaml").out;
  std::string scene = kScene;
  write("scene0001.yaml", scene.replace(scene.find("cylinder"), 8, "teapot"));
  const Answer answer = run(robot + "scene0001.yaml");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.out.find("scene0001.yaml:7: error: "), std::string::npos) << answer.out;
}

TEST_F(Lint, SarifNamesEveryPlace) {
  write("with space.yaml", read("odd.yaml"));
  const json document = run("lint 'with space.yaml' wrong.yaml --format sarif").document();
  EXPECT_EQ(document["version"], "2.1.0");
  const json results = document["runs"][0]["results"];
  ASSERT_EQ(results.size(), 2u);
  const json place = results[0]["locations"][0]["physicalLocation"];
  EXPECT_EQ(place["artifactLocation"]["uri"], "with%20space.yaml");
  EXPECT_EQ(place["region"]["startLine"], 10);
  EXPECT_EQ(results[0]["level"], "warning");
  EXPECT_EQ(results[1]["level"], "error");
}

}  // namespace
}  // namespace leeway::tools::testing
