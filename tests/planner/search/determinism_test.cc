#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

std::vector<std::string> seededPlanners() {
  std::vector<std::string> result;
  for (const PlannerTraits& traits : plannerNames())
    if (traits.deterministic) result.push_back(traits.name);
  return result;
}

Problem seededProblem(const PlannerTraits& traits, std::uint64_t seed) {
  Problem problem = test::wallProblem();
  problem.planner.name = traits.name;
  problem.seed = seed;
  problem.limits.iterations = !traits.exact ? 20000 : traits.optimizing ? 600 : 100000;
  if (traits.name == "AITstar") problem.limits.iterations = 3000;  // 600 do not find the gap
  problem.limits.time = 0;
  return problem;
}

/// Plans continuously in other threads, which perturbs OMPL's seed generator and the heap.
class Disturbance {
 public:
  Disturbance() {
    for (int i = 0; i < 2; ++i)
      threads_.emplace_back([this, i] {
        for (std::uint64_t k = 0; !stop_; ++k) {
          Problem problem = test::wallProblem();
          problem.planner.name =
              (k + static_cast<std::uint64_t>(i)) % 2 == 0 ? "RRTConnect" : "BITstar";
          problem.limits.iterations = 100;
          problem.seed = 1000 + k;
          plan(problem);
          ++plans_;
        }
      });
    while (plans_ < 2) std::this_thread::yield();
  }
  ~Disturbance() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<int> plans_{0};
  std::vector<std::thread> threads_;
};

void expectSame(const PlanResult& a, const PlanResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.path.positions, b.path.positions);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.states, b.states);
  EXPECT_EQ(a.certificate.clearance.lower, b.certificate.clearance.lower);
  EXPECT_EQ(a.certificate.clearance.upper, b.certificate.clearance.upper);
}

class SeededPlanner : public testing::TestWithParam<std::string> {};

TEST_P(SeededPlanner, SameSeedSamePathWhateverElseIsPlanned) {
  const Problem problem = seededProblem(*findPlanner(GetParam()), 11);
  const PlanResult first = plan(problem);
  EXPECT_EQ(first.status, PlanStatus::kSolved);
  const Disturbance disturbance;
  for (int i = 0; i < 2; ++i) {
    // Another heap layout reveals dependence on addresses.
    std::vector<std::unique_ptr<char[]>> blocks;
    for (std::size_t k = 1; k < 200; ++k)
      if (k % 3 != 0) blocks.push_back(std::make_unique<char[]>(k * 13));
    expectSame(first, plan(problem));
  }
}

TEST_P(SeededPlanner, AnotherSeedAnotherPath) {
  const PlanResult a = plan(seededProblem(*findPlanner(GetParam()), 11)),
                   b = plan(seededProblem(*findPlanner(GetParam()), 12));
  EXPECT_NE(a.path.positions, b.path.positions);
}

INSTANTIATE_TEST_SUITE_P(Ompl, SeededPlanner, testing::ValuesIn(seededPlanners()),
                         [](const auto& each) { return each.param; });

TEST(Determinism, ManyPlansAtOnceAreThePlansAlone) {
  constexpr int kPlans = 6;
  const auto problemAt = [](int i) {
    return seededProblem(*findPlanner(i % 2 == 0 ? "RRTConnect" : "KPIECE1"),
                         static_cast<std::uint64_t>(i));
  };
  std::vector<PlanResult> alone(kPlans), together(kPlans);
  for (int i = 0; i < kPlans; ++i) alone[static_cast<std::size_t>(i)] = plan(problemAt(i));
  std::vector<std::thread> threads;
  for (int i = 0; i < kPlans; ++i)
    threads.emplace_back([&, i] { together[static_cast<std::size_t>(i)] = plan(problemAt(i)); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < kPlans; ++i) expectSame(alone[i], together[i]);
}

TEST(Determinism, ClearanceToo) {
  Problem problem = test::corridorProblem();
  problem.objective = MaximumClearance{};
  problem.limits.iterations = 3000;
  problem.limits.time = 0;
  const PlanResult first = plan(problem);
  const Disturbance disturbance;
  expectSame(first, plan(problem));
}

}  // namespace
}  // namespace leeway::planner
