// `leeway report growth`: small worlds; times are not tested.

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "tests/lab/pictures.h"
#include "tests/support/command.h"
#include "tools/lab/growth/growth_report.h"
#include "tools/lab/growth/growth_worlds.h"

namespace leeway::tools::testing {
namespace {

using namespace report;

/// What stands far away changes nothing but the cost: the path is the same, byte by byte.
TEST(ReportGrowth, FarBoxesDoNotChangeThePath) {
  const planner::PlanResult few = planner::plan(growthProblem("boxes", 10));
  const planner::PlanResult many = planner::plan(growthProblem("boxes", 300));
  ASSERT_EQ(few.status, planner::PlanStatus::kSolved);
  EXPECT_EQ(few.path.positions, many.path.positions);
  EXPECT_GT(few.path.positions.size(), 2U) << "the post is in the way";
  EXPECT_EQ(growthProblem("boxes", 300).world.objects.size(), 300U);
}

TEST(ReportGrowth, WorldsGrowInOneThing) {
  for (const std::int64_t triangles : {100, 5000}) {
    const planner::Problem problem = growthProblem("triangles", triangles);
    const auto& ring = problem.world.objects.back().geometries.front().shape;
    const auto made = static_cast<double>(ring.mesh()->triangles().size());
    EXPECT_NEAR(made / static_cast<double>(triangles), 1, 0.1);
    EXPECT_EQ(problem.world.objects.size(), 9U);
  }
  for (const std::int64_t points : {1000, 50000}) {
    const planner::Problem problem = growthProblem("points", points);
    ASSERT_EQ(problem.world.objects.size(), 1U);
    const auto made = static_cast<double>(problem.world.objects[0].cloud->size());
    EXPECT_NEAR(made / static_cast<double>(points), 1, 0.15);
  }
  for (const int joints : {2, 3, 7, 14}) {
    const planner::Problem problem = growthProblem("joints", joints);
    EXPECT_EQ(problem.robot.variables.size(), static_cast<std::size_t>(joints));
    const auto scene = std::make_shared<const planner::CompiledScene>(problem);
    planner::EdgeCertifier certifier(scene);
    std::vector<double> goal;
    for (const auto& range : problem.goals[0].ranges) goal.push_back(range.first);
    EXPECT_EQ(certifier.clearance(problem.start, 1e-3).verdict, planner::Verdict::kFree) << joints;
    EXPECT_EQ(certifier.clearance(goal, 1e-3).verdict, planner::Verdict::kFree) << joints;
    // The post is in the way of most arms.
    if (joints == 7) {
      EXPECT_EQ(certifier.certify(problem.start, goal).verdict, planner::Verdict::kNotFree);
    }
  }
}

/// Says free, and counts what it is asked.
class Counting : public StateEngine {
 public:
  const char* name() const override { return "counting"; }
  std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const override {
    if (scene.bodies().size() > 30) return nullptr;
    return std::make_unique<Checker>(asked);
  }
  mutable int asked = 0;

 private:
  class Checker : public StateChecker {
   public:
    explicit Checker(int& asked) : asked_(asked) {}
    bool isFree(std::span<const collision::Pose>) override { return ++asked_ > 0; }

   private:
    int& asked_;
  };
};

TEST(ReportGrowth, ARivalWalksTheSameEdges) {
  const Counting rival;
  GrowthReportOptions options;
  options.counts = {{"boxes", {8, 60}}};
  options.edges = 20;
  options.rounds = 1;
  const std::vector<GrowthRow> rows = measureGrowth({&rival}, options);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].status, "solved");
  EXPECT_EQ(rows[1].status, "measured");
  EXPECT_EQ(rows[1].edges, rows[0].edges);
  EXPECT_GE(rival.asked, rows[1].edges);
  EXPECT_EQ(rows[3].status, "left out");
  EXPECT_EQ(growthTable(rows).rows().back().back(), "left out");
}

TEST(ReportSensed, CountsAnswersThatTheTruthRefutes) {
  const Counting rival;  // says free, always
  GrowthReportOptions options;
  options.counts = {{"points", {1000}}};
  options.edges = 40;
  options.rounds = 1;
  const std::vector<GrowthRow> rows = measureGrowth({&rival}, options);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].status, "solved");
  EXPECT_EQ(rows[0].states, 2 * rows[0].edges) << "before and after a region was renewed";
  EXPECT_EQ(rows[0].too_high + rows[0].too_low, 0);
  EXPECT_EQ(rows[1].states, rows[1].edges);
  EXPECT_GT(rows[1].too_high, 0) << "some edges go through a post";
  EXPECT_EQ(rows[1].too_low, 0);
}

class ReportGrowthVerb : public CommandTest {};

TEST_F(ReportGrowthVerb, WritesARowAWorldAndPictures) {
  const Answer answer =
      run("report growth --boxes 20 10 --triangles 200 --joints 3 --edges 5 --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["own_errors"], 0);
  std::istringstream csv(read("out/growth.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "family,count,engine,status,make_s,change_s,bytes,edges,edge_us,plan_s");
  std::size_t rows = 0, own = 0;
  for (; std::getline(csv, line); ++rows) own += line.find(",Leeway,solved,") != std::string::npos;
  EXPECT_EQ(rows, told["rows"]);
  EXPECT_EQ(own, 4U);
  if (hasPictures(told)) expectPicture(read("out/growth.svg"), 3 * 4);
}

TEST_F(ReportGrowthVerb, SensedWritesARowACloudAndPictures) {
  const Answer answer = run("report sensed --points 2000,1000 --edges 20 --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["own_errors"], 0);
  const std::string csv = read("out/sensed.csv");
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "points,engine,status,make_s,change_s,bytes,edges,edge_us,edge_median_us,plan_s,states,"
            "too_high,too_low");
  EXPECT_NE(csv.find("\n1000,Leeway,solved,"), std::string::npos);
  if (told["missing"].dump().find("nanoflann") == std::string::npos) {
    const std::size_t rival = csv.find("\n1000,nanoflann,measured,");
    ASSERT_NE(rival, std::string::npos) << csv;
    EXPECT_EQ(csv.substr(csv.find('\n', rival + 1) - 6, 6), "20,0,0") << "states, all right";
  }
  if (hasPictures(told)) expectPicture(read("out/sensed.svg"), 5);
}

TEST_F(ReportGrowthVerb, RefusesWhatItCannotUse) {
  expectRefused("report growth --boxes 2", {"--boxes", "8"});
  expectRefused("report growth --joints 1", {"--joints"});
  expectRefused("report sensed --points 10", {"--points", "100"});
  expectRefused("report growth --family zebras", {"zebras", "triangles"});
}

}  // namespace
}  // namespace leeway::tools::testing
