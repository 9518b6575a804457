#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/simplify.h"
#include "planner/improve/push.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// Checks that the reported bounds hold for dense samples.
void expectHonest(const Problem& problem, const PlanResult& result) {
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  std::vector<double> q(problem.start.size());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < result.path.positions.size(); ++i)
    for (int k = 0; k <= 300; ++k) {
      scene->space().interpolate(result.path.positions[i - 1], result.path.positions[i], k / 300.0,
                                 q);
      least = std::min(least, certifier.clearance(q, 1e-9).clearance.upper);
    }
  EXPECT_LE(result.certificate.clearance.lower, least);
  EXPECT_GE(result.certificate.clearance.upper, least - 0.02) << "samples 0.02 apart";
  EXPECT_LE(result.certificate.clearance.width(), 2e-4);
}

class WidestPath : public testing::TestWithParam<std::string> {};

TEST_P(WidestPath, BeatsTheShortestInClearance) {
  Problem problem = test::corridorProblem();
  problem.limits.iterations = 4000;
  PlanOptions every_edge;
  every_edge.detail = CertificateDetail::kEveryEdge;
  const PlanResult shortest = plan(problem, every_edge);
  expectHonest(problem, shortest);
  problem.planner.name = GetParam();
  problem.objective = MaximumClearance{};
  problem.limits.iterations = 800;
  if (GetParam() == "PRMstar") problem.limits.iterations = 0;  // uses its own threads
  if (GetParam() == "PRMstar") problem.limits.time = 2;
  if (GetParam() == "Connect" || GetParam() == "RRTConnect") problem.limits.iterations = 20000;
  const PlanResult widest = plan(problem);
  expectHonest(problem, widest);
  // The upper passage leaves at most 0.1 next to the disc, the lower one 0.6.
  EXPECT_GT(widest.certificate.clearance.lower, shortest.certificate.clearance.upper + 0.02);
  EXPECT_LE(widest.certificate.clearance.lower, 0.6);
  if (GetParam() == "Connect" || GetParam() == "RRTConnect") {
    EXPECT_GT(widest.certificate.clearance.lower, 0.5);
  }
}

INSTANTIATE_TEST_SUITE_P(Ompl, WidestPath,
                         testing::Values("Connect", "RRTConnect", "BITstar", "AITstar", "RRTstar",
                                         "PRMstar", "LazyPRMstar"),
                         [](const auto& each) { return each.param; });

TEST(WidestPathAlone, SimplificationKeepsWhatWasReached) {
  Problem problem = test::corridorProblem();
  problem.objective = MaximumClearance{};
  problem.limits.iterations = 5000;
  problem.limits.time = 0;
  problem.planner.simplify = false;
  const PlanResult raw = plan(problem);
  problem.planner.simplify = true;
  const PlanResult simplified = plan(problem);
  EXPECT_GE(simplified.certificate.clearance.upper, raw.certificate.clearance.lower - 1e-3);
  EXPECT_LT(simplified.length, raw.length);
}

TEST(WidestPathAlone, EndsWhenStartOrGoalAllowsNoMore) {
  Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
  problem.world.objects.push_back(test::box("post", {0.1, 0.1, 0.5}, 0, 0.25, 0));
  problem.world.objects.push_back(test::box("beside the start", {0.1, 0.1, 0.5}, -1, 0.25, 0));
  problem.objective = MaximumClearance{};
  problem.limits.time = 0;  // must end by itself
  const PlanResult result = plan(problem);
  expectHonest(problem, result);
  EXPECT_NEAR(result.certificate.clearance.lower, 0.05, 2e-3);
}

TEST(WidestPathAlone, IsNoLongerThanItMayBe) {
  Problem problem = test::corridorProblem();
  problem.limits.time = 0;
  problem.limits.iterations = 20000;
  const PlanResult plain = plan(problem);
  ASSERT_EQ(plain.status, PlanStatus::kSolved);
  double before = 0;
  for (const double longer : {0.0, 0.1, 1.0}) {
    problem.objective = MaximumClearance{Pairs::kWorld, longer};
    const PlanResult result = plan(problem);
    expectHonest(problem, result);
    EXPECT_LE(result.length, (1 + longer) * result.shortest_length * (1 + 1e-12));
    EXPECT_LE(result.shortest_length, 1.05 * plain.length);
    EXPECT_GE(result.certificate.clearance.lower, before) << longer;
    before = result.certificate.clearance.lower;
    if (longer < 0.2) {
      EXPECT_LT(before, 0.35) << "as far as the length allows";
    }
  }
  EXPECT_GT(before, 0.4) << "in the wide passage";
}

TEST(WidestPathAlone, BudgetThatIsLeftMakesItShorter) {
  Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
  problem.world.objects.push_back(test::box("post", {0.1, 0.1, 0.5}, 0, 0.25, 0));
  problem.world.objects.push_back(test::box("beside the start", {0.1, 0.1, 0.5}, -1, 0.25, 0));
  problem.objective = MaximumClearance{};
  problem.limits.time = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    problem.seed = seed;
    const PlanResult result = plan(problem);
    ASSERT_EQ(result.status, PlanStatus::kSolved);
    EXPECT_LT(result.length, 1.1 * 2.0) << "the straight edge has 2 and keeps as much";
  }
}

/// The least clearance of a path where -x_most <= x <= x_most.
double leastBetween(EdgeCertifier& certifier, const std::vector<std::vector<double>>& path,
                    double x_most) {
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> q(path[0].size());
  for (std::size_t i = 1; i < path.size(); ++i)
    for (int k = 0; k <= 200; ++k) {
      certifier.scene().space().interpolate(path[i - 1], path[i], k / 200.0, q);
      if (std::abs(q[0]) <= x_most)
        least = std::min(least, certifier.clearance(q, 1e-6).clearance.lower);
    }
  return least;
}

TEST(PushElsewhere, RaisesTheNextWorstPlace) {
  // The start has 0.05 and a gate on the way 0.1; the path is nearer to the wall than necessary.
  Problem problem = test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0});
  problem.world.objects.push_back(test::box("beside the start", {0.05, 0.1, 0.5}, -1.5, 0.25, 0));
  problem.world.objects.push_back(test::box("wall", {1.2, 0.1, 0.5}, 0, 0.27, 0));
  problem.world.objects.push_back(test::box("gate", {0.02, 0.4, 0.5}, 0, -0.63, 0));
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  std::vector<std::vector<double>> path = {{-1.5, 0, 0}, {0, -0.03, 0}, {1.5, 0, 0}};
  EXPECT_LT(leastBetween(certifier, path, 1.25), 0.077);
  PushOptions options;
  options.target = leastBetween(certifier, path, 2) - 1e-4;
  options.longest = 1.2 * pathLength(scene->space(), path);
  const auto before = path;
  pushElsewhere(scene, certifier, path, options);
  EXPECT_GT(leastBetween(certifier, path, 1.25), 0.09);
  EXPECT_GE(leastBetween(certifier, path, 2), options.target);
  EXPECT_LE(pathLength(scene->space(), path), options.longest);
  EXPECT_EQ(path.front(), before.front());
  EXPECT_EQ(path.back(), before.back());
  for (std::size_t i = 1; i < path.size(); ++i)
    EXPECT_EQ(certifier.certify(path[i - 1], path[i]).verdict, Verdict::kFree);
}

TEST(WidestPathAlone, NothingToBeNearIsInfinite) {
  Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
  problem.objective = MaximumClearance{};
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(result.certificate.clearance.lower, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace leeway::planner
