// Clearances from the world and of the robot from itself, compared with dense samples of scenes
// with only those pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/plan.h"
#include "tests/support/random_problem.h"

namespace leeway::planner {
namespace {

using testing::Random;

/// Distances of some pairs, by certifiers with only these pairs.
class DensePairs {
 public:
  DensePairs(const CompiledScene& scene, Pairs pairs)
      : certifier_(scene.withPairs([&](const collision::ScenePair& pair) {
          return scene.isOfRobot(pair) == (pairs == Pairs::kSelf);
        })) {}

  /// The least upper end at samples of an edge: below the true value by at most rounding.
  double along(const std::vector<double>& a, const std::vector<double>& b, int samples) {
    std::vector<double> q(a.size());
    double least = kInfinity;
    for (int k = 0; k <= samples; ++k) {
      certifier_.scene().space().interpolate(a, b, static_cast<double>(k) / samples, q);
      least = std::min(least, certifier_.clearance(q, 1e-7).clearance.upper);
    }
    return least;
  }

 private:
  EdgeCertifier certifier_;
};

std::vector<double> near(Random& random, const CompiledScene& scene, const std::vector<double>& a,
                         double share) {
  std::vector<double> b(a.size());
  const std::vector<double> far = robots::testing::randomConfiguration(random, scene.model());
  scene.space().interpolate(a, far, share, b);
  return b;
}

TEST(ClearancePairs, IntervalsHoldDenseSamplesOfTheirPairsAlone) {
  Random random(241);
  int asked = 0, proven = 0, refuted = 0, apart = 0;
  for (int p = 0; p < 25; ++p) {
    Problem problem = testing::randomProblem(random, testing::randomTreeWithShapes(random), 5, 1.0);
    if (p % 3 == 0)
      problem.margins.pairs.push_back(
          {problem.world.objects[0].name, problem.robot.model->links[2].name, 0.03});
    const auto scene = std::make_shared<const CompiledScene>(problem);
    EdgeCertifier certifier(scene), without_lanes(scene);
    without_lanes.rebind(scene->withShapes({}));
    for (const Pairs pairs : {Pairs::kWorld, Pairs::kSelf}) {
      DensePairs dense(*scene, pairs);
      for (int e = 0; e < 6; ++e) {
        const std::vector<double> a = robots::testing::randomConfiguration(random, scene->model());
        const std::vector<double> b = near(random, *scene, a, random.uniform(0.02, 0.4));
        const double truth = dense.along(a, b, 60);
        for (EdgeCertifier* by : {&certifier, &without_lanes}) {
          ++asked;
          const EdgeClearance found = by->edgeClearance(a, b, {.tolerance = 1e-3, .pairs = pairs});
          EXPECT_LE(found.clearance.lower, truth + 1e-7) << "problem " << p;
          EXPECT_LE(by->roughClearance(a, b, 0.1, pairs).clearance.lower, truth + 1e-7)
              << "problem " << p;
          for (const double share : {0.5, 0.9, 1.3}) {
            const double wanted = std::max(0.01, share * truth);
            const EdgeClearance proof =
                by->proveClearance(a, b, {.tolerance = 1e-4, .wanted = wanted, .pairs = pairs});
            EXPECT_LE(proof.clearance.lower, truth + 1e-7) << "problem " << p;
            EXPECT_GE(proof.clearance.upper, found.clearance.lower - 1e-9) << "problem " << p;
            proven += proof.clearance.lower >= wanted ? 1 : 0;
            refuted += proof.clearance.upper < wanted ? 1 : 0;
          }
          if (found.pair >= 0) {
            EXPECT_EQ(
                scene->isOfRobot(scene->scene().pairs()[static_cast<std::size_t>(found.pair)]),
                pairs == Pairs::kSelf);
            ++apart;
          }
        }
      }
    }
  }
  std::printf("asked %d proven %d refuted %d of %d\n", asked, proven, refuted, 3 * asked);
  EXPECT_GT(proven, asked / 3);
  EXPECT_GT(refuted, asked / 3);
  EXPECT_GT(apart, asked / 2);
}

TEST(ClearancePairs, CertificatesHoldDenseSamplesAndAgreeWithTheirParts) {
  Random random(242);
  int certified = 0, telling = 0, longer = 0;
  for (int p = 0; p < 60; ++p) {
    const Problem problem =
        testing::randomProblem(random, testing::randomTreeWithShapes(random), 3, 1.3);
    const auto scene = std::make_shared<const CompiledScene>(problem);
    EdgeCertifier certifier(scene);
    Path path;
    path.positions.push_back(robots::testing::randomConfiguration(random, scene->model()));
    for (int i = 0; i < 3; ++i)
      path.positions.push_back(near(random, *scene, path.positions.back(), 0.15));
    const Certificate certificate = certify(certifier, path, 1e-4, CertificateDetail::kPath);
    EXPECT_EQ(certificate.segments.size(), path.positions.size() - 1);
    // Rows are straight lines, some of them longer than an edge.
    const PathEdges lines = edgesOf(scene->space(), path);
    const std::vector<std::vector<double>>& points = lines.path.positions;
    longer += static_cast<int>(points.size() - path.positions.size());
    certified += certificate.certified ? 1 : 0;
    for (const Pairs pairs : {Pairs::kWorld, Pairs::kSelf}) {
      const PathClearance& part = pairs == Pairs::kWorld ? certificate.world : certificate.self;
      DensePairs dense(*scene, pairs);
      double truth = kInfinity;
      for (std::size_t i = 1; i < points.size(); ++i)
        truth = std::min(truth, dense.along(points[i - 1], points[i], 40));
      EXPECT_LE(part.clearance.lower, truth + 1e-7) << "problem " << p;
      EXPECT_GE(part.clearance.upper, truth - 0.03) << "samples are some 0.03 apart";
      telling += certificate.certified && truth < 0.1 && part.clearance.lower > 0.7 * truth ? 1 : 0;
    }
    EXPECT_EQ(certificate.clearance.lower,
              std::min(certificate.world.clearance.lower, certificate.self.clearance.lower));
    EXPECT_EQ(certificate.clearance.upper,
              std::min(certificate.world.clearance.upper, certificate.self.clearance.upper));
    double least = kInfinity;
    for (const Interval& segment : certificate.segments) least = std::min(least, segment.lower);
    EXPECT_EQ(certificate.clearance.lower, least);
  }
  std::printf("certified %d, telling %d\n", certified, telling);
  EXPECT_GT(certified, 3);
  EXPECT_GT(telling, 2);
  EXPECT_GT(longer, 5);
}

}  // namespace
}  // namespace leeway::planner
