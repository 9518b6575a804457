#include "planner/search/connect_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// A flying box on its way around two walls, whose openings are small.
Problem flight(std::uint64_t seed) {
  Problem problem =
      test::problemOf(test::flyingBox(), {-0.8, 0, 0, 0, 0, 0, 1}, {0.8, 0, 0, 0, 0, 0, 1});
  problem.world.objects.push_back(test::box("near wall", {0.02, 0.85, 1.2}, -0.3, -0.3, 0));
  problem.world.objects.push_back(test::box("far wall", {0.02, 0.85, 1.2}, 0.3, 0.3, 0));
  problem.seed = seed;
  problem.limits.time = 60;
  return problem;
}

PlanResult planWith(Problem problem, const std::map<std::string, std::string>& parameters) {
  problem.planner.parameters = parameters;
  return plan(problem);
}

auto answerOf(const PlanResult& result) {
  return std::tuple(result.status, result.path.positions, result.iterations, result.states,
                    result.edges, result.undecided_edges, result.distance_queries);
}

TEST(ConnectSearch, WorkersGiveTheSameAnswerForAnyNumberOfThreads) {
  int earlier = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Problem problem = flight(seed);
    const PlanResult one = planWith(problem, {{"workers", "5"}, {"threads", "1"}});
    ASSERT_EQ(one.status, PlanStatus::kSolved) << "seed " << seed;
    EXPECT_TRUE(one.certificate.certified);
    for (const char* threads : {"2", "3", "8", "0"}) {
      const PlanResult more = planWith(problem, {{"workers", "5"}, {"threads", threads}});
      EXPECT_TRUE(answerOf(more) == answerOf(one)) << "seed " << seed << ", threads " << threads;
    }
    // The first worker is what one alone would be.
    const PlanResult alone = planWith(problem, {});
    EXPECT_LE(one.iterations, alone.iterations);
    earlier += one.iterations < alone.iterations;
    if (one.iterations == alone.iterations) {
      EXPECT_EQ(one.path.positions, alone.path.positions);
    }
  }
  EXPECT_GE(earlier, 10);
}

TEST(ConnectSearch, AnIterationLimitHoldsForEachWorker) {
  Problem problem = test::wallProblem();
  problem.world.objects.push_back(
      test::box("plug", {0.05, 0.6, 0.5}, 0, 1.2, 0));  // closes the gap
  problem.limits.iterations = 300;
  std::uint64_t edges = 0;
  for (const char* threads : {"1", "2", "8"}) {
    const PlanResult result = planWith(problem, {{"workers", "3"}, {"threads", threads}});
    EXPECT_EQ(result.status, PlanStatus::kUnsolved);
    EXPECT_EQ(result.iterations, 300u);
    if (edges > 0) {
      EXPECT_EQ(result.edges, edges);
    }
    edges = result.edges;
  }
  EXPECT_GT(edges, planWith(problem, {}).edges);
}

TEST(ConnectSearch, ClearanceTakesWorkersToo) {
  Problem problem = test::corridorProblem();
  problem.objective = MaximumClearance{};
  problem.limits.iterations = 3000;
  problem.limits.time = 0;
  const PlanResult one = planWith(problem, {{"workers", "3"}, {"threads", "1"}});
  ASSERT_EQ(one.status, PlanStatus::kSolved);
  EXPECT_GT(one.certificate.clearance.lower, 0.5);
  EXPECT_TRUE(answerOf(planWith(problem, {{"workers", "3"}, {"threads", "4"}})) == answerOf(one));
}

TEST(ConnectSearch, StopsWhenAsked) {
  Problem problem = test::wallProblem();
  problem.world.objects.push_back(test::box("plug", {0.05, 0.6, 0.5}, 0, 1.2, 0));
  problem.planner.parameters = {{"workers", "4"}, {"threads", "4"}};
  int asked = 0;
  PlanOptions options;
  options.stop = [&asked] { return ++asked > 200; };
  EXPECT_EQ(plan(problem, options).status, PlanStatus::kUnsolved);
}

TEST(ConnectSearch, RefusesNumbersThatAreNoCounts) {
  for (const char* value : {"0", "-1", "1.5", "65", "many", ""})
    EXPECT_NE(plannerError("Connect", {{"workers", value}}), std::nullopt) << value;
  for (const char* value : {"1", "64"})
    EXPECT_EQ(plannerError("Connect", {{"workers", value}}), std::nullopt) << value;
  EXPECT_EQ(plannerError("Connect", {{"threads", "0"}}), std::nullopt);
  EXPECT_NE(plannerError("RRTConnect", {{"workers", "2"}}), std::nullopt);
  const std::vector<PlannerParameter> parameters = plannerParameters("Connect");
  EXPECT_TRUE(std::is_sorted(parameters.begin(), parameters.end(),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));
  EXPECT_EQ(std::count_if(parameters.begin(), parameters.end(),
                          [](const auto& p) { return p.name == "workers"; }),
            1);
}

}  // namespace
}  // namespace leeway::planner
