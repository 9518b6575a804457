// The clearance of edges among many balls, by a hierarchy, against the same pairs in shares that
// are small enough to visit all of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/point_cloud.h"
#include "planner/base/tolerances.h"
#include "tests/support/random_problem.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using testing::Random;

std::shared_ptr<const PointCloud> cloudOf(const std::vector<Eigen::Vector3d>& points,
                                          double radius) {
  return std::make_shared<const PointCloud>(makeCloud(
      {points.data(), points.size(), sizeof(Eigen::Vector3d), PointArray::Number::kDouble},
      radius));
}

/// A rough wall, at any place and angle within `room` [m].
Object wall(Random& random, int balls, double room) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < balls; ++i)
    points.emplace_back(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6),
                        random.uniform(-0.03, 0.03));
  Object object;
  object.name = "wall";
  object.cloud = cloudOf(points, random.uniform(0.002, 0.03));
  object.X_WO = random.pose(room);
  return object;
}

/// The least clearance of the pairs that are not of the robot alone, share by share.
class PairsInShares {
 public:
  explicit PairsInShares(const CompiledScene& scene) {
    constexpr std::size_t kShare = kManyPairs / 2;
    const std::size_t pairs = scene.scene().pairs().size();
    for (std::size_t first = 0; first < pairs; first += kShare) {
      std::size_t number = 0;
      certifiers_.push_back(
          std::make_unique<EdgeCertifier>(scene.withPairs([&](const collision::ScenePair& pair) {
            const std::size_t i = number++;
            return i >= first && i < first + kShare && !scene.isOfRobot(pair);
          })));
    }
  }
  Interval along(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
    Interval least{kInfinity, kInfinity};
    for (const auto& certifier : certifiers_) {
      const Interval found =
          certifier->edgeClearance(a, b, {.tolerance = tolerance, .pairs = Pairs::kWorld})
              .clearance;
      least.lower = std::min(least.lower, found.lower);
      least.upper = std::min(least.upper, found.upper);
    }
    return least;
  }

 private:
  std::vector<std::unique_ptr<EdgeCertifier>> certifiers_;
};

TEST(WorldSearch, ClearancesAreThoseOfAllPairs) {
  constexpr double kTolerance = 1e-5;
  Random random(5014);
  int apart = 0, touching = 0, states = 0;
  for (int p = 0; p < 24; ++p) {
    auto model = p % 3 == 0 ? testing::randomArm(random) : testing::randomTreeWithShapes(random);
    Problem problem = testing::randomProblem(random, std::move(model), p % 2, 2.0);
    problem.world.objects.push_back(wall(random, 300, p % 2 == 0 ? 0.5 : 2.5));
    if (p % 5 == 0) {
      problem.world.objects.push_back(wall(random, 200, 2.0));
      problem.world.objects.back().name = "second wall";
    }
    const auto scene = std::make_shared<const CompiledScene>(problem);
    ASSERT_GT(scene->scene().pairs().size(), kManyPairs);
    EdgeCertifier certifier(scene);
    PairsInShares shares(*scene);
    for (int i = 0; i < 4; ++i) {
      const std::vector<double> a = robots::testing::randomConfiguration(random, scene->model());
      std::vector<double> b(a.size());
      const auto far = robots::testing::randomConfiguration(random, scene->model());
      const bool is_state = i == 3;
      scene->space().interpolate(a, far, is_state ? 0 : 0.15 * (i + 1), b);
      const EdgeClearance found =
          certifier.edgeClearance(a, b, {.tolerance = kTolerance, .pairs = Pairs::kWorld});
      const Interval all = shares.along(a, b, kTolerance);
      SCOPED_TRACE(::testing::Message() << "problem " << p << " edge " << i);
      // Each contains the true value.
      EXPECT_LE(found.clearance.lower, all.upper);
      EXPECT_GE(found.clearance.upper, all.lower);
      if (!(all.width() <= 2 * kTolerance)) continue;  // depths
      EXPECT_LE(found.clearance.width(), 2 * kTolerance);
      EXPECT_NEAR(found.clearance.upper, all.upper, 2 * kTolerance);
      ++(all.upper > 0 ? apart : touching);
      if (!is_state) continue;
      ++states;
      const StateCheck check = certifier.clearance(a, kTolerance);
      EXPECT_LE(check.clearance.width(), 1.01 * kTolerance);
      EXPECT_LE(check.clearance.lower, all.upper);
      const bool keeps = check.verdict == Verdict::kFree;
      EXPECT_EQ(keeps, certifier.decide(a) == Verdict::kFree);
    }
  }
  std::printf("%d apart, %d touching, %d states\n", apart, touching, states);
  EXPECT_GT(apart, 20);
  EXPECT_GT(touching, 5);
  EXPECT_GT(states, 10);
}

/// Regression: boxes bounded depths by 298.5 mm where 544.5 mm are true, after a contact was found
/// on the way.
TEST(WorldSearch, ContactsOnTheWayAreMeasuredAmongPairs) {
  Random random(1);
  for (int k = 0; k < 10; ++k) {
    const auto about = [&](double x, double radius, int balls, double spread) {
      std::vector<Eigen::Vector3d> points;
      for (int i = 0; i < balls; ++i)
        points.emplace_back(x + spread * random.uniform(-1, 1), random.uniform(-0.02, 0.02),
                            random.uniform(-0.02, 0.02));
      Object object;
      object.name = "cloud " + std::to_string(balls);
      object.cloud = cloudOf(points, radius);
      return object;
    };
    Problem problem =
        test::problemOf(robots::freeBody("ball", {{collision::Shape::sphere(0.05), {}, "ball"}},
                                         robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0}),
                        {-2, 0, 0}, {2, 0, 0});
    problem.world.objects = {about(0, 0.3, 900, 1.1),
                             about(random.uniform(-1, 1), random.uniform(0.31, 0.6), 20, 0.02)};
    double truth = kInfinity;
    for (const Object& object : problem.world.objects)
      for (const PointCloud::Ball& ball : object.cloud->balls)
        truth = std::min(truth, ball.center.tail<2>().norm() - ball.radius - 0.05);
    const auto scene = std::make_shared<const CompiledScene>(problem);
    ASSERT_GT(scene->scene().pairs().size(), kManyPairs);
    const Interval found = EdgeCertifier(scene)
                               .edgeClearance(std::vector<double>{-2, 0, 0},
                                              std::vector<double>{2, 0, 0}, {.tolerance = 1e-5})
                               .clearance;
    EXPECT_LE(found.lower, truth) << k;
    EXPECT_GE(found.upper, truth) << k;
  }
}

/// Regression: the clearance near a large cloud was "between 0 and 386 mm" after seconds of work.
TEST(WorldSearch, AWallOfManyBallsIsMeasuredWithLittleWork) {
  Random random(77);
  Problem problem = testing::randomProblem(random, testing::randomArm(random), 0, 1.0);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 100'000; ++i)
    points.emplace_back(random.uniform(2.4, 2.41), random.uniform(-2, 2), random.uniform(-2, 2));
  Object object;
  object.name = "wall";
  object.cloud = cloudOf(points, 0.005);
  problem.world.objects.push_back(object);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  const std::vector<double> a = robots::testing::randomConfiguration(random, scene->model());
  std::vector<double> b(a.size());
  scene->space().interpolate(a, robots::testing::randomConfiguration(random, scene->model()), 0.3,
                             b);
  const EdgeClearance found =
      certifier.edgeClearance(a, b, {.tolerance = 1e-6, .pairs = Pairs::kWorld});
  EXPECT_LE(found.clearance.width(), 1e-6);
  EXPECT_LT(certifier.statistics.work, kClearanceWork / 2);
  const EdgeClearance proven =
      certifier.proveClearance(a, b, {.wanted = found.clearance.lower / 2, .pairs = Pairs::kWorld});
  EXPECT_TRUE(proven.keeps_margins);
}

}  // namespace
}  // namespace leeway::planner
