// check, verify and clearance.

#include <tinyxml2.h>

#include <tuple>

#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Check : public CommandTest {};

/// A robot alone has states to be checked.
TEST_F(Check, ARobotNeedsNoStartAndGoal) {
  const std::string robot = "check --robot arm.urdf --srdf arm.srdf ";
  const Answer answer = run(robot + "--state left --state 0,2.4 --state elbow=1 --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json states = answer.document()["states"];
  ASSERT_EQ(states.size(), 3u);
  EXPECT_EQ(states[0]["positions"], json({1, 0.25}));
  EXPECT_EQ(states[1]["positions"], json({0, 2.4}));
  EXPECT_EQ(states[2]["positions"], json({0, 1}));
  EXPECT_EQ(run("check --robot arm.urdf --state shoulder=9").status, 1);
  expectRefused(robot + "--state left --group leg", {"leg", "arm"});
  expectRefused(robot + "--state start", {"'start'", "--start"});
  expectRefused(robot, {"--start"});
}

/// Regression: they were refused.
TEST_F(Check, FilesWithoutAGoalHaveAStart) {
  for (const auto& [file, start, status] :
       {std::tuple("free.yaml", "right", 0), {"contact.yaml", "{shoulder: 0, elbow: 0}", 1}}) {
    std::string text = kReach;
    text.replace(text.find("goal: left\n"), 11, "");
    write(file, text.replace(text.find("right"), 5, start));
    const std::string name = file, verdict = status == 0 ? "valid" : "not valid";
    const Answer check = run("check " + name);
    EXPECT_EQ(check.status, status);
    EXPECT_EQ(check.out.find("start: " + verdict), 0U) << check.out;
    EXPECT_EQ(run("check " + name + " --state start").out, check.out);
    expectRefused("check " + name + " --state goal", {"is given by --goal or a problem file"});
    const Answer view = run("view " + name + " --svg start.svg");
    EXPECT_EQ(view.status, status) << view.out << view.err;
    EXPECT_NE(view.out.find("start " + verdict), std::string::npos) << view.out;
    EXPECT_NE(view.out.find("No goal is given"), std::string::npos) << view.out;
    EXPECT_NE(read("start.svg").find("post"), std::string::npos);
    const Answer lint = run("lint " + name);
    EXPECT_EQ(lint.status, 1);
    EXPECT_NE(lint.out.find(name + ": warning: the file has no goal"), std::string::npos);
    EXPECT_EQ(lint.out.find("lower and post collide") != std::string::npos, status == 1);
    expectRefused("plan " + name, {"neither 'goal' nor 'goals'"});
  }
  const Answer check = run("check --robot arm.urdf --srdf arm.srdf --group arm --start right");
  EXPECT_EQ(check.status, 0) << check.err;
  EXPECT_EQ(check.out.find("left"), std::string::npos);
}

TEST_F(Check, AStartOfAPoseKeepsTheConstraintsOfTheCommandLine) {
  const std::string arm = leeway::sourceFolder() + "/robots/arm7/arm7";
  write("up.yaml", "leeway: 1\nrobot: {urdf: " + arm + ".urdf, srdf: " + arm +
                       ".srdf, group: arm}\njoints: {finger_joint: 0.034}\n"
                       "start: {pose: {frame: hand, position: [0.5, 0, 0.5]}}\n"
                       "goal: {pose: {frame: hand, position: [0.4, 0.3, 0.5]}}\nseed: 1\n");
  const Answer answer = run("plan up.yaml --upright hand nz 0.2");
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
}

TEST_F(Check, TasksTellTheWarningsOfTheirMovesAndTakeGroups) {
  std::string text = kReach;
  text.replace(text.find("goal: left"), 10,
               "groups: {links: [upper, lower]}\n"
               "steps: [{move: left, allowed: [[links, rim]]}]\n"
               "margins: [{between: [upper, lower], wish: 0.1}]");
  text.insert(text.find("limits:"),
              "  - {name: rim, position: [0, 0, 5], sphere: {radius: 0.1}}\n");
  write("task.yaml", text);
  const Answer answer = run("plan task.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  EXPECT_NE(answer.document()["warnings"].dump().find(
                "step 1 (move): wish of 0.1 m between upper and lower: none of its pairs"),
            std::string::npos)
      << answer.out;
}

TEST_F(Check, PathsAreProvenForTheTermsTheyWerePlannedFor) {
  ASSERT_EQ(run("plan reach.yaml --upright lower z 0.1 --output path.json").status, 0);
  EXPECT_EQ(run("verify reach.yaml path.json --upright lower z 0.1").status, 0);
  EXPECT_EQ(run("verify reach.yaml path.json --upright lower x 0.1").status, 1);
  EXPECT_EQ(run("clearance reach.yaml path.json --upright lower z 0.1").status, 0);
  EXPECT_EQ(run("check reach.yaml --upright lower z 0.1").status, 0);
  const Answer tilted = run("check reach.yaml --upright lower x 0.1");
  EXPECT_EQ(tilted.status, 1);
  EXPECT_NE(tilted.out.find("constraint '--upright'"), std::string::npos) << tilted.out;
  expectRefused("replan reach.yaml --upright lower z 0.1", {"--upright"});
  write("slow.yaml", std::string(kReach) + "execution: {speed: 0.5}\n");
  ASSERT_EQ(run("plan slow.yaml --speed 0.9 --trajectory fast.json").status, 0);
  EXPECT_EQ(run("verify slow.yaml fast.json").status, 1);
  EXPECT_EQ(run("verify slow.yaml fast.json --speed 0.9").status, 0);
}

TEST_F(Check, StatesOfMoreJointsThanArePlannedAreTold) {
  std::string srdf = kSrdf, problem = kReach;
  srdf.insert(srdf.find("  <group_state"),
              "  <group name=\"first\"><joint name=\"shoulder\"/></group>\n");
  write("first.srdf", srdf);
  problem.replace(problem.find("arm.srdf, group: arm"), 20, "first.srdf, group: first");
  write("first.yaml", problem);
  const char* const others =
      "group state 'left' gives 'elbow' 0.25, which is not planned and stands at 0";
  Answer answer = run("check first.yaml");
  EXPECT_NE(answer.err.find(std::string("goal: ") + others), std::string::npos) << answer.err;
  EXPECT_EQ(answer.err.find("'right'"), std::string::npos) << answer.err;  // its elbow is at 0
  answer = run("check first.yaml --state left");
  EXPECT_EQ(answer.status, 2);
  EXPECT_NE(answer.err.find(others), std::string::npos) << answer.err;
  EXPECT_EQ(run("check first.yaml --state right").status, 0);
}

TEST_F(Check, ATaskHasAStartAndGoalsOfItsOwn) {
  std::string text = kReach;
  write("task.yaml", text.replace(text.find("goal: left"), 10, "steps: [{move: left}]"));
  EXPECT_EQ(run("check task.yaml --state start").status, 0);
  expectRefused("check task.yaml --state goal", {"a goal for each of its moves"});
}

/// A joint that wraps around, and half of which another one follows.
TEST_F(Check, NamesTheMimicThatWouldJump) {
  write("mimic.urdf",
        "<robot name=\"r\"><link name=\"base\"/><link name=\"a\"><collision><geometry><sphere "
        "radius=\"0.1\"/></geometry></collision></link><link name=\"b\"/>"
        "<joint name=\"j\" type=\"continuous\"><parent link=\"base\"/><child link=\"a\"/><origin "
        "xyz=\"1 0 0\"/><axis xyz=\"0 0 1\"/></joint>"
        "<joint name=\"m\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/><axis "
        "xyz=\"0 0 1\"/><mimic joint=\"j\" multiplier=\"0.5\"/></joint></robot>");
  const auto problem = [&](const std::string& start, const std::string& goal) {
    write("mimic.yaml",
          "leeway: 1\nrobot: {urdf: mimic.urdf}\nstart: [" + start + "]\ngoal: [" + goal +
              "]\nobjects: [{name: o, position: [0, 0, 2], sphere: {radius: 0.1}}]\n");
  };
  const std::string why = "joint m mimics j and would jump where that wraps around; j is 4";
  const auto says = [&](const std::string& command, int status) {
    const Answer answer = run(command + " --json");
    EXPECT_EQ(answer.status, status) << command << answer.err;
    EXPECT_NE(answer.out.find(why), std::string::npos) << command << answer.out;
  };
  problem("1", "4");
  says("plan mimic.yaml", 1);
  write("rows.csv", "j\n1\n4\n");
  says("clearance mimic.yaml rows.csv", 1);
  problem("4", "1");
  says("plan mimic.yaml", 1);
  says("check mimic.yaml --state start", 1);
}

TEST_F(Check, StartAndGoalByDefault) {
  const Answer answer = run("check reach.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["status"], "valid");
  ASSERT_EQ(document["states"].size(), 2u);
  EXPECT_EQ(document["states"][0]["name"], "start");
  EXPECT_EQ(document["states"][1]["name"], "left");
  for (const json& state : document["states"]) {
    EXPECT_EQ(state["valid"], true);
    EXPECT_LE(state["clearance_lower"], state["clearance_upper"]);
    EXPECT_EQ(state["closest"]["b"], "post");
    EXPECT_TRUE(state["penetration"].is_null());
  }
}

TEST_F(Check, ClearanceIsTheDistance) {
  // The lower link lies on y = 0.5 along x: its edge is 0.48 from the post's axis.
  const Answer answer =
      run("check reach.yaml --state 1.5707963267948966,-1.5707963267948966 --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json state = answer.document()["states"][0];
  const double dx = 0.85 - 0.45;
  const double expected = std::hypot(dx, 0.48) - 0.05;
  EXPECT_LE(state["clearance_lower"], expected + 1e-12);
  EXPECT_GE(state["clearance_upper"], expected - 1e-12);
  EXPECT_NEAR(state["clearance_lower"], expected, 1e-5);
}

TEST_F(Check, PenetrationWithDepthAndWitnesses) {
  const Answer answer = run("check reach.yaml --state shoulder=0,elbow=0 --depth --json");
  EXPECT_EQ(answer.status, 1);
  const json document = answer.document();
  EXPECT_EQ(document["status"], "invalid");
  const json state = document["states"][0];
  EXPECT_EQ(state["valid"], false);
  EXPECT_EQ(state["verdict"], "not_free");
  EXPECT_EQ(state["in_collision"], true);
  EXPECT_LE(state["penetration"]["depth_lower"], 0.07 + 1e-9);
  EXPECT_GE(state["penetration"]["depth_upper"], 0.07 - 1e-9);
  EXPECT_EQ(state["closest"]["point_a"].size(), 3u);
  const std::string text = run("check reach.yaml --state shoulder=0,elbow=0 --depth").out;
  for (const char* word :
       {"not valid", "lower", "post", "in collision", "70.0", "deepest points"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
}

TEST_F(Check, WithoutDepthTheSamePairsAreNamed) {
  const std::string state = "check reach.yaml --state shoulder=0,elbow=0";
  const Answer answer = run(state + " --json");
  EXPECT_EQ(answer.status, 1);
  const json plain = answer.document()["states"][0];
  const json deep = run(state + " --depth --json").document()["states"][0];
  for (const char* key : {"valid", "verdict", "limit", "in_collision", "too_near", "all_too_near"})
    EXPECT_EQ(plain[key], deep[key]) << key;
  for (const char* key : {"penetration", "closest", "clearance_lower", "clearance_upper"})
    EXPECT_TRUE(plain[key].is_null()) << key;
  EXPECT_TRUE(plain["world"]["clearance_upper"].is_null());
  const std::string text = run(state).out;
  EXPECT_NE(text.find("lower and post in collision (--depth"), std::string::npos) << text;
  EXPECT_EQ(run("check reach.yaml --json").document()["states"][0]["in_collision"], false);
}

TEST_F(Check, MarginsOfPairsNameThePair) {
  // The post is nearer than the wall, but only the wall has a margin.
  std::string text = kReach;
  text.insert(text.find("limits"),
              "  - {name: wall, position: [0, -2, 0], box: {size: [4, 0.2, 1]}}\n"
              "margins: [{between: [lower, wall], margin: 2.5}]\n");
  write("margins.yaml", text);
  const Answer answer = run("check margins.yaml --state shoulder=0.5,elbow=0 --json");
  EXPECT_EQ(answer.status, 1) << answer.err;
  const json state = answer.document()["states"][0];
  EXPECT_EQ(state["closest"]["b"], "post");
  EXPECT_GT(state["clearance_lower"], 0);
  EXPECT_EQ(state["too_near"], json({"lower", "wall"}));
  EXPECT_NE(
      run("check margins.yaml --state shoulder=0.5,elbow=0").out.find("lower and wall do not keep"),
      std::string::npos);
}

TEST_F(Check, LimitsCountToo) {
  const Answer answer = run("check reach.yaml --state shoulder=3.5 --json");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.document()["states"][0]["limit"].get<std::string>().find("shoulder"),
            std::string::npos);
}

TEST_F(Check, NamedStatesAndNonsense) {
  EXPECT_EQ(run("check reach.yaml --state left --state right").status, 0);
  expectRefused("check reach.yaml --state 1", {"2 are expected", "shoulder, elbow"});
  expectRefused("check reach.yaml --state 1,x", {"'1,x'"});
  expectRefused("check reach.yaml --state knee=1", {"knee", "shoulder, elbow"});
  expectRefused("check reach.yaml --state 1,nan", {"nan"});
}

TEST_F(Check, NothingToBeNearIsNull) {
  const json state = run("check empty.yaml --json").document()["states"][0];
  EXPECT_TRUE(state["clearance_lower"].is_null());
  EXPECT_TRUE(state["closest"].is_null());
  EXPECT_EQ(state["valid"], true);
}

class Verify : public CommandTest {};

TEST_F(Verify, CertifiesAPlannedPath) {
  ASSERT_EQ(run("plan reach.yaml --output path.json").status, 0);
  const Answer answer = run("verify reach.yaml path.json --json");
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["status"], "certified");
  EXPECT_GE(document["clearance_lower"], 0);
  EXPECT_TRUE(document["where"].is_null());
  EXPECT_NE(run("verify reach.yaml path.json").out.find("certified"), std::string::npos);
}

TEST_F(Verify, RefutesTheStraightLine) {
  write("line.csv", "time,shoulder,elbow\n0,-1,0\n1,1,0.25\n");
  const Answer answer = run("verify reach.yaml line.csv --json");
  EXPECT_EQ(answer.status, 1);
  const json document = answer.document();
  EXPECT_EQ(document["status"], "refuted");
  EXPECT_TRUE(document["clearance_lower"].is_null());
  EXPECT_EQ(document["where"]["segment"], 0);
  EXPECT_EQ(document["where"]["a"], "lower");
  EXPECT_EQ(document["where"]["b"], "post");
  const std::string text = run("verify reach.yaml line.csv").out;
  for (const char* word : {"refuted", "edge 0", "lower", "post"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
}

TEST_F(Verify, AnotherStartIsRefuted) {
  write("line.csv", "time,shoulder,elbow\n0,0.9,0.25\n1,1,0.25\n");
  const Answer answer = run("verify reach.yaml line.csv --json");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.document()["reason"].get<std::string>().find("start"), std::string::npos)
      << answer.out;
}

TEST_F(Verify, PathsThatCannotBeRead) {
  expectRefused("verify reach.yaml missing.csv", {"missing.csv"});
  write("path.txt", "0 zero\n");
  expectRefused("verify reach.yaml path.txt", {"path.txt:1", "zero"});
  write("path.csv", "time,shoulder,knee\n0,0,0\n");
  expectRefused("verify reach.yaml path.csv", {"path.csv", "knee"});
  write("short.csv", "time,shoulder,elbow\n0,0\n");
  expectRefused("verify reach.yaml short.csv", {"short.csv:2"});
  write("nan.csv", "time,shoulder,elbow\n0,0,nan\n");
  expectRefused("verify reach.yaml nan.csv", {"nan.csv:2", "nan"});
  write("path.json", "{");
  expectRefused("verify reach.yaml path.json", {"path.json"});
}

class Clearance : public CommandTest {};

TEST_F(Clearance, AgreesWithTheCertificate) {
  const json certificate =
      run("plan reach.yaml --output path.json --json").document()["certificate"];
  const Answer answer = run("clearance reach.yaml path.json --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["status"], "certified");
  // Two intervals that hold one number overlap.
  EXPECT_LE(document["clearance_lower"], certificate["clearance_upper"]);
  EXPECT_LE(certificate["clearance_lower"], document["clearance_upper"]);
  EXPECT_EQ(document["segments"].size(), certificate["segments"].size());
  EXPECT_EQ(document["closest"]["b"], "post");
  EXPECT_EQ(document["warnings"], json::array());
}

/// As `verify` does.
TEST_F(Clearance, EdgesBeyondTheLimitsAreNotCertified) {
  write("far.csv", "shoulder,elbow\n-1,0.25\n-3.5,0.25\n");
  const Answer answer = run("clearance reach.yaml far.csv --json");
  EXPECT_EQ(answer.status, 1) << answer.err;
  EXPECT_EQ(answer.document()["status"], "not_certified");
  EXPECT_EQ(answer.document()["reason"].get<std::string>().rfind(
                "edge 0 is not certified: shoulder = -3.5 is outside -", 0),
            0U)
      << answer.out;
}

TEST_F(Clearance, APathOfOneWaypointIsAnEdgeWithoutLength) {
  write("rest.csv", "shoulder,elbow\n-1,0.25\n");
  const Answer answer = run("clearance reach.yaml rest.csv --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.document()["segments"].size(), 1U);
}

TEST_F(Clearance, DrawsTheProfile) {
  std::string text = kReach;
  text.replace(text.find("around the post"), 15, "\"<script>alert(1)</script>&\\u2028\"");
  write("hostile.yaml", text);
  write("swing.csv", "time,shoulder,elbow\n0,0.2,1.5\n1,1.2,1.5\n");
  EXPECT_EQ(run("clearance hostile.yaml swing.csv --parts 4 --svg profile.svg").status, 0);
  tinyxml2::XMLDocument picture;
  ASSERT_EQ(picture.LoadFile(path("profile.svg").c_str()), tinyxml2::XML_SUCCESS);
  EXPECT_STREQ(picture.RootElement()->Name(), "svg");
  const std::string drawn = read("profile.svg");
  EXPECT_EQ(drawn.find("<script"), std::string::npos);
  for (const char* word : {"&lt;script&gt;", "clearance [mm]", "margin", "proven"}) {
    EXPECT_NE(drawn.find(word), std::string::npos) << word;
  }
  expectRefused("clearance hostile.yaml swing.csv --svg profile.png", {"profile.png", ".svg"});
}

TEST_F(Clearance, PartsRefineTheProfile) {
  write("swing.csv", "time,shoulder,elbow\n0,0.2,1.5\n1,1.2,1.5\n");
  const json whole = run("clearance reach.yaml swing.csv --json").document();
  ASSERT_EQ(whole["warnings"].size(), 2U) << whole["warnings"];
  EXPECT_EQ(whole["warnings"][0].get<std::string>().rfind("swing.csv: the path begins 1.", 0), 0U)
      << whole["warnings"];
  EXPECT_EQ(whole["warnings"][1], "swing.csv: the path ends in none of the problem's goals");
  const json parts = run("clearance reach.yaml swing.csv --json --parts 5").document();
  ASSERT_EQ(parts["segments"].size(), 5u);
  EXPECT_LE(parts["clearance_lower"], whole["clearance_upper"]);
  EXPECT_LE(whole["clearance_lower"], parts["clearance_upper"]);
  double previous = 0;
  for (const json& part : parts["segments"]) {
    EXPECT_EQ(part["t0"], previous);
    previous = part["t1"];
    EXPECT_LE(whole["clearance_lower"].get<double>(), part["clearance_upper"].get<double>());
    EXPECT_LE(part["clearance_upper"].get<double>() - part["clearance_lower"].get<double>(),
              1e-4 + 1e-12);
  }
  EXPECT_EQ(previous, 1.0);
}

TEST_F(Clearance, CollidingPathIsStatus1) {
  write("line.csv", "time,shoulder,elbow\n0,-1,0\n1,1,0.25\n");
  const Answer answer = run("clearance reach.yaml line.csv --json");
  EXPECT_EQ(answer.status, 1);
  const json document = answer.document();
  EXPECT_EQ(document["status"], "not_certified");
  EXPECT_LE(document["clearance_upper"], 0);
  EXPECT_EQ(document["closest"]["a"], "lower");
  EXPECT_NE(run("clearance reach.yaml line.csv").out.find(": not certified, contact, "),
            std::string::npos);
}

/// Each edge of a task is measured in the world of its step, as the planner proved it there.
TEST_F(Clearance, TasksAreMeasuredStepByStep) {
  const std::string can = "'" + leeway::sourceFolder() + "/problems/pick_place/can.yaml' ";
  const json plan = run("plan " + can + "--certificate full --output can.json --json").document();
  const Answer answer = run("clearance " + can + "can.json --csv can.csv --json");
  ASSERT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["status"], "certified");
  const json& proven = plan["certificate"]["segments"];
  ASSERT_EQ(document["segments"].size(), proven.size());
  std::vector<std::string> steps;
  for (std::size_t i = 0; i < proven.size(); ++i) {
    const json& segment = document["segments"][i];
    EXPECT_LE(segment["clearance_lower"], proven[i]["clearance_upper"]) << i;
    EXPECT_LE(proven[i]["clearance_lower"], segment["clearance_upper"]) << i;
    if (steps.empty() || steps.back() != segment["step"]) steps.push_back(segment["step"]);
  }
  EXPECT_EQ(steps, (std::vector<std::string>{"above", "approach", "lift", "carry", "put down",
                                             "retreat", "home"}));
  const std::string table = read("can.csv");
  EXPECT_NE(table.find("certified,step\n"), std::string::npos);
  EXPECT_NE(table.find(",yes,put down\n"), std::string::npos) << table;
  expectRefused("clearance " + can + "can.csv", {"can.csv"});
  // The page has the can held and not held, whatever its steps are relative to.
  EXPECT_EQ(run("view " + can + "can.json --svg can.svg").status, 0);
}

/// A path that keeps its margins and not its constraints is not certified; the edge is named.
TEST_F(Clearance, ConstraintsAreProvenToo) {
  const std::string glass = "'" + leeway::sourceFolder() + "/problems/constrained/glass.yaml' ";
  const json plan = run("plan " + glass + "--output glass.csv --json").document();
  Answer answer = run("clearance " + glass + "glass.csv --json");
  ASSERT_EQ(answer.status, 0) << answer.err;
  json document = answer.document();
  EXPECT_EQ(document["status"], "certified");
  EXPECT_EQ(document["reason"], json());
  EXPECT_EQ(document["constraints"], plan["certificate"]["constraints"]);
  ASSERT_EQ(document["constraints"].size(), 1u);
  EXPECT_LE(document["constraints"][0]["angle"], 0.17);
  answer = run("clearance " + glass + "glass.csv");
  EXPECT_NE(answer.out.find("Constraint 'upright' holds everywhere, proven: 'glass' is at most "),
            std::string::npos)
      << answer.out;

  // The same path, but the hand turns the glass and turns it back after the first edge.
  std::vector<std::vector<double>> rows = plan["path"]["positions"];
  std::vector<double> tilted = rows[1];
  tilted[6] -= 0.5;
  rows.insert(rows.begin() + 2, {tilted, rows[1]});
  std::string text = "joint1,joint2,joint3,joint4,joint5,joint6,joint7\n";
  for (const std::vector<double>& row : rows)
    for (std::size_t k = 0; k < 7; ++k)
      text += (k > 0 ? "," : "") + json(row[k]).dump() + (k == 6 ? "\n" : "");
  write("tilts.csv", text);
  answer = run("clearance " + glass + "tilts.csv --json");
  EXPECT_EQ(answer.status, 1);
  document = answer.document();
  EXPECT_EQ(document["status"], "not_certified");
  EXPECT_EQ(document["reason"], "constraint 'upright' is not proven to hold on edge 1");
  EXPECT_TRUE(document["constraints"].empty());
  EXPECT_EQ(document["segments"][0]["certified"], true);
  EXPECT_EQ(document["segments"][1]["certified"], false);
  answer = run("clearance " + glass + "tilts.csv");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.out.find("constraint 'upright' is not proven to hold on edge 1."),
            std::string::npos)
      << answer.out;
  // verify, and what view shows of it.
  answer = run("verify " + glass + "tilts.csv");
  EXPECT_EQ(answer.status, 1);
  answer = run("view " + glass + "tilts.csv --svg tilts.svg");
  EXPECT_EQ(answer.status, 1) << answer.err;
  EXPECT_NE(answer.out.find("not certified"), std::string::npos) << answer.out;
  EXPECT_NE(answer.out.find("for 'glass'"), std::string::npos) << answer.out;
  answer = run("view " + glass + "glass.csv --svg glass.svg");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.out.find("Constraint 'upright' holds everywhere, proven"), std::string::npos)
      << answer.out;
}

/// Paths in single precision miss start and goal by some 1e-8.
TEST_F(Verify, EndsOfSinglePrecisionAreTakenWithAWarning) {
  write("short.csv", "-1.00000002,1e-8\n1,1.25\n");
  write("short.yaml", std::string(kEmpty).replace(std::string(kEmpty).find("goal: left"), 10,
                                                  "goal: [1, 1.2500005]"));
  const Answer answer = run("verify short.yaml short.csv --json");
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  EXPECT_EQ(answer.document()["warnings"].size(), 2u);
  EXPECT_NE(answer.err.find("short.csv: the path begins 2.2e-08 off the start"), std::string::npos)
      << answer.err;
  const Answer exact = run("verify short.yaml short.csv --ends exact");
  EXPECT_EQ(exact.status, 1);
  EXPECT_NE(exact.out.find("not the start"), std::string::npos) << exact.out;
  write("far.csv", "-1.000002,0\n1,1.25\n");
  EXPECT_EQ(run("verify short.yaml far.csv").status, 1);
}

}  // namespace
}  // namespace leeway::tools::testing
