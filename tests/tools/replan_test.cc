#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <set>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

/// A sheet blocks the arm for a second, then rises.
const char* const kGate = R"(leeway: 1
name: gate
robot: {urdf: arm.urdf, srdf: arm.srdf, group: arm}
start: right
goal: left
deforming:
  - name: sheet
    position: [0.55, 0, 0]
    rpy: [1.5707963267948966, 0, 0]
    grid: {size: [1, 0.4], cells: [8, 4]}
    margin: 0.01
    motion:
      morph:
        references: [{}, {bumps: [{center: [0, 0, 0], radius: 99, by: [0, 0.6, 0]}]}]
        keys: [{time: 1, weights: [1, 0]}, {time: 2, weights: [0, 1]}]
allowed: [[base, sheet]]
limits: {time: 20, iterations: 200}
execution: {duration: 8}
seed: 3
)";

class Replan : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("gate.yaml", kGate);
  }
};

TEST_F(Replan, TellsEveryStepAndTheEnd) {
  const Answer answer = run("replan gate.yaml --output executed.csv");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.err, "");
  const std::vector<json> lines = answer.lines();
  ASSERT_GT(lines.size(), 20u);
  const json& end = lines.back();
  EXPECT_EQ(end["status"], "reached");
  EXPECT_EQ(end["certified"], true);
  EXPECT_EQ(end["seed"], 3);
  EXPECT_EQ(end["steps"], lines.size() - 1);
  EXPECT_GT(end["waits"], 10);
  EXPECT_GE(end["plans"], 1);
  EXPECT_GT(end["clearance_lower"], 0);
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    const json& line = lines[i];
    EXPECT_EQ(line["step"], i);
    EXPECT_NEAR(line["time"].get<double>(), 0.05 * static_cast<double>(i), 1e-9);
    EXPECT_EQ(line["certified"], true);
    EXPECT_EQ(line["obstacles"][0]["name"], "sheet");
    EXPECT_NE(line["obstacles"][0]["strategy"], "auto");
    EXPECT_EQ(line["obstacles"][0]["reason"], "the motion bounds its own nodes");
    EXPECT_GE(line["clearance_upper"], line["clearance_lower"]);
    EXPECT_GE(line["time_s"]["update"], 0);
    EXPECT_EQ(line["position"].size(), 2u);
  }
  EXPECT_EQ(lines[0]["decision"], "wait");
  EXPECT_EQ(lines[lines.size() - 2]["reached"], true);
  const std::string csv = read("executed.csv");
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "time,shoulder,elbow");
  EXPECT_EQ(csv.substr(csv.find('\n') + 1, 6), "0,-1,0");
}

TEST_F(Replan, HelpTellsEveryKey) {
  const std::vector<json> lines = run("replan gate.yaml").lines();
  ASSERT_GT(lines.size(), 2u);
  std::set<std::string> of_steps, of_end;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) collectKeys(lines[i], of_steps);
  collectKeys(lines.back(), of_end);
  EXPECT_TRUE(of_steps.count("reason") == 1 && of_steps.count("broken") == 1);
  EXPECT_TRUE(of_end.count("longest_step"));
  const std::string help = run("replan --help").out;
  const std::size_t begin = help.find("JSON, a document a step"),
                    middle = help.find("and at the end, with version:", begin),
                    end = help.find("The limits", middle);
  ASSERT_TRUE(begin < middle && middle < end && end < help.size()) << help;
  const auto told = [](const std::string& text, const std::string& key) {
    return std::regex_search(text, std::regex("\\b" + key + "\\b"));
  };
  for (const std::string& key : of_steps)
    EXPECT_TRUE(told(help.substr(begin, middle - begin), key)) << key;
  for (const std::string& key : of_end)
    EXPECT_TRUE(told(help.substr(middle, end - middle), key)) << key;
}

TEST_F(Replan, TheSameSeedSaysTheSame) {
  const auto withoutCosts = [&] {
    std::vector<json> lines = run("replan gate.yaml --json").lines();
    for (json& line : lines) {
      line.erase("time_s");
      line.erase("sum");
      if (line.contains("obstacles")) {
        line["obstacles"][0].erase("update_s");
      }
    }
    return lines;
  };
  EXPECT_EQ(withoutCosts(), withoutCosts());
}

/// The log of an execution is proven again; a log that was cut or changed is not.
TEST_F(Replan, TheLogIsProven) {
  EXPECT_EQ(run("replan gate.yaml --text --output run.jsonl").status, 0);
  const std::string log = read("run.jsonl");
  const Answer proven = run("verify gate.yaml --log run.jsonl --json");
  EXPECT_EQ(proven.status, 0) << proven.err << proven.out;
  EXPECT_EQ(proven.document()["status"], "certified");
  EXPECT_GT(proven.document()["clearance_lower"], 0.01);
  EXPECT_TRUE(proven.document()["where"].is_null());
  const Answer text = run("verify gate.yaml --log run.jsonl");
  EXPECT_EQ(text.status, 0);
  EXPECT_NE(text.flat().find("certified, all steps of run.jsonl, least clearance"),
            std::string::npos)
      << text.out;
  EXPECT_NE(text.flat().find("the obstacles moved within what is known of them"),
            std::string::npos);
  // What --json prints is the same log.
  write("stdout.jsonl", run("replan gate.yaml --json").out);
  EXPECT_EQ(run("verify gate.yaml --log stdout.jsonl").status, 0);

  const std::size_t last = log.rfind('\n', log.size() - 2) + 1;
  const auto lines = static_cast<int>(std::count(log.begin(), log.end(), '\n'));
  write("cut.jsonl", log.substr(0, last));
  const Answer cut = run("verify gate.yaml --log cut.jsonl --json");
  EXPECT_EQ(cut.status, 1);
  EXPECT_EQ(cut.document()["status"], "undecided");
  EXPECT_EQ(cut.document()["where"]["line"], lines - 1);
  EXPECT_NE(cut.document()["reason"].get<std::string>().find("cut"), std::string::npos);
  write("within.jsonl", log.substr(0, last - 9));
  expectRefused("verify gate.yaml --log within.jsonl",
                {fmt::format("within.jsonl:{}: ", lines - 1), "it was cut or changed"});
  std::string changed = log;
  changed.replace(changed.find("\"decision\":\"wait\""), 17, "\"decision\":\"plan\"");
  write("changed.jsonl", changed);
  expectRefused("verify gate.yaml --log changed.jsonl",
                {"changed.jsonl:1: ", "was changed after it was written"});
  write("missing.jsonl", log.substr(log.find('\n') + 1));
  const Answer missing = run("verify gate.yaml --log missing.jsonl");
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.flat().find("refuted: line 1 at 0.05 s: step 1 is where step 0 is expected"),
            std::string::npos)
      << missing.out;
  // A sheet that stays where it is: the robot drove through it.
  std::string closed = kGate;
  closed.replace(closed.find("{time: 1,"), 9, "{time: 5,");
  closed.replace(closed.find("{time: 2,"), 9, "{time: 9,");
  write("closed.yaml", closed);
  const Answer hit = run("verify closed.yaml --log run.jsonl --json");
  EXPECT_EQ(hit.status, 1);
  EXPECT_EQ(hit.document()["status"], "refuted");
  EXPECT_EQ(hit.document()["where"]["b"], "sheet");
}

TEST_F(Replan, ALogThatIsExposedIsNotCertified) {
  write("exposed.yaml",
        std::string(kGate) +
            "objects:\n  - {name: cart, position: [3, 0, 0], box: {size: [0.1, 0.1, "
            "0.1]}, moving: {speed_bound: 500, turn_bound: 0}}\n");
  EXPECT_EQ(run("replan exposed.yaml --text --output run.jsonl").status, 1);
  const Answer answer = run("verify exposed.yaml --log run.jsonl --json");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.document()["status"], "exposed");
  EXPECT_EQ(answer.document()["where"]["line"], 1);
  EXPECT_TRUE(answer.document()["clearance_lower"].is_null());
  const Answer text = run("verify exposed.yaml --log run.jsonl");
  EXPECT_NE(text.flat().find("exposed: line 1 between 0 s and 0.05 s: the robot stands where"),
            std::string::npos)
      << text.out;
}

TEST_F(Replan, LogsNeedAProblemAndNothingElse) {
  EXPECT_EQ(run("replan gate.yaml --steps 2 --json --output run.jsonl").status, 1);
  expectRefused("verify gate.yaml run.jsonl --log run.jsonl", {"with --log, a problem file alone"});
  expectRefused("verify --log run.jsonl", {"with --log, a problem file alone"});
  expectRefused("verify gate.yaml --log run.jsonl --shortest", {"--log", "--shortest"});
  expectRefused("verify gate.yaml --log run.jsonl --ends exact", {"--log", "--ends"});
  expectRefused("verify gate.yaml --log nowhere.jsonl", {"nowhere.jsonl: "});
  expectRefused("verify reach.yaml --log run.jsonl", {"run.jsonl:3: ", "'gate'"});
  write("empty.jsonl", "");
  expectRefused("verify gate.yaml --log empty.jsonl", {"empty.jsonl: ", "is empty"});
}

TEST_F(Replan, TextAndLimits) {
  const Answer text = run("replan gate.yaml --text");
  EXPECT_EQ(text.status, 0);
  for (const char* word :
       {"gate: reached", "wait", "plan", ", certified; least clearance", "seed 3"}) {
    EXPECT_NE(text.out.find(word), std::string::npos) << word << "\n" << text.out;
  }
  const Answer few = run("replan gate.yaml --steps 4 --seed 5");
  EXPECT_EQ(few.status, 1);
  EXPECT_EQ(few.lines().size(), 5u);
  EXPECT_EQ(few.lines().back()["status"], "stopped");
  EXPECT_EQ(few.lines().back()["seed"], 5);
}

TEST_F(Replan, WhatDoesNotDeformIsExecutedToo) {
  const Answer answer = run("replan reach.yaml");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.lines().back()["replans"], 0);
  EXPECT_EQ(answer.lines().back()["waits"], 0);
}

TEST_F(Replan, BadInputIsStatus2) {
  expectRefused("replan gate.yaml --steps -1", {"--steps"});
  expectRefused("replan gate.yaml --json --text", {"--json", "--text"});
  expectRefused("replan gate.yaml --output x.txt", {".csv", ".jsonl"});
  expectRefused("replan gate.yaml --output nowhere/x.csv", {"nowhere"});
  std::string broken = kGate;
  broken.replace(broken.find("[1, 0]}"), 7, "[1]}");
  write("broken.yaml", broken);
  expectRefused("replan broken.yaml", {"broken.yaml:14", "motion.morph"});
  expectRefused("plan broken.yaml", {"broken.yaml:14", "motion.morph"});
}

/// The other verbs see the sheet at the start.
TEST_F(Replan, OtherVerbsLookAtTheStart) {
  EXPECT_EQ(run("plan gate.yaml --json").document()["status"], "unsolved");
  std::string later = kGate;
  later.replace(later.find("{duration: 8}"), 13, "{start: 2}");
  write("later.yaml", later);
  EXPECT_EQ(run("plan later.yaml --output path.json").status, 0);
  EXPECT_EQ(run("verify later.yaml path.json").status, 0);
  EXPECT_EQ(run("verify gate.yaml path.json").status, 1);
  EXPECT_EQ(run("clearance later.yaml path.json").status, 0);
  const json state = run("check gate.yaml --state shoulder=0.1 --json").document();
  EXPECT_TRUE(state.is_object());
  const json info = run("info gate.yaml --json").document();
  EXPECT_EQ(info["problem"]["deforming"][0]["name"], "sheet");
  EXPECT_EQ(info["problem"]["deforming"][0]["triangles"], 64);
  EXPECT_EQ(info["problem"]["deforming"][0]["motion"], "morph");
  EXPECT_GT(info["problem"]["deforming"][0]["bytes"], 1000);
  EXPECT_NE(run("info gate.yaml").out.find("sheet"), std::string::npos);
}

}  // namespace
}  // namespace leeway::tools::testing
