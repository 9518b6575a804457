#include "planner/improve/push.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/simplify.h"
#include "planner/base/tolerances.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

TEST(Push, MovesAPathOffWhatItHugsAndProvesIt) {
  Problem problem = test::wallProblem();
  problem.limits.iterations = 1'000'000;
  int pushed = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    problem.seed = seed;
    problem.planner.push = false;
    const PlanResult plain = plan(problem);
    problem.planner.push = true;
    const PlanResult result = plan(problem), again = plan(problem);
    ASSERT_EQ(result.status, PlanStatus::kSolved);
    EXPECT_TRUE(result.certificate.certified);
    EXPECT_EQ(result.path.positions, again.path.positions);
    EXPECT_EQ(result.path.positions.front(), plain.path.positions.front());
    EXPECT_EQ(result.path.positions.back(), plain.path.positions.back());
    EXPECT_LE(result.length, (1 + kPushLonger) * plain.length);
    EXPECT_GE(result.certificate.world.clearance.upper, plain.certificate.world.clearance.lower);
    pushed += result.certificate.world.clearance.lower > 0.8 * kPushClearance ? 1 : 0;
  }
  EXPECT_GE(pushed, 8);
}

TEST(Push, LeavesAPathThatCannotKeepMore) {
  Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
  problem.world.objects.push_back(test::box("beside the start", {0.1, 0.1, 0.5}, -1, 0.2001, 0));
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  std::vector<std::vector<double>> path = {{-1, 0, 0}, {0, -0.2, 0}, {1, 0, 0}};
  const auto before = path;
  PushOptions options;
  options.target = 0.05;
  options.least = 0.01;
  options.longest = 10;
  options.work = 10'000'000;
  EXPECT_EQ(push(certifier, path, options), 0);
  EXPECT_EQ(path, before);
}

TEST(Push, APlaceThatKeepsLessHoldsNoOtherBack) {
  // The start has 0.1 mm of clearance, and so has the path along the block.
  Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
  problem.world.objects.push_back(test::box("beside the start", {0.1, 0.1, 0.5}, -1, 0.2001, 0));
  problem.world.objects.push_back(test::box("block", {0.1, 0.1, 0.5}, 0.4, -0.2001, 0));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  std::vector<std::vector<double>> path = {{-1, 0, 0}, {-0.2, 0, 0}, {1, 0, 0}};
  PushOptions options;
  options.target = 0.008;
  options.least = 0.001;
  options.longest = 2.1;
  options.work = 10'000'000;
  EXPECT_EQ(push(certifier, path, options), 0);
  double beside_block = 1;
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_EQ(certifier.certify(path[i - 1], path[i]).verdict, Verdict::kFree);
    if (path[i - 1][0] < -0.5) continue;
    const EdgeClearance found = certifier.edgeClearance(path[i - 1], path[i], {.tolerance = 1e-5});
    beside_block = std::min(beside_block, found.clearance.lower);
  }
  EXPECT_GE(beside_block, options.target - 1e-5);
}

/// The least clearance of a path's edges [m].
double leastOf(EdgeCertifier& certifier, const std::vector<std::vector<double>>& path) {
  double least = 1;
  for (std::size_t i = 1; i < path.size(); ++i)
    least = std::min(
        least, certifier.edgeClearance(path[i - 1], path[i], {.tolerance = 1e-5}).clearance.lower);
  return least;
}

TEST(Push, AGapTooNarrowForTheTargetKeepsWhatPlansShallKeep) {
  // The disc of radius 0.1 has 7.2 mm in total, and the path leaves 0.1 mm on one side. A move
  // towards 8 mm ends in contact on the other side.
  for (const double side : {-1.0, 1.0}) {
    Problem problem = test::problemOf(test::disc(), {-1, 0.0035 * side, 0}, {1, 0.0035 * side, 0});
    problem.world.objects.push_back(test::box("above", {0.1, 0.5, 0.5}, 0, 0.6036, 0));
    problem.world.objects.push_back(test::box("below", {0.1, 0.5, 0.5}, 0, -0.6036, 0));
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    std::vector<std::vector<double>> path = {{-1, 0.0035 * side, 0}, {1, 0.0035 * side, 0}};
    PushOptions options;
    options.target = kPushClearance;
    options.least = kPushLeast;
    options.longest = 2.1;
    options.work = kPushWork;
    EXPECT_EQ(push(certifier, path, options), kPushEnough);
    EXPECT_GE(leastOf(certifier, path), kPushEnough - 1e-5);
  }
}

TEST(Push, AimsAtWhatAnEndHasWhereThatIsEnough) {
  // The start has 5 mm of clearance; the path along the block has 0.1 mm.
  Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
  problem.world.objects.push_back(test::box("beside the start", {0.1, 0.1, 0.5}, -1, 0.205, 0));
  problem.world.objects.push_back(test::box("block", {0.1, 0.1, 0.5}, 0.4, -0.2001, 0));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  std::vector<std::vector<double>> path = {{-1, 0, 0}, {-0.2, 0, 0}, {1, 0, 0}};
  PushOptions options;
  options.target = kPushClearance;
  options.least = kPushLeast;
  options.longest = 2.1;
  options.work = kPushWork;
  const double kept = push(certifier, path, options);
  EXPECT_GE(kept, 0.9 * 0.005);
  EXPECT_LE(kept, 0.005);
  EXPECT_GE(leastOf(certifier, path), kept - 1e-5);
}

TEST(Push, KeepsToTheLengthThatItMayHave) {
  Problem problem = test::wallProblem();
  problem.planner.push = false;
  problem.limits.iterations = 1'000'000;
  PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const auto before = result.path.positions;
  PushOptions options;
  options.target = options.least = 0.02;
  options.longest = result.length;  // nothing to spare
  options.work = 10'000'000;
  EXPECT_EQ(push(certifier, result.path.positions, options), 0);
  EXPECT_EQ(result.path.positions, before);
  options.longest = 2 * result.length;
  EXPECT_EQ(push(certifier, result.path.positions, options), 0.02);
  EXPECT_NE(result.path.positions, before);
}

TEST(Objective, LengthKeepsItsFloorOfClearance) {
  Problem problem = test::wallProblem();
  problem.limits.iterations = 1'000'000;
  problem.objective = MinimumLength{0.04};
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_GE(result.certificate.world.clearance.lower, 0.04);
}

}  // namespace
}  // namespace leeway::planner
