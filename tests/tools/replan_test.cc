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

/// Keys of a document and its nested values, including "obstacles[]".
void collectKeys(const json& value, std::set<std::string>& keys) {
  if (value.is_array())
    for (const json& entry : value) collectKeys(entry, keys);
  if (!value.is_object()) return;
  for (const auto& [key, below] : value.items()) {
    keys.insert(key);
    collectKeys(below, keys);
  }
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
                    end = help.find("Limits", middle);
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
      if (line.contains("obstacles")) {
        line["obstacles"][0].erase("update_s");
      }
    }
    return lines;
  };
  EXPECT_EQ(withoutCosts(), withoutCosts());
}

TEST_F(Replan, TextAndLimits) {
  const Answer text = run("replan gate.yaml --text");
  EXPECT_EQ(text.status, 0);
  for (const char* word :
       {"gate: reached", "wait", "plan", ", certified; every step kept", "seed 3"}) {
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
  expectRefused("replan gate.yaml --output x.txt", {".csv"});
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
