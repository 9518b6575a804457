// `leeway report planning`: small runs; times are not tested.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/build_paths.h"
#include "tests/support/command.h"
#include "tools/lab/planning/planning_report.h"

namespace leeway::tools::testing {
namespace {

using namespace report;

/// Sees nothing, or, by our own scene, all.
class TestEngine : public StateEngine {
 public:
  enum class Sight { kBlind, kTrue, kNone };
  explicit TestEngine(Sight sight) : sight_(sight) {}
  const char* name() const override { return sight_ == Sight::kBlind ? "blind" : "true"; }
  std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const override {
    if (sight_ == Sight::kNone) return nullptr;
    return std::make_unique<Checker>(scene, sight_ == Sight::kBlind);
  }

 private:
  class Checker : public StateChecker {
   public:
    Checker(const collision::Scene& scene, bool blind)
        : scene_(scene), blind_(blind), workspace_(scene) {}
    bool isFree(std::span<const collision::Pose> X_WB) override {
      if (blind_) return true;
      for (std::size_t b = 0; b < X_WB.size(); ++b)
        if (scene_.bodies()[b].moving) workspace_.setPose(static_cast<int>(b), X_WB[b]);
      return collision::decide(scene_, workspace_).verdict == collision::Verdict::kFree;
    }

   private:
    const collision::Scene& scene_;
    bool blind_;
    collision::Workspace workspace_;
  };
  Sight sight_;
};

std::vector<PlanningRow> measured(TestEngine::Sight sight) {
  const std::string file = leeway::sourceFolder() + "/problems/bodies/window.yaml";
  const TestEngine rival(sight);
  PlanningReportOptions options;
  options.seeds = 2;
  return measurePlanning({{file, "bodies", planner::loadProblem(file)}}, {&rival}, options);
}

TEST(ReportPlanning, PathsThatCollideAreCounted) {
  const std::vector<PlanningRow> rows = measured(TestEngine::Sight::kBlind);
  ASSERT_EQ(rows.size(), 4U);
  for (const PlanningRow& row : rows) {
    EXPECT_TRUE(row.solved());
    EXPECT_EQ(row.colliding, row.planner != "Leeway") << row.planner;
    EXPECT_GT(row.length, 0);
  }
  EXPECT_EQ(rows[2].seed, 2U);
  EXPECT_NE(rows[0].length, rows[2].length);
}

TEST(ReportPlanning, ARivalThatSeesPlansAPath) {
  const std::vector<PlanningRow> rows = measured(TestEngine::Sight::kTrue);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1].planner, "RRTConnect, true at 1 %");
  for (const std::size_t i : {1U, 3U}) EXPECT_TRUE(rows[i].solved());
  EXPECT_GT(rows[1].length, 2);
  const auto table = planningTable(rows).rows();
  ASSERT_EQ(table.size(), 4U);
  EXPECT_EQ(table[0][0], "bodies, Leeway");
  EXPECT_EQ(table[2][0], "all, Leeway");
  EXPECT_EQ(slowestRuns(rows).rows().size(), 2U);
}

TEST(ReportPlanning, WhatARivalLacksIsLeftOut) {
  const std::vector<PlanningRow> rows = measured(TestEngine::Sight::kNone);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1].status, "left out");
  EXPECT_TRUE(rows[0].solved());
}

class ReportPlanningVerb : public CommandTest {};

TEST_F(ReportPlanningVerb, WritesARowARun) {
  const Answer answer = run("report planning reach.yaml --seeds 2 --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["own_errors"], 0);
  std::istringstream csv(read("out/planning.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line.rfind("problem,planner,seed,status,compile_s,plan_s", 0), 0U) << line;
  std::size_t rows = 0, own = 0;
  for (; std::getline(csv, line); ++rows)
    own += line.find(",Leeway,") != std::string::npos && line.find(",solved,") != std::string::npos;
  EXPECT_EQ(rows, told["rows"]);
  EXPECT_EQ(own, 2U);
}

TEST_F(ReportPlanningVerb, LeavesRowsWhereItIsInterrupted) {
  const Answer answer =
      shell("timeout -s INT 1 '" + leeway::commandFile() +
            "' report planning reach.yaml --seeds 10000 --no-rivals --output out");
  EXPECT_NE(answer.status, 0);
  EXPECT_EQ(answer.out, "");
  EXPECT_NE(answer.err.find("interrupted: out/planning.csv.partial holds the rows so far"),
            std::string::npos)
      << answer.err;
  EXPECT_FALSE(fs::exists(path("out/planning.csv")));
  const std::string csv = read("out/planning.csv.partial");
  EXPECT_EQ(csv.rfind("problem,planner,seed,", 0), 0U) << csv;
  EXPECT_EQ(csv.back(), '\n');
  EXPECT_EQ(csv.find("problem,planner", 1), std::string::npos);
  EXPECT_GT(std::count(csv.begin(), csv.end(), '\n'), 2);
  // The next run puts whole rows in its place.
  ASSERT_EQ(run("report planning reach.yaml --no-rivals --output out").status, 0);
  EXPECT_FALSE(fs::exists(path("out/planning.csv.partial")));
  EXPECT_TRUE(fs::exists(path("out/planning.csv")));
}

TEST_F(ReportPlanningVerb, RefusesWhatItCannotUse) {
  expectRefused("report planning nowhere.yaml", {"nowhere.yaml"});
  expectRefused("report planning reach.yaml --seeds 0", {"seeds"});
  expectRefused("report planning reach.yaml --srdf a.srdf", {"--robot"});
  expectRefused("report planning reach.yaml --time -1", {"time"});
}

}  // namespace
}  // namespace leeway::tools::testing
