#include <cmath>
#include <regex>
#include <set>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class GuardVerb : public CommandTest {
 protected:
  /// Runs `leeway guard` with this standard input.
  Answer guard(const std::string& arguments, const std::string& input) const {
    write("input", input);
    return run("guard " + arguments + " <input");
  }
};

/// Rows in which the shoulder turns towards the post, faster by 0.02 rad/s in each period.
std::string towardsThePost(int count) {
  json rows = json::array();
  double shoulder = -1, speed = 0;
  for (int k = 0; k < count; ++k) {
    speed = std::min(0.5, speed + 0.02);
    shoulder += speed * 0.02;
    rows.push_back({shoulder, 0});
  }
  return rows.dump();
}

TEST_F(GuardVerb, AnswersEachLine) {
  const Answer answer = guard("reach.yaml", towardsThePost(30) + "\n\n# nothing\n[]\n");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.err, "");
  const std::vector<json> lines = answer.lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["line"], 1);
  EXPECT_EQ(lines[0]["seed"], 7);
  EXPECT_EQ(lines[0]["time"], 0);
  EXPECT_EQ(lines[0]["setpoints"], 30);
  EXPECT_EQ(lines[0]["passed"], 30);
  EXPECT_EQ(lines[0]["reason"], "passed");
  EXPECT_EQ(lines[0]["certified"], true);
  EXPECT_EQ(lines[0]["start"], json::parse("[-1, 0]"));
  EXPECT_GT(lines[0]["motion"].size(), 30u);
  EXPECT_GT(lines[0]["counts"]["edges"], 0);
  // The first answer lists the pairs that no answer covers.
  EXPECT_EQ(lines[0]["not_checked"], run("check reach.yaml --json").document()["not_checked"]);
  EXPECT_EQ(lines[0]["not_checked"]["pairs"], 1);
  EXPECT_FALSE(lines[1].contains("not_checked"));
  // A line without setpoints stops the robot at the end of the last answer's setpoints.
  EXPECT_EQ(lines[1]["line"], 4);
  EXPECT_NEAR(lines[1]["time"].get<double>(), 0.6, 1e-12);
  EXPECT_EQ(lines[1]["start"], lines[0]["motion"][29]);
  EXPECT_EQ(lines[1]["motion"].size(), lines[0]["motion"].size() - 30);
}

TEST_F(GuardVerb, SaysWhatIsInTheWay) {
  const Answer answer = guard("reach.yaml --most-setpoints 200", towardsThePost(150) + "\n");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json line = answer.document();
  EXPECT_LT(line["passed"], 130);
  EXPECT_GT(line["passed"], 60);
  EXPECT_EQ(line["reason"], "not_free");
  EXPECT_EQ(line["in_stop"], true);
  EXPECT_EQ(line["pair"]["a"], "lower");
  EXPECT_EQ(line["pair"]["b"], "post");
  // An arm that may be off by more stops earlier.
  const json off = guard("reach.yaml --most-setpoints 200 --joint-error shoulder=0.05,elbow=0.01",
                         towardsThePost(150) + "\n")
                       .document();
  EXPECT_LT(off["passed"], line["passed"]);
  EXPECT_GT(off["passed"], 0);
  const json far = guard("reach.yaml --most-setpoints 200 --point-error 0.05 --joint-error 0.001",
                         towardsThePost(150) + "\n")
                       .document();
  EXPECT_LT(far["passed"], line["passed"]);
}

TEST_F(GuardVerb, ReadsPolynomials) {
  // The shoulder turns by t^2 / 2 for half a second; then the request says where it begins wrongly.
  const std::string first = R"({"polynomials": [[-1, 0, 0.5], [0, 0, 0]], "duration": 0.5})";
  const std::string next = R"({"polynomials": [[-0.875, 0.5], [0, 0]], "duration": 0.1})";
  const std::vector<json> lines = guard("reach.yaml", first + "\n" + next + "\n").lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["setpoints"], 25);
  EXPECT_EQ(lines[0]["passed"], 25);
  EXPECT_EQ(lines[0]["on_polynomials"], 25);
  EXPECT_NEAR(lines[0]["motion"][24][0].get<double>(), -0.875, 1e-12);
  EXPECT_EQ(lines[1]["passed"], 5);
  EXPECT_EQ(lines[1]["reason"], "passed");

  const std::pair<const char*, const char*> faults[] = {
      {R"("polynomials": [[-1, 0], [0, 0]])", "'duration' is missing"},
      {R"("duration": 1)", "'polynomials' is missing"},
      {R"("polynomials": [[-1, 0]], "duration": 0.1)", "a list of 2 lists"},
      {R"("polynomials": [[-1, 0], [0]], "duration": 0.1)", "polynomials[1]"},
      {R"("polynomials": [[], []], "duration": 0.1)", "a list of 2 lists"},
      {R"("polynomials": [[-1], [0]], "duration": 0.1, "setpoints": [])", "one of them"},
      {R"("polynomials": [[-1], [0]], "duration": 0.11)", "duration is 0.11 s; a whole number"},
      {R"("polynomials": [[-1], [0]], "duration": 2)", "duration is 2 s; at most 64 periods"},
      {R"("polynomials": [[-1], [0]], "duration": 1e300)", "at most 64 periods"},
      {R"("polynomials": [[-0.9], [0]], "duration": 0.1)", "'shoulder' begins at -0.9; -1"},
      {R"("polynomials": [[-1,0,0,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0]], "duration": 0.1)",
       "9 coefficients; at most 8"}};
  for (const auto& [text, message] : faults) {
    const Answer answer = guard("reach.yaml", "{" + std::string(text) + "}\n" + first + "\n");
    EXPECT_EQ(answer.status, 2) << text;
    EXPECT_NE(answer.err.find(message), std::string::npos) << text << answer.err;
    ASSERT_EQ(answer.lines().size(), 2u) << text;
    EXPECT_EQ(answer.lines()[1]["passed"], 25) << text;
  }
}

TEST_F(GuardVerb, NamesTheLimitsThatAreBrokenWhereTheMotionBegins) {
  const auto line = [&](const std::string& state) {
    return guard("reach.yaml", "{" + state + "}\n").document();
  };
  const json outside = line(R"("position": [-1, 2.6])");
  EXPECT_EQ(outside["reason"], "limit");
  EXPECT_EQ(outside["certified"], true) << "it stays where it is";
  EXPECT_EQ(outside["joint"], "elbow");
  EXPECT_EQ(outside["limit"], "position");
  EXPECT_EQ(outside["value"], 2.6);
  EXPECT_EQ(outside["allowed"], 2.5);
  const json fast = line(R"("position": [-1, 0], "velocity": [-1.5, 0])");
  EXPECT_EQ(fast["reason"], "limit");
  EXPECT_EQ(fast["joint"], "shoulder");
  EXPECT_EQ(fast["limit"], "velocity");
  EXPECT_EQ(fast["allowed"], -1);
  // Setpoints lead back inside.
  const json back = line(R"("position": [-1, 2.501], "setpoints": [[-1, 2.5005], [-1, 2.4995]])");
  EXPECT_EQ(back["reason"], "limit");
  EXPECT_EQ(line(R"("position": [-1, 2.5001], "setpoints": [[-1, 2.4998]])")["passed"], 1);
}

TEST_F(GuardVerb, MessagesNameKeyAndValue) {
  const std::pair<const char*, const char*> lines[] = {
      {R"({"position": [NaN, 0]})", "'NaN' is not JSON there"},
      {R"({"position": [1e999, 0]})", "position: '1e999' is too large; a size of at most 1.8e+308"},
      {R"({"observe": {"object": "post", "position": [0,0,0], "orientation": [0,0,0,1], "time": 0,
           "speed_bound": 1, "turn_bound": 1}})",
       "'post' has no motion (`moving`) in the problem"},
      {R"({"observe": {"object": "cart", "position": [0,0,0], "orientation": [0,0,0,1], "time": 0,
           "speed_bound": 1, "turn_bound": 1}})",
       "the problem has no object with a motion; one named 'cart' was seen"}};
  for (const auto& [text, message] : lines) {
    std::string line = text;
    std::replace(line.begin(), line.end(), '\n', ' ');
    const Answer answer = guard("reach.yaml", line + "\n");
    EXPECT_EQ(answer.status, 2) << text;
    EXPECT_NE(answer.err.find(message), std::string::npos) << text << answer.err;
  }
  EXPECT_NE(guard("reach.yaml --joint-error=-0.1", "")
                .err.find("--joint-error is -0.1; 0 or more is expected"),
            std::string::npos);
}

TEST_F(GuardVerb, NeedsNoGoal) {
  std::string text = read("reach.yaml");
  text = std::regex_replace(text, std::regex("\ngoal:[^\n]*"), "");
  write("no_goal.yaml", text);
  EXPECT_EQ(run("plan no_goal.yaml").status, 2);
  EXPECT_EQ(guard("no_goal.yaml", "-1,0\n").document()["passed"], 1);
  EXPECT_EQ(run("info no_goal.yaml").status, 0);
  EXPECT_EQ(run("fk no_goal.yaml --json").status, 0);
}

TEST_F(GuardVerb, ReadsRowsOfNumbers) {
  // The second row has two setpoints; the header has the joints in another order.
  const Answer answer = guard("reach.yaml",
                              "\xEF\xBB\xBF"
                              "elbow,shoulder\n0,-0.9995\r\n0, -0.999, 0.0002,-0.9985\n");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const std::vector<json> lines = answer.lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["motion"][0], json::parse("[-0.9995, 0.0]"));
  EXPECT_EQ(lines[1]["passed"], 2);
  EXPECT_EQ(lines[1]["motion"][1], json::parse("[-0.9985, 0.0002]"));
}

TEST_F(GuardVerb, SaysWhichLimitWouldBeBroken) {
  const json line = guard("reach.yaml", "-0.9,0\n").document();
  EXPECT_EQ(line["passed"], 0);
  EXPECT_EQ(line["reason"], "limit");
  EXPECT_EQ(line["joint"], "shoulder");
  EXPECT_EQ(line["limit"], "velocity");
  EXPECT_NEAR(line["value"].get<double>(), 5, 1e-9);
  EXPECT_EQ(line["allowed"], 1);
}

TEST_F(GuardVerb, WrongLinesStopTheRobotAndTheNextAreRead) {
  const std::pair<const char*, const char*> wrong[] = {
      {"1", "1 number; 2, or a multiple of that, are expected"},
      {"[1, 2]", "setpoints[0] is 1; a list of 2 numbers is expected"},
      {"[[1, \"x\"]]", "setpoints[0] is \"x\"; a number is expected"},
      {"{", "the line ends before its list or object does"},
      {"[[1e999, 0]]", "'1e999' is too large"},
      {"{\"time\": -1}", "time is -1 s; seconds that do not go back"},
      {"{\"time\": 1.76e18}", "time is 1.76e+18 s; seconds that do not go back"},
      {"{\"time\": 1, \"time\": 2}", "the key 'time' stands twice"},
      {"{\"setpoint\": []}", "'setpoint' is no key; did you mean 'setpoints'?"},
      {"{\"position\": [1]}", "position is [1]; a list of 2 numbers is expected"},
      {"{\"time\": \"now\"}", "time is \"now\"; a number is expected"},
      {"{\"observe\": {}}", "observe has no 'object'"},
      {"{\"observe\": {\"object\": \"post\", \"vertices\": [], \"time\": 0, \"speed_bound\": 0}}",
       "'post' has no motion (`moving`)"},
      {"{\"observe\": {\"object\": \"\", \"vertices\": [], \"time\": 0, \"speed_bound\": 0}}",
       "the problem has no deforming obstacle; one named '' was seen"},
      {"{\"observe\": 1}", "observe is no object"},
      {"{\"observe\": {}, \"time\": 1}", "'time' is no key"}};
  for (const auto& [text, message] : wrong) {
    const Answer answer = guard("reach.yaml", "-1,0\n" + std::string(text) + "\n-1,0\n");
    EXPECT_EQ(answer.status, 2) << text;
    EXPECT_EQ(answer.err.rfind("standard input:2: ", 0), 0u) << answer.err;
    EXPECT_NE(answer.err.find(message), std::string::npos) << answer.err;
    const std::vector<json> lines = answer.lines();
    ASSERT_EQ(lines.size(), 3u) << text;
    EXPECT_EQ(lines[1]["reason"], "invalid");
    EXPECT_EQ(lines[1]["passed"], 0);
    EXPECT_EQ(lines[1]["certified"], true);
    EXPECT_NE(lines[1]["message"].get<std::string>().find(message), std::string::npos);
    EXPECT_EQ(lines[2]["passed"], 1);
  }
  const Answer header = guard("reach.yaml", "elbow,shoulde\n-1,0\n");
  EXPECT_EQ(header.status, 2);
  EXPECT_NE(header.err.find("did you mean 'shoulder'?"), std::string::npos) << header.err;
  // Rows of numbers are not taken for the group's order after that; JSON is read.
  const std::vector<json> after = guard("reach.yaml", "elbow,shoulde\n-1,0\n[[-1,0]]\n").lines();
  ASSERT_EQ(after.size(), 3u);
  EXPECT_NE(after[1]["message"].get<std::string>().find("first line"), std::string::npos);
  EXPECT_EQ(after[1]["passed"], 0);
  EXPECT_EQ(after[2]["passed"], 1);
  EXPECT_EQ(guard("reach.yaml", "elbow,elbow\n").status, 2);
  EXPECT_EQ(guard("reach.yaml", "elbow\n").status, 2);
  const Answer nan = guard("reach.yaml", "nan,0\n");
  EXPECT_EQ(nan.status, 2);
  EXPECT_EQ(nan.document()["reason"], "invalid");
  EXPECT_EQ(nan.document()["message"],
            "setpoints[0] has nan for 'shoulder'; a finite number is expected");
  const Answer later = guard("reach.yaml", "-1,0,-1,-inf\n");
  EXPECT_EQ(later.document()["message"],
            "setpoints[1] has -inf for 'elbow'; a finite number is expected");
}

/// Regression: it was taken to be where the problem starts, or where its motion had it.
TEST_F(GuardVerb, APositionCountsAlsoInAWrongLine) {
  const std::pair<const char*, bool> wrong[] = {
      {R"({"position": [-0.5, 0], "setpoint": []})", true},
      {R"({"position": [-0.5, 0], "time": "now"})", true},
      {R"({"position": [-0.5, 0], "velocity": [0]})", false},
      {R"({"position": [-0.5, 0, 0]})", false},
      {R"({"position": [-0.5, 0], "position": [-0.5, 0]})", false},
      {R"({"position": [-0.5,)", false}};
  for (const auto& [text, is_read] : wrong) {
    const Answer answer = guard("reach.yaml", std::string(text) + "\n[[-1,0]]\n");
    EXPECT_EQ(answer.status, 2) << text;
    ASSERT_EQ(answer.lines().size(), 2u) << text;
    EXPECT_EQ(answer.lines()[1]["passed"], 0) << text;
    EXPECT_EQ(answer.lines()[1]["certified"], is_read) << text;
  }
  const std::vector<json> later =
      guard("reach.yaml", "-1,0\n" + std::string(wrong[0].first) + "\n[]\n").lines();
  ASSERT_EQ(later.size(), 3u);
  EXPECT_EQ(later[2]["start"], json::parse("[-0.5, 0.0]"));
  // A wrong observation says nothing of the robot.
  EXPECT_EQ(guard("reach.yaml", "{\"observe\": {\n[[-1,0]]\n").lines()[1]["passed"], 1);
}

/// A first line with anything that begins like a number has no names, and the next lines are read.
TEST_F(GuardVerb, AFirstLineOfNumbersIsNoHeader) {
  const std::pair<const char*, const char*> wrong[] = {
      {"1e400,0", "'1e400' is out of range; 0, or a size from 2.2e-308 to 1.8e+308, is expected"},
      {"-1,1e-400", "'1e-400' is out of range"},
      {"-1e400,nan", "'-1e400' is out of range"},
      {"-1,0x1", "'0x1' is no number; one such as -0.5 or 1e-3 is expected"},
      {"+1,0", "'+1' is no number"},
      {"-1 0,0", "'-1 0' is no number"},
      {",0", "'' is no number"},
      {"elbow,0", "'elbow' is no number"}};
  for (const auto& [text, message] : wrong) {
    const Answer answer = guard("reach.yaml", std::string(text) + ",-1,0\n-1,0\n");
    EXPECT_EQ(answer.status, 2) << text;
    EXPECT_EQ(answer.err.rfind("standard input:1: ", 0), 0u) << answer.err;
    EXPECT_NE(answer.err.find(message), std::string::npos) << answer.err;
    const std::vector<json> lines = answer.lines();
    ASSERT_EQ(lines.size(), 2u) << text;
    EXPECT_EQ(lines[0]["passed"], 0);
    EXPECT_EQ(lines[1]["passed"], 1);
  }
}

TEST_F(GuardVerb, ARobotThatIsNotCertifiedIsStatus1) {
  write("start.yaml", kInvalidStart);
  const Answer answer = guard("start.yaml", "0,0\n");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.document()["certified"], false);
  EXPECT_EQ(guard("start.yaml", "").status, 0);  // nothing was asked
}

TEST_F(GuardVerb, RefusesWhatItCannotGuard) {
  expectRefused("guard reach.yaml --period 0", {"--period: 0"});
  expectRefused("guard reach.yaml --joint-error x=1", {"--joint-error", "no planned joint 'x'"});
  expectRefused("guard reach.yaml --joint-error -1", {"--joint-error is -1; 0 or more"});
  expectRefused("guard reach.yaml --joint-error 0,1", {"'0' names no joint; a number for all, or"});
  expectRefused("guard reach.yaml --joint-error elbow=0.5,elbow=0", {"names 'elbow' twice"});
  expectRefused("guard reach.yaml --joint-error elbow,shoulder=1", {"elbow=NUMBER is expected"});
  expectRefused("guard reach.yaml --joint-error elbow=-1", {"'elbow' is -1"});
  const Answer part = guard("reach.yaml --joint-error elbow=0.01", "");
  EXPECT_NE(part.err.find("says nothing of 'shoulder', which counts as exact"), std::string::npos)
      << part.err;
  expectRefused("guard reach.yaml --work 0", {"--work: 0"});
  expectRefused("guard reach.yaml --horizon nan", {"--horizon: nan"});
  expectRefused("guard nowhere.yaml", {"nowhere.yaml"});
}

/// A sheet in the way of the arm, whose vertices the input gives.
const char* const kSheet = R"(leeway: 1
robot: {urdf: arm.urdf, srdf: arm.srdf, group: arm}
start: right
goal: left
deforming:
  - name: sheet
    position: [0.85, 0, 0]
    rpy: [1.5707963267948966, 0, 0]
    grid: {size: [0.2, 0.2], cells: [1, 1]}
    motion:
      morph:
        references: [{}, {bumps: [{center: [0, 0, 0], radius: 99, by: [0, 0, 0.1]}]}]
        keys: [{time: 0, weights: [1, 0]}, {time: 1, weights: [0, 1]}]
allowed: [[base, sheet]]
)";

TEST_F(GuardVerb, FollowsObstaclesThatDeform) {
  write("sheet.yaml", kSheet);
  const std::string still = "[[-1,0],[-1,0],[-1,0]]\n";
  const auto observe = [](double x, double time) {
    return json({{"observe",
                  {{"object", "sheet"},
                   {"vertices", {{x, -0.1, 0}, {x + 0.2, -0.1, 0}, {x, 0.1, 0}, {x + 0.2, 0.1, 0}}},
                   {"time", time},
                   {"speed_bound", 0.1}}}})
               .dump() +
           "\n";
  };
  const Answer answer =
      guard("sheet.yaml", still + observe(-0.1, 0.1) + still + observe(0.5, 0.1) + still +
                              observe(0.5, 0.2) + still + observe(0.5, 0.1));
  EXPECT_EQ(answer.status, 0) << answer.err;
  const std::vector<json> lines = answer.lines();
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[0]["passed"], 3);  // by its motion
  EXPECT_EQ(lines[1]["observation"], "taken");
  EXPECT_FALSE(lines[1].contains("motion"));
  EXPECT_EQ(lines[2]["passed"], 3);
  EXPECT_EQ(lines[3]["observation"], "jumped");
  EXPECT_EQ(lines[4]["reason"], "jumped");
  EXPECT_EQ(lines[4]["pair"]["a"], "sheet");
  EXPECT_EQ(lines[5]["observation"], "taken");
  EXPECT_EQ(lines[6]["passed"], 3);
  EXPECT_EQ(lines[7]["observation"], "late");
}

TEST_F(GuardVerb, FollowsObjectsThatMove) {
  std::string cart = kSheet;
  const std::size_t at = cart.find("deforming:");
  ASSERT_NE(at, std::string::npos);
  cart = cart.substr(0, at) +
         "allowed: [[base, cart]]\nobjects:\n  - name: cart\n    position: [0.85, 0, 0]\n"
         "    box: {size: [0.2, 0.2, 0.2]}\n    moving: {speed_bound: 0.1, turn_bound: 0.1}\n";
  write("cart.yaml", cart);
  const std::string still = "[[-1,0],[-1,0],[-1,0]]\n";
  const auto observe = [](double x, double time, json more = {}) {
    json seen = {{"object", "cart"}, {"position", {0.85 + x, 0, 0}}, {"orientation", {0, 0, 0, 1}},
                 {"time", time},     {"speed_bound", 0.1},           {"turn_bound", 0.1}};
    if (more.is_object()) seen.update(more);
    return json({{"observe", seen}}).dump() + "\n";
  };
  const Answer answer =
      guard("cart.yaml", still + observe(0.01, 0.1) + still + observe(0.5, 0.1) + still +
                             observe(0.5, 0.2) + still + observe(0.5, 0.1));
  EXPECT_EQ(answer.status, 0) << answer.err;
  const std::vector<json> lines = answer.lines();
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[0]["passed"], 3);
  EXPECT_EQ(lines[1]["observation"], "taken");
  EXPECT_EQ(lines[2]["passed"], 3);
  EXPECT_EQ(lines[3]["observation"], "jumped");
  EXPECT_EQ(lines[4]["reason"], "jumped");
  EXPECT_EQ(lines[5]["observation"], "taken");
  EXPECT_EQ(lines[6]["passed"], 3);
  EXPECT_EQ(lines[7]["observation"], "late");
  const auto wrong = [&](const json& more, const std::string& message) {
    const Answer refused = guard("cart.yaml", observe(0.01, 0.1, more));
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
  };
  wrong({{"object", "cat"}}, "there is no object with a motion 'cat'; did you mean 'cart'?");
  wrong({{"orientation", {0, 0, 0, 2}}}, "a unit quaternion x y z w is expected");
  wrong({{"orientation", {0, 0, 1}}}, "a list of 4 numbers");
  wrong({{"turn_bound", -1}}, "observe.turn_bound is -1");
  wrong({{"speed_bound", -1}}, "observe.speed_bound is -1");
  wrong({{"vertices", json::array()}}, "'vertices' is no key");
}

TEST_F(GuardVerb, TakesCloudsAsTheyAreSeen) {
  std::string cloud = kSheet;
  cloud = cloud.substr(0, cloud.find("deforming:")) +
          "allowed: [[base, shelf]]\nobjects:\n  - name: shelf\n    cloud: {balls: [[0.85, 0, 0, "
          "0.01]]}\n"
          "    moving: {speed_bound: 0.1}\n";
  write("cloud.yaml", cloud);
  write("scan.xyz", "0.85 0 0\n0.86 0 0.01\n");
  const std::string still = "[[-1,0],[-1,0],[-1,0]]\n";
  const auto observe = [](double time, const json& more) {
    json seen = {{"object", "shelf"}, {"time", time}, {"speed_bound", 0.1}};
    seen.update(more);
    return json({{"observe", seen}}).dump() + "\n";
  };
  const json points = {{"points", {{0.85, 0, 0}, {0.9, nullptr, nullptr}}}, {"radius", 0.01}};
  const json nothing = {{"points", {{nullptr, nullptr, nullptr}}}, {"radius", 0.01}};
  const json balls = {
      {"balls", {{0, 0, 0, 0.01}}}, {"position", {0.85, 0, 0}}, {"orientation", {0, 0, 0, 1}}};
  const json file = {{"cloud", "scan.xyz"}, {"radius", 0.01}};
  const Answer answer =
      guard("cloud.yaml", still + observe(0.06, points) + still + observe(0.12, balls) + still +
                              observe(0.18, file) + still + observe(0.25, nothing) +
                              observe(0.1, points));
  EXPECT_EQ(answer.status, 2) << "a scan of nothing";
  const std::vector<json> lines = answer.lines();
  ASSERT_EQ(lines.size(), 9u);
  for (const std::size_t k : {0u, 2u, 4u, 6u}) EXPECT_EQ(lines[k]["passed"], 3) << k;
  for (const std::size_t k : {1u, 3u, 5u}) EXPECT_EQ(lines[k]["observation"], "taken") << k;
  EXPECT_EQ(lines[7]["observation"], "invalid");
  EXPECT_NE(lines[7]["message"].get<std::string>().find("has 0 balls, and is refused"),
            std::string::npos);
  EXPECT_NE(answer.err.find("standard input:8: observe: the cloud of 'shelf'"), std::string::npos);
  EXPECT_EQ(lines[8]["message"], nullptr);
  EXPECT_EQ(lines[7]["cloud"]["filters"][0]["removed"], 1);
  EXPECT_EQ(lines[8]["observation"], "late");
  EXPECT_EQ(lines[1]["cloud"]["balls"], 1);
  EXPECT_EQ(lines[1]["cloud"]["unseen"], "free");
  // The stop that follows a wrong line is proven against what was just seen.
  const json at_the_arm = {{"balls", {{0.2, -0.2, 0, 0.1}}}};
  for (const std::string& line : {std::string("{"), std::string("[[1]]"), std::string("[[null]]"),
                                  std::string("{\"time\": 1e300}")}) {
    const Answer free = guard("cloud.yaml", still + observe(0.02, points) + line + "\n");
    EXPECT_EQ(free.status, 2);
    EXPECT_EQ(free.lines()[2]["reason"], "invalid") << line;
    EXPECT_EQ(free.lines()[2]["certified"], true) << line;
    const Answer met = guard("cloud.yaml", still + observe(0.02, at_the_arm) + line + "\n");
    EXPECT_EQ(met.lines()[2]["certified"], false) << line;
  }
  // Points of the arm itself are left out; the others are thinned.
  const json scan = {{"points", {{0.135, -0.21, 0}, {0.85, 0, 0}, {0.851, 0, 0}, {0.852, 0, 0}}},
                     {"radius", 0.01},
                     {"position", {0, 0, 0}},
                     {"orientation", {0, 0, 0, 1}}};
  const auto with = [&](const json& more) {
    json all = scan;
    all.update(more);
    return all;
  };
  EXPECT_EQ(guard("cloud.yaml", observe(0, scan) + still).lines()[1]["passed"], 0);
  const json filters = {{"carve", {"robot"}},
                        {"carve_margin", 0.01},
                        {"state", {-1, 0}},
                        {"thin", 0.1},
                        {"most_balls", 1}};
  const Answer filtered = guard("cloud.yaml", observe(0, with(filters)) + still);
  EXPECT_EQ(filtered.status, 0) << filtered.err;
  EXPECT_EQ(filtered.lines()[1]["passed"], 3);
  const json cloud_seen = filtered.lines()[0]["cloud"];
  EXPECT_EQ(cloud_seen["balls"], 1);
  EXPECT_EQ(cloud_seen["filters"][0]["what"], "balls within 0.01 m of robot");
  EXPECT_EQ(cloud_seen["filters"][0]["removed"], 1);
  const auto wrong = [&](const json& more, const std::string& message) {
    const Answer refused = guard("cloud.yaml", observe(0.1, more));
    EXPECT_EQ(refused.status, 2) << message;
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
  };
  wrong({{"points", {{0, 0, 0}}}}, "observe has no 'radius'");
  wrong({{"points", {{0, 0}}}, {"radius", 0.01}}, "observe.points[0]");
  wrong({{"points", 3}, {"radius", 0.01}}, "observe.points is 3");
  wrong({{"points", {{0, 0, 0}}}, {"radius", 0}}, "radius");
  wrong({{"points", {{0, 0, 1e12}}}, {"radius", 0.01}}, "point 0 has the coordinate 1000000000000");
  wrong({{"balls", {{0, 0, 0}}}}, "observe.balls[0]");
  wrong({{"balls", {{0, 0, 0, 1}}}, {"radius", 1}}, "'radius' is no key");
  wrong({{"balls", {{0, 0, 0, 1}}}, {"position", {0, 0, 0}}}, "observe has no 'orientation'");
  wrong({{"cloud", "none.xyz"}, {"radius", 0.01}}, "none.xyz");
  wrong({{"cloud", 3}, {"radius", 0.01}}, "observe.cloud is no name of a file");
  wrong({{"object", "post"}, {"balls", {{0, 0, 0, 1}}}}, "no cloud with a motion 'post'");
  wrong({{"balls", {{0, 0, 0, 1}}}, {"speed_bound", -1}}, "observe.speed_bound is -1");
  wrong({{"balls", {{0, 0, 0, 1}, {0, 0, 0, -1}}}}, "observe.balls: ball 1 has the radius -1");
  wrong({{"balls", {{0, 0, 1e10, 1}}}}, "observe.balls: ball 0 has the coordinate");
  wrong(with({{"crop", 1}}), "observe.crop: what was cropped could come near");
  wrong(with({{"carve", {"robot"}}}), "observe: carve stands without a state");
  wrong(with({{"state", {0, 0}}}), "observe.state stands without carve");
  wrong(with({{"carve", "robot"}, {"state", {0, 0}}}), "observe.carve is no list of names");
  wrong(with({{"carve", json::array()}, {"state", {0, 0}}}), "carve is empty");
  wrong(with({{"carve", {"rbot"}}, {"state", {0, 0}}}), "'rbot'; did you mean 'robot'?");
  wrong(with({{"carve", {"shelf"}}, {"state", {0, 0}}}), "'shelf', which is a cloud");
  wrong(with({{"carve", {"robot"}}, {"state", {0}}}), "observe.state is [0]");
  wrong(with({{"carve", {"robot"}}, {"state", {9, 0}}}), "state within the limits is expected");
  wrong(with({{"carve", {"robot"}}, {"state", {0, 0}}, {"carve_margin", -1}}), "margin -1");
  wrong(with({{"thin", 0}}), "observe: thin: a cell of 0;");
  wrong(with({{"most_balls", 0}}), "most_balls is 0");
  wrong(with({{"most_balls", 1.5}}), "observe.most_balls is 1.5");
  json unplaced = with({{"carve", {"robot"}}, {"state", {0, 0}}});
  unplaced.erase("position");
  unplaced.erase("orientation");
  wrong(unplaced, "observe: carve stands without a pose");
}

TEST_F(GuardVerb, HelpExplainsEveryKey) {
  write("sheet.yaml", kSheet);
  const Answer answer = guard("reach.yaml", towardsThePost(5) + "\n[[9,9]]\n");
  std::set<std::string> keys;
  for (const json& line : answer.lines()) collectKeys(line, keys);
  for (const char* const key :
       {"observation", "cloud", "carve", "carve_margin", "state", "thin", "most_balls"})
    keys.insert(key);
  const std::string help = run("guard --help").out;
  for (const std::string& key : keys)
    EXPECT_TRUE(std::regex_search(help, std::regex("\\b" + key + "\\b"))) << key;
}

}  // namespace
}  // namespace leeway::tools::testing
