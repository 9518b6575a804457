#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/simplify.h"
#include "leeway/robots/input_error.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// Two ways past a block: the shorter one is narrow, and a first path often takes the other.
PlanResult planCorridor(std::uint64_t seed, const std::map<std::string, std::string>& parameters) {
  Problem problem = test::corridorProblem();
  problem.seed = seed;
  problem.planner.parameters = parameters;
  problem.planner.parameters.emplace("range", "0.9");  // long enough to jump the narrow way
  problem.limits.time = 0;
  problem.limits.iterations = 20000;
  return plan(problem);
}

TEST(Improve, FindsTheShorterWay) {
  double longest = 0, shortest = std::numeric_limits<double>::infinity();
  int shorter = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const PlanResult first = planCorridor(seed, {});
    const PlanResult best = planCorridor(seed, {{"improve", "1000"}});
    ASSERT_EQ(best.status, PlanStatus::kSolved);
    EXPECT_TRUE(best.certificate.certified);
    EXPECT_LE(best.length, first.length);
    longest = std::max(longest, best.length);
    shortest = std::min(shortest, best.length);
    shorter += best.length < 0.9 * first.length;
  }
  EXPECT_GE(shorter, 2);
  EXPECT_LT(longest, 1.01 * shortest);
}

TEST(Improve, TellsOfEachBetterPath) {
  Problem problem = test::corridorProblem();
  problem.planner.parameters = {{"improve", "1000"}, {"range", "0.9"}};
  problem.planner.push = false;
  problem.limits.time = 0;
  problem.limits.iterations = 20000;
  std::vector<double> lengths;
  PlanOptions options;
  options.on_path = [&](const std::vector<std::vector<double>>&, double length) {
    lengths.push_back(length);
  };
  const PlanResult result = plan(problem, options);
  ASSERT_GE(lengths.size(), 2U);
  EXPECT_TRUE(std::is_sorted(lengths.rbegin(), lengths.rend()));
  EXPECT_DOUBLE_EQ(lengths.back(), result.length);
}

TEST(Improve, IsTheSameForAnyNumberOfThreads) {
  const PlanResult one = planCorridor(3, {{"improve", "1000"}, {"workers", "3"}, {"threads", "1"}});
  const PlanResult four =
      planCorridor(3, {{"improve", "1000"}, {"workers", "3"}, {"threads", "4"}});
  EXPECT_EQ(one.path.positions, four.path.positions);
  EXPECT_EQ(one.edges, four.edges);
  EXPECT_EQ(one.iterations, four.iterations);
}

TEST(Improve, EndsInTime) {
  Problem problem = test::corridorProblem();
  problem.planner.parameters = {{"improve", "0.2"}};
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_GE(result.improve_s, 0.2);
  EXPECT_LT(result.improve_s, 2.0);
  problem.limits.time = 0.1;
  problem.planner.parameters = {{"improve", "1000"}};
  EXPECT_LT(plan(problem).improve_s, 1.0);
}

TEST(Improve, RefusesWhatIsNoTime) {
  for (const char* value : {"-1", "nan", "long", ""})
    EXPECT_NE(plannerError("Connect", {{"improve", value}}), std::nullopt) << value;
  EXPECT_EQ(plannerError("Connect", {{"improve", "0.5"}}), std::nullopt);
}

TEST(Improve, IsRefusedWhereItWouldBeIgnored) {
  Problem problem = test::corridorProblem();
  problem.planner.parameters = {{"improve", "0.01"}};
  problem.limits.time = 0.1;
  problem.objective = MaximumClearance{};
  EXPECT_THROW(plan(problem), robots::InputError);
  problem.planner.parameters = {{"improve", "0"}};
  EXPECT_EQ(plan(problem).status, PlanStatus::kSolved);
}

}  // namespace
}  // namespace leeway::planner
