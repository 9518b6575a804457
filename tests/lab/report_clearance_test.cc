// `leeway report clearance`: small runs; times are not tested.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/lab/pictures.h"
#include "tests/support/build_paths.h"
#include "tests/support/command.h"
#include "tools/lab/clearance/clearance_report.h"

namespace leeway::tools::testing {
namespace {

using namespace report;

/// Sees by our own scene; measures by it, or nothing.
class OwnEngine : public StateEngine {
 public:
  explicit OwnEngine(bool measures) : measures_(measures) {}
  const char* name() const override { return "own"; }
  std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const override {
    return std::make_unique<Checker>(scene, measures_);
  }

 private:
  class Checker : public StateChecker {
   public:
    Checker(const collision::Scene& scene, bool measures)
        : scene_(scene), measures_(measures), workspace_(scene) {}
    bool isFree(std::span<const collision::Pose> X_WB) override {
      place(X_WB);
      return collision::decide(scene_, workspace_).verdict == collision::Verdict::kFree;
    }
    double distance(std::span<const collision::Pose> X_WB) override {
      if (!measures_) return StateChecker::distance(X_WB);
      place(X_WB);
      return collision::clearance(scene_, workspace_, 1e-4).clearance.lower;
    }

   private:
    void place(std::span<const collision::Pose> X_WB) {
      for (std::size_t b = 0; b < X_WB.size(); ++b)
        if (scene_.bodies()[b].moving) workspace_.setPose(static_cast<int>(b), X_WB[b]);
    }
    const collision::Scene& scene_;
    bool measures_;
    collision::Workspace workspace_;
  };
  bool measures_;
};

std::vector<ClearanceRow> measured(bool measures) {
  const std::string file = leeway::sourceFolder() + "/problems/bodies/window.yaml";
  const OwnEngine rival(measures);
  ClearanceReportOptions options;
  options.times = {0.3};
  options.samples = 300;
  return measureClearance({{file, "bodies", planner::loadProblem(file)}}, {&rival}, options);
}

TEST(ReportClearance, MeasuresBothObjectivesOfAllPlanners) {
  const std::vector<ClearanceRow> rows = measured(true);
  ASSERT_EQ(rows.size(), 8U);
  for (const ClearanceRow& row : rows) {
    EXPECT_FALSE(row.unsound) << row.planner;
    if (row.planner != "Leeway") continue;
    EXPECT_TRUE(row.solved());
    EXPECT_GT(row.length, 0);
    EXPECT_FALSE(row.colliding);
  }
  // How good they are is a matter of time.
  EXPECT_GT(rows[0].least, 0);
  EXPECT_GE(rows[4].integral, 0);
  EXPECT_LE(rows[4].integral, rows[4].length);
  EXPECT_EQ(rows[1].planner, "BIT*, own at 1 %");
  EXPECT_EQ(rows[2].planner, "PRM*, own at 1 %");
  EXPECT_EQ(rows[7].planner, "RRT*, own at 1 %");
  EXPECT_EQ(rows[7].objective, "integral");
  const auto table = clearanceTable(rows).rows();
  ASSERT_EQ(table.size(), 8U);
  EXPECT_TRUE(std::any_of(table.begin(), table.end(),
                          [](const auto& row) { return row[0] == "least, Leeway, 0.3"; }));
  EXPECT_NE(clearanceRows(rows).csv().find("integral,1,0.3,"), std::string::npos);
}

TEST(ReportClearance, WhatARivalDoesNotMeasureIsLeftOut) {
  const std::vector<ClearanceRow> rows = measured(false);
  ASSERT_EQ(rows.size(), 8U);
  for (const ClearanceRow& row : rows)
    EXPECT_EQ(row.status == "left out", row.planner != "Leeway") << row.status;
}

class ReportClearanceVerb : public CommandTest {};

TEST_F(ReportClearanceVerb, WritesARowARunAndAPicture) {
  const Answer answer =
      run("report clearance reach.yaml --times .05,.1 --no-rivals --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  EXPECT_EQ(answer.document()["rows"], 4);
  EXPECT_EQ(answer.document()["own_errors"], 0);
  EXPECT_EQ(read("out/clearance.csv").rfind("problem,planner,objective,seed,time_s", 0), 0U);
  if (hasPictures(answer.document())) expectPicture(read("out/clearance.svg"), 2);
}

TEST_F(ReportClearanceVerb, RefusesWhatItCannotUse) {
  expectRefused("report clearance nowhere.yaml", {"nowhere.yaml"});
  expectRefused("report clearance reach.yaml --times 0", {"times"});
  expectRefused("report clearance reach.yaml --hinge -1", {"hinge"});
}

}  // namespace
}  // namespace leeway::tools::testing
