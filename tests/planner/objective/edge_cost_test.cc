// The cost of nearness along an edge, compared with dense samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/objective/nearness.h"
#include "tests/support/from_environment.h"
#include "tests/support/random_problem.h"

namespace leeway::planner {
namespace {

using testing::Random;

TEST(Nearness, MeansOverALineHoldSums) {
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    const Nearness nearness{n % 2 == 0 ? Nearness::Kind::kHinge : Nearness::Kind::kInverse,
                            random.uniform(0.01, 0.3)};
    const double begin = random.uniform(-0.2, 0.6), end = random.uniform(-0.2, 0.6);
    double sum = 0;
    constexpr int kSteps = 1000;
    for (int k = 0; k < kSteps; ++k)
      sum += nearnessAt(nearness, begin + (k + 0.5) / kSteps * (end - begin)) / kSteps;
    const Interval mean = meanNearness(nearness, begin, end);
    EXPECT_LE(mean.lower, sum + 1e-5) << begin << " " << end << " " << nearness.distance;
    EXPECT_GE(mean.upper, sum - 1e-5) << begin << " " << end << " " << nearness.distance;
    if (n % 2 == 0) {
      EXPECT_LE(mean.width(), 1e-13);
    }
    EXPECT_EQ(mean.lower, meanNearness(nearness, end, begin).lower);
  }
  const Nearness hinge{Nearness::Kind::kHinge, 0.1};
  EXPECT_EQ(meanNearness(hinge, kInfinity, kInfinity).upper, 0);
  EXPECT_EQ(meanNearness(hinge, 0.05, kInfinity).upper, 0.5);
  EXPECT_EQ(meanNearness(hinge, 0.05, kInfinity).lower, 0);
  EXPECT_EQ(meanNearness(hinge, -kInfinity, 0.05).upper, 1);
  EXPECT_EQ(meanNearness(hinge, 0, 0.1).lower, 0.5);
}

/// The cost of an edge from samples, by the distance engine alone.
struct Dense {
  double mean = 0;   ///< of nearness
  double error = 0;  ///< bound on its error
  double least = kInfinity;
};
Dense denseCost(EdgeCertifier& certifier, const Nearness& nearness, const std::vector<double>& a,
                const std::vector<double>& b, int samples) {
  Dense dense;
  std::vector<double> q(a.size());
  const auto mean = [&](int count) {
    double sum = 0;
    for (int k = 0; k < count; ++k) {
      certifier.scene().space().interpolate(a, b, (k + 0.5) / count, q);
      const double clearance = certifier.clearance(q, 1e-8).clearance.upper;
      dense.least = std::min(dense.least, clearance);
      sum += nearnessAt(nearness, clearance);
    }
    return sum / count;
  };
  dense.mean = mean(samples);
  dense.error = 3 * std::abs(dense.mean - mean(samples / 2 + 1)) + 2e-6;
  return dense;
}

/// Random paths of two edges each, of arms, trees and bodies of all shapes. Every fourth has links
/// or obstacles that are far from convex.
class RandomPaths {
 public:
  explicit RandomPaths(std::uint64_t seed) : random_(seed) {}

  void run(int paths) {
    for (int p = 0; p < paths; ++p) {
      if (p % 5 == 0) makeProblem(p / 5);
      onePath("seed " + std::to_string(seed_) + " path " + std::to_string(p));
    }
    std::printf("edges %d, telling %d, narrow %d, %.0f us each; clearances told %d\n", edges_,
                telling_, narrow_, static_cast<double>(work_) / edges_ / 1000, told_);
    EXPECT_GT(telling_, edges_ / 4);
    EXPECT_GT(narrow_, edges_ * 85 / 100);
    EXPECT_GT(told_, edges_ / 2);
  }

 private:
  void makeProblem(int p) {
    seed_ = static_cast<std::uint64_t>(random_.integer(1 << 30));
    Random random(seed_);
    const auto model = p % 4 == 0   ? testing::randomArm(random)
                       : p % 4 == 1 ? testing::randomFreeBody(random, robots::JointType::kFloating)
                                    : testing::randomTreeWithShapes(random);
    Problem problem = testing::randomProblem(random, model, 4, 1.2);
    if (p % 4 == 3)
      problem.world.objects.push_back(
          {"mesh", {{testing::randomMesh(random, 0.3), {}, "mesh"}}, random.pose(1.0)});
    const auto compiled = std::make_shared<const CompiledScene>(problem);
    scene_ = compiled->withPairs(
        [&](const collision::ScenePair& pair) { return p % 3 == 0 || !compiled->isOfRobot(pair); });
    certifier_ = std::make_unique<EdgeCertifier>(scene_);
    dense_ = std::make_unique<EdgeCertifier>(scene_);
  }

  void onePath(const std::string& name) {
    std::vector<double> a = robots::testing::randomConfiguration(random_, scene_->model());
    const Nearness nearness{
        random_.integer(2) == 0 ? Nearness::Kind::kHinge : Nearness::Kind::kInverse,
        random_.uniform(0.02, 0.3)};
    double dense_sum = 0, error = 0, least = kInfinity;
    Interval sum{0, 0}, clearance{kInfinity, kInfinity};
    for (int e = 0; e < 2; ++e) {
      const std::vector<double> far =
          robots::testing::randomConfiguration(random_, scene_->model());
      std::vector<double> b(a.size());
      scene_->space().interpolate(a, far, random_.uniform(0.02, 0.4), b);
      const double length = scene_->space().distance(a, b);
      Dense dense = denseCost(*dense_, nearness, a, b, kSamples);
      const std::int64_t before = certifier_->statistics.work;
      const EdgeCost cost = certifier_->edgeCost(a, b, {.nearness = nearness});
      work_ += certifier_->statistics.work - before;
      const EdgeCost rough = certifier_->edgeCost(a, b, {.nearness = nearness, .tolerance = 0.3});
      const double bound = cost.mean.lower / 2;
      const EdgeCost cut = certifier_->edgeCost(a, b, {.nearness = nearness, .cutoff = bound});
      const auto holds = [&](const EdgeCost& found) {
        return found.mean.lower <= dense.mean + dense.error &&
               found.mean.upper >= dense.mean - dense.error;
      };
      // If a pair is near for less than a sample or two, only more samples detect it.
      if (!holds(cost) || !holds(rough) || !holds(cut))
        dense = denseCost(*dense_, nearness, a, b, 100 * kSamples);
      for (const EdgeCost& found : {cost, rough, cut}) {
        EXPECT_LE(found.mean.lower, dense.mean + dense.error) << name;
        EXPECT_GE(found.mean.upper, dense.mean - dense.error) << name;
        EXPECT_GE(found.worst.upper, nearnessAt(nearness, dense.least) - 1e-6) << name;
        EXPECT_LE(found.clearance.lower, dense.least + 1e-7) << name;
      }
      EXPECT_GT(cut.mean.lower, cost.mean.lower > 0 ? bound : -1) << name;
      ++edges_;
      telling_ += dense.mean > 0.01 && dense.mean < 0.99 ? 1 : 0;
      narrow_ += cost.mean.width() <= std::max(0.01 * cost.mean.upper, CostRequest::kLeast) ? 1 : 0;
      const Interval found = certifier_->edgeClearance(a, b, {.tolerance = 1e-3}).clearance;
      told_ += std::isfinite(found.lower) ? 1 : 0;
      clearance = {std::min(clearance.lower, found.lower), std::min(clearance.upper, found.upper)};
      sum = {sum.lower + length * cost.mean.lower, sum.upper + length * cost.mean.upper};
      dense_sum += length * dense.mean;
      error += length * dense.error;
      least = std::min(least, dense.least);
      a = b;
    }
    EXPECT_LE(sum.lower, dense_sum + error) << name;
    EXPECT_GE(sum.upper, dense_sum - error) << name;
    EXPECT_LE(clearance.lower, least + 1e-7) << name;
  }

  static constexpr int kSamples = 400;
  Random random_;
  std::uint64_t seed_ = 0;  ///< of the current problem
  std::shared_ptr<const CompiledScene> scene_;
  std::unique_ptr<EdgeCertifier> certifier_, dense_;
  int edges_ = 0, telling_ = 0, narrow_ = 0, told_ = 0;
  std::int64_t work_ = 0;
};

/// LEEWAY_TEST_PATHS and LEEWAY_TEST_SEED set the number of paths and the seed; `tools/test --full`
/// uses them.
TEST(EdgeCost, IntervalsHoldDenseSamplesOfRandomPaths) {
  RandomPaths(71 + fromEnvironment("LEEWAY_TEST_SEED", 0))
      .run(static_cast<int>(fromEnvironment("LEEWAY_TEST_PATHS", 60)));
}

}  // namespace
}  // namespace leeway::planner
