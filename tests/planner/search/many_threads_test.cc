// Sixty-four threads on one robot and world, as in a server; tools/test --full runs them under
// ThreadSanitizer.

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/verify.h"
#include "tests/support/build_paths.h"

namespace leeway::planner {
namespace {

constexpr int kThreads = 64;
constexpr std::size_t kSeeds = 4;

TEST(ManyThreads, AnswerAsOne) {
  Problem problem = loadProblem(sourceFolder() + "/problems/shelf/reach.yaml");
  problem.limits.time = 0;
  problem.limits.iterations = 100'000;
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const auto planOf = [&](std::size_t seed, bool compiles) {
    Problem own = problem;
    own.seed = seed;
    return compiles ? plan(own) : plan(scene, own);
  };
  std::vector<PlanResult> alone;
  for (std::size_t seed = 0; seed < kSeeds; ++seed) alone.push_back(planOf(seed, false));
  EdgeCertifier certifier(scene);
  const std::vector<double> first = alone[0].path.positions[0], last = alone[0].path.positions[1];
  const Interval clearance = certifier.edgeClearance(first, last, {}).clearance;

  std::atomic<int> ready{0}, wrong{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&, i] {
      // All start together.
      for (++ready; ready < kThreads;) std::this_thread::yield();
      const std::size_t seed = static_cast<std::size_t>(i) % kSeeds;
      // Every second thread makes its own scene from the data that the model keeps for all.
      const PlanResult result = planOf(seed, i % 2 == 1);
      EdgeCertifier own(scene);
      const Interval again = own.edgeClearance(first, last, {}).clearance;
      const bool is_verified = i >= static_cast<int>(kSeeds) ||
                               verify(problem, result.path, {}).status == VerifyStatus::kCertified;
      if (result.path.positions != alone[seed].path.positions ||
          result.edges != alone[seed].edges || again.lower != clearance.lower ||
          again.upper != clearance.upper || !is_verified)
        ++wrong;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace leeway::planner
