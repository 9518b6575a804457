// Paths of least cost for length and nearness, and wishes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "leeway/planner/ompl_objectives.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/robots/input_error.h"
#include "planner/objective/nearness.h"
#include "planner/objective/path_cost.h"
#include "tests/support/sanitized.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using Waypoints = std::vector<std::vector<double>>;

/// The cost of a path from samples of the distance engine alone.
double denseCost(const Problem& problem, const MinimumCost& cost, const Waypoints& path) {
  const auto compiled = std::make_shared<const CompiledScene>(problem);
  double sum = 0;
  std::vector<double> worst(cost.terms.size(), 0);
  std::vector<double> q(path[0].size());
  for (std::size_t t = 0; t < cost.terms.size(); ++t) {
    const CostTerm& term = cost.terms[t];
    EdgeCertifier certifier(compiled->withPairs([&](const collision::ScenePair& pair) {
      return term.of == Pairs::kAll || compiled->isOfRobot(pair) == (term.of == Pairs::kSelf);
    }));
    for (std::size_t i = 1; i < path.size(); ++i) {
      constexpr int kSamples = 2000;
      double mean = 0;
      for (int k = 0; k < kSamples; ++k) {
        compiled->space().interpolate(path[i - 1], path[i], (k + 0.5) / kSamples, q);
        const double near = nearnessAt(term.nearness, certifier.clearance(q, 1e-9).clearance.upper);
        mean += near / kSamples;
        worst[t] = std::max(worst[t], near);
      }
      if (!term.worst) sum += term.weight * compiled->space().distance(path[i - 1], path[i]) * mean;
    }
    if (term.worst) sum += term.weight * worst[t];
  }
  for (std::size_t i = 1; i < path.size(); ++i)
    sum += cost.length * compiled->space().distance(path[i - 1], path[i]);
  return sum;
}

void expectHonestCost(const Problem& problem, const PlanResult& result) {
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  const double dense =
      denseCost(problem, std::get<MinimumCost>(problem.objective), result.path.positions);
  EXPECT_LE(result.cost.lower, dense + 1e-4);
  EXPECT_GE(result.cost.upper, dense - 1e-4);
  EXPECT_LE(result.cost.width(), 0.011 * result.cost.upper + 1e-4);
}

Problem costProblem() {
  Problem problem = test::corridorProblem();
  problem.objective = MinimumCost{1, {{{Nearness::Kind::kHinge, 0.4}, 4}}};
  problem.limits.time = 0;
  problem.limits.iterations = 20000;
  return problem;
}

class CheapestPath : public testing::TestWithParam<std::string> {};

TEST_P(CheapestPath, CostsLessThanTheShortestAndWhatItSays) {
  Problem problem = costProblem();
  const MinimumCost cost = std::get<MinimumCost>(problem.objective);
  problem.objective = MinimumLength{};
  const PlanResult shortest = plan(problem);
  ASSERT_EQ(shortest.status, PlanStatus::kSolved);
  const double of_shortest = denseCost(problem, cost, shortest.path.positions);
  problem.objective = cost;
  problem.planner.name = GetParam();
  const PlannerTraits& traits = *findPlanner(GetParam());
  // Each iteration of the RRT* kind computes the costs of edges to all near nodes.
  const bool is_dear = GetParam().find("RRT") != std::string::npos || GetParam() == "LazyPRMstar";
  if (traits.optimizing) problem.limits.iterations = is_dear ? 60 : 1500;
  if (!traits.deterministic) {  // ends by the clock
    problem.limits.iterations = 0;
    problem.limits.time = kSanitized ? 6 : 0.6;
  }
  const PlanResult result = plan(problem);
  expectHonestCost(problem, result);
  EXPECT_LT(result.cost.upper, of_shortest);
  if (GetParam() == "Connect") {
    EXPECT_LT(result.cost.upper, 4.85) << "below the block, where all planners find about 4.77";
    EXPECT_EQ(plan(problem).path.positions, result.path.positions);
  }
}

INSTANTIATE_TEST_SUITE_P(Planners, CheapestPath,
                         testing::Values("Connect", "RRTConnect", "RRTstar", "RRTsharp",
                                         "RRTXstatic", "InformedRRTstar", "SORRTstar", "BITstar",
                                         "ABITstar", "AITstar", "LazyPRMstar", "PRMstar", "SST",
                                         "CForest", "LazyRRT"),
                         [](const auto& each) { return each.param; });

TEST(CheapestPathAlone, CountsItsWorstPlaceAndSeveralTerms) {
  Problem problem = costProblem();
  problem.objective = MinimumCost{0.5,
                                  {{{Nearness::Kind::kHinge, 0.5}, 3, true},
                                   {{Nearness::Kind::kInverse, 0.05}, 1},
                                   {{Nearness::Kind::kHinge, 0.1}, 1, false, Pairs::kAll}}};
  const PlanResult result = plan(problem);
  expectHonestCost(problem, result);
  problem.planner.simplify = false;
  const PlanResult raw = plan(problem);
  expectHonestCost(problem, raw);
  EXPECT_LT(result.cost.upper, raw.cost.lower);
}

TEST(CheapestPathAlone, AnIntegralAloneCanBeNothing) {
  Problem problem = costProblem();
  problem.objective = MinimumCost{0, {{{Nearness::Kind::kHinge, 0.2}, 1}}};
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(result.cost.upper, 0);
  EXPECT_GE(result.certificate.world.clearance.upper, 0.2);
  EXPECT_STREQ(toString(problem.objective), "integral");
}

TEST(CheapestPathAlone, PlannersThatCannotAreRefusedByName) {
  Problem problem = costProblem();
  problem.planner.name = "LBTRRT";
  const auto message = [&] {
    try {
      plan(problem);
    } catch (const robots::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message().find("planner 'LBTRRT' adds up lengths"), std::string::npos) << message();
  EXPECT_NE(message().find("BITstar"), std::string::npos);
  problem.planner.name = "BITstar";
  problem.objective = MinimumCost{1, {{{Nearness::Kind::kHinge, 0.2}, 1, true}}};
  EXPECT_NE(message().find("worst place of a path does not add up"), std::string::npos);
  EXPECT_EQ(message().find("RRTstar"), std::string::npos) << message();
  EXPECT_NE(message().find("one of Connect, RRTConnect"), std::string::npos);
  problem.planner.name = "Connect";
  problem.objective = MinimumCost{};
  EXPECT_NE(message().find("weighs nothing"), std::string::npos);
  problem.objective = MinimumCost{1, {{{Nearness::Kind::kHinge, 0}, 1}}};
  EXPECT_NE(message().find("length above 0"), std::string::npos);
  problem.objective = MaximumClearance{};
  problem.margins.wishes = {{"disc and block", {{"disc", "block"}}, 0.3}};
  EXPECT_NE(message().find("beside the objective clearance"), std::string::npos);
}

TEST(Wishes, AreKeptWhereThatIsNotTooDear) {
  Problem problem = test::corridorProblem();
  problem.limits.time = 0;
  problem.limits.iterations = 20000;
  const PlanResult plain = plan(problem);
  EXPECT_TRUE(std::isinf(plain.cost.upper));
  EXPECT_TRUE(plain.wishes.empty());
  Wish wish{"disc and ceiling", {{"disc", "ceiling"}}, 0.3};
  for (const double weight : {0.01, 100.0}) {
    wish.weight = weight;
    problem.margins.wishes = {wish};
    const PlanResult result = plan(problem);
    ASSERT_EQ(result.status, PlanStatus::kSolved);
    ASSERT_EQ(result.wishes.size(), 1U);
    const WishResult& told = result.wishes[0];
    ASSERT_TRUE(told.kept.has_value());
    EXPECT_EQ(*told.kept, weight > 1) << "above the block there is no room for it";
    if (*told.kept) {
      EXPECT_GE(told.clearance.lower, 0.3);
      EXPECT_EQ(told.cost.upper, 0);
    } else {
      EXPECT_LT(told.clearance.upper, 0.3);
      EXPECT_GT(told.cost.lower, 0);
      EXPECT_LT(result.length, plain.length * 1.1);
    }
    const Interval sum{result.length + told.cost.lower, result.length + told.cost.upper};
    EXPECT_LE(result.cost.lower, sum.upper);
    EXPECT_GE(result.cost.upper, sum.lower);
  }
}

/// If the start is a goal, the path is a single place, which may be nearer than wished.
TEST(Wishes, OfAPlaceAreLookedAt) {
  Problem problem = test::corridorProblem();
  problem.goals[0].ranges.clear();
  for (const int v : problem.robot.variables) {
    const double q = problem.start[static_cast<std::size_t>(v)];
    problem.goals[0].ranges.emplace_back(q, q);
  }
  problem.limits.time = 0;
  problem.limits.iterations = 100;
  problem.margins.wishes = {{"disc and ceiling", {{"disc", "ceiling"}}, 100},
                            {"disc and ceiling", {{"disc", "ceiling"}}, 1e-3}};
  PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(result.length, 0);
  ASSERT_EQ(result.wishes.size(), 2U);
  EXPECT_EQ(result.wishes[0].kept, std::optional(false));
  EXPECT_EQ(result.wishes[1].kept, std::optional(true));
  EXPECT_LT(result.wishes[0].clearance.upper, 100);
  // The worst place of such a path costs the same as on any other path.
  problem.margins.wishes.clear();
  problem.objective = MinimumCost{0, {{{Nearness::Kind::kHinge, 100}, 2, true, Pairs::kWorld}}};
  result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_GT(result.cost.lower, 1.5);
  EXPECT_LT(result.cost.upper, 2);
}

/// Pairs that may touch are not checked, so nothing is proven about their distance.
TEST(Wishes, OfPairsThatAreNotCheckedStayUndecided) {
  Problem problem = test::corridorProblem();
  problem.contacts.allowed.emplace_back("disc", "ceiling");
  problem.margins.wishes = {{"disc and ceiling", {{"disc", "ceiling"}}, 0.3}};
  problem.limits.time = 0;
  problem.limits.iterations = 2000;
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  ASSERT_EQ(result.wishes.size(), 1U);
  EXPECT_EQ(result.wishes[0].kept, std::nullopt);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("none of its pairs is checked"), std::string::npos);
}

TEST(PathCost, OfEdgesIsWhatOmplGetsAndTheHeuristicIsBelowIt) {
  const Problem problem = costProblem();
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const auto cost = PathCost::of(*scene, problem);
  ASSERT_NE(cost, nullptr);
  EXPECT_TRUE(cost->isAdditive());
  const std::vector<double> a = {-1.2, 0.7, 0}, b = {0, 1.2, 0}, c = {0.9, -1, 1};
  const PathCost::Edge ab = cost->edge(a, b, {}), bc = cost->edge(b, c, {});
  EXPECT_LE(cost->leastBetween(a, b), ab.sum.lower);
  const Interval whole = cost->path({a, b, c}, {});
  EXPECT_NEAR(whole.upper, ab.sum.upper + bc.sum.upper, 1e-9);
  const PathCost::Edge cut = cost->edge(a, b, {.cutoff = ab.sum.lower / 2});
  EXPECT_GT(cut.sum.lower, ab.sum.lower / 2);
}

}  // namespace
}  // namespace leeway::planner
