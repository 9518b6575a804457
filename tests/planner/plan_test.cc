#include "leeway/planner/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "leeway/planner/planners.h"
#include "leeway/robots/input_error.h"
#include "tests/planner/test_models.h"

namespace leeway::planner {
namespace {

/// Every edge proven, ends where they should be, the certificate's interval around what dense
/// sampling sees.
void expectCertified(const Problem& problem, const PlanResult& result) {
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  ASSERT_GE(result.path.positions.size(), 2u);
  EXPECT_EQ(result.path.positions.front(), problem.configuration);
  ASSERT_GE(result.goal, 0);
  const Goal& goal = problem.goals[static_cast<std::size_t>(result.goal)];
  for (std::size_t i = 0; i < goal.ranges.size(); ++i) {
    EXPECT_GE(result.path.positions.back()[i], goal.ranges[i].first);
    EXPECT_LE(result.path.positions.back()[i], goal.ranges[i].second);
  }
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  std::vector<double> q(problem.configuration.size());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < result.path.positions.size(); ++i) {
    double least_here = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 100; ++k) {
      scene->space().interpolate(result.path.positions[i - 1], result.path.positions[i], k / 100.0,
                                 q);
      const StateCheck check = certifier.clearance(q, 1e-7);
      EXPECT_EQ(check.verdict, Verdict::kFree) << "segment " << i - 1 << " at " << k / 100.0;
      least_here = std::min(least_here, check.clearance.upper);
    }
    EXPECT_LE(result.certificate.segments[i - 1].lower, least_here);
    least = std::min(least, least_here);
  }
  EXPECT_LE(result.certificate.clearance.lower, least);
  EXPECT_GE(result.certificate.clearance.upper, result.certificate.clearance.lower);
}

std::vector<std::string> allPlanners() {
  std::vector<std::string> names;
  for (const PlannerTraits& traits : plannerNames()) names.push_back(traits.name);
  return names;
}

class EachPlanner : public testing::TestWithParam<std::string> {};

TEST_P(EachPlanner, SolvesTheWallAndCertifies) {
  const PlannerTraits& traits = *findPlanner(GetParam());
  Problem problem = test::wallProblem();
  problem.planner = traits.name;
  problem.iteration_limit = traits.optimizing ? 3000 : 1000000;
  if (!traits.exact) problem.iteration_limit = 30000;  // random steps need many
  // Planners with threads look at their limits as often as they please: they get a time.
  if (!traits.deterministic) problem.iteration_limit = 0;
  if (!traits.deterministic) problem.time_limit = traits.optimizing ? 1 : 20;
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.planner, traits.name);
  EXPECT_EQ(result.deterministic, traits.deterministic);
  if (std::getenv("SHOW"))
    printf("%-22s iter %8lu edges %7lu states %7lu len %.4f plan %.4f simp %.4f clear %.4f n %zu\n",
           traits.name.c_str(), result.iterations, result.edges, result.states, result.length,
           result.plan_s, result.simplify_s, result.certificate.clearance.lower,
           result.path.positions.size());
  expectCertified(problem, result);
  EXPECT_GT(result.iterations, 0u);
  EXPECT_GT(result.length, 4.0) << "the straight way is closed";
}

INSTANTIATE_TEST_SUITE_P(Ompl, EachPlanner, testing::ValuesIn(allPlanners()),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace leeway::planner
