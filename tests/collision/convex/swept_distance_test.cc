#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "collision/convex/convex_distance.h"
#include "leeway/collision/distance.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

constexpr ShapeType kTypes[8] = {
    ShapeType::kSphere, ShapeType::kCapsule,   ShapeType::kBox,       ShapeType::kCylinder,
    ShapeType::kCone,   ShapeType::kEllipsoid, ShapeType::kHalfSpace, ShapeType::kConvexHull};

TEST(SweptDistance, AMovingPointIsASegment) {
  Scratch scratch;
  const Shape point = Shape::sphere(0.25), ball = Shape::sphere(0.5);
  const Pose from{Eigen::Matrix3d::Identity(), Vector3d(-5, 3, 0)};
  const Pose to{Eigen::Matrix3d::Identity(), Vector3d(7, 3, 0)};
  const DistanceResult r = sweptDistance(point, from, to, 0.125, ball, {}, scratch);
  EXPECT_EQ(r.status, DistanceStatus::kConverged);
  EXPECT_LE(r.distance.lower, 3 - 0.25 - 0.5 - 0.125);
  EXPECT_NEAR(r.distance.lower, 3 - 0.25 - 0.5 - 0.125, 2e-9);
}

/// Points of A at both placements and at all times between are at least as far away as claimed.
TEST(SweptDistance, ClaimsNoMoreThanAnyPlacementOnTheWayHas) {
  Scratch scratch;
  Random random(3);
  int positive = 0, contact = 0;
  for (int i = 0; i < casesToAsk(6000); ++i) {
    const Shape a = oracle::randomShape(random, kTypes[random.below(8)], oracle::Flavour::kPlain);
    const Shape b = oracle::randomShape(random, kTypes[random.below(8)], oracle::Flavour::kPlain);
    if (a.type() == ShapeType::kHalfSpace) continue;
    const double size = oracle::sizeOf(a) + oracle::sizeOf(b);
    Pose X0{random.rotation(), size * random.uniform(0.3, 2) * random.direction()};
    Pose X1{X0.rotation, X0.translation + 0.5 * size * random.unit() * random.direction()};
    DistanceRequest request;
    request.threshold = random.chance(0.5) ? 0 : std::numeric_limits<double>::quiet_NaN();
    const double growth = 0.01 * size * random.unit();
    const DistanceResult r = sweptDistance(a, X0, X1, growth, b, request, scratch);
    positive += r.distance.lower > 0;
    contact += r.status == DistanceStatus::kNotAboveThreshold;
    double ends = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 8; ++k) {
      // A translation moves every point along its chord.
      const Pose X{X0.rotation, X0.translation + k / 8.0 * (X1.translation - X0.translation)};
      const DistanceResult at = distance(a, X, b, {}, {}, scratch);
      ASSERT_LE(r.distance.lower, at.distance.upper - growth + 1e-12 * size)
          << oracle::replay(a) << " from " << oracle::replay(X0) << " to " << oracle::replay(X1)
          << " " << oracle::replay(b);
      if (k == 0 || k == 8) ends = std::min(ends, at.distance.lower);
    }
    ASSERT_GE(r.distance.upper, ends) << oracle::replay(a) << oracle::replay(b);
  }
  EXPECT_GT(positive, casesToAsk(2000));
  EXPECT_GT(contact, casesToAsk(100));
}

/// The hull of two placements of points is a hull of twice the number of points.
TEST(SweptDistance, IsTheDistanceOfTheHullOfBothPlacements) {
  Scratch scratch;
  Random random(5);
  int apart = 0;
  for (int i = 0; i < casesToAsk(1500); ++i) {
    std::vector<Vector3d> points(static_cast<std::size_t>(1 + random.below(60)));
    for (Vector3d& p : points) p = random.unit() * random.direction();
    const Shape a = Shape::convexHull(points);
    const Shape b = oracle::randomShape(random, kTypes[random.below(8)], oracle::Flavour::kPlain);
    const Pose X0{random.rotation(), random.uniform(0.5, 4) * random.direction()};
    const Pose X1{random.rotation(), X0.translation + random.direction()};
    std::vector<Vector3d> both;
    for (const Vector3d& p : points) {
      both.push_back(X0 * p);
      both.push_back(X1 * p);
    }
    const DistanceResult hull = distance(Shape::convexHull(both), {}, b, {}, {}, scratch);
    const double growth = random.chance(0.5) ? 0 : 0.01;
    const DistanceResult r = sweptDistance(a, X0, X1, growth, b, {}, scratch);
    ASSERT_LE(r.distance.lower, hull.distance.upper - growth + 1e-13);
    if (hull.distance.lower <= 1e-6) continue;
    ++apart;
    ASSERT_EQ(r.status, DistanceStatus::kConverged)
        << i << " hull [" << hull.distance.lower << ", " << hull.distance.upper << "] swept "
        << r.distance.lower << " growth " << growth << " " << oracle::replay(a)
        << oracle::replay(b);
    ASSERT_GE(r.distance.lower, hull.distance.lower - growth - 2e-9);
  }
  EXPECT_GT(apart, casesToAsk(700));
}

TEST(SweptDistance, ThresholdsAndLimitsAreHonest) {
  Scratch scratch;
  Random random(4);
  PairCache cache;
  int above = 0, open = 0;
  for (int i = 0; i < casesToAsk(3000); ++i) {
    const Shape a = oracle::randomShape(random, kTypes[random.below(6)], oracle::Flavour::kPlain);
    const Shape b = oracle::randomShape(random, kTypes[random.below(8)], oracle::Flavour::kPlain);
    const double size = oracle::sizeOf(a) + oracle::sizeOf(b);
    const Pose X0{random.rotation(), size * random.uniform(0.3, 2) * random.direction()};
    const Pose X1{random.rotation(), X0.translation + 0.3 * size * random.direction()};
    const DistanceResult exact = sweptDistance(a, X0, X1, 0, b, {}, scratch);
    DistanceRequest request;
    request.threshold = 0.1 * size;
    request.iteration_limit = random.below(20);
    const DistanceResult r = sweptDistance(a, X0, X1, 0, b, request, scratch, &cache);
    if (r.status == DistanceStatus::kAboveThreshold) {
      EXPECT_GT(r.distance.lower, request.threshold);
    }
    if (r.distance.lower > request.threshold) {
      ++above;
      if (exact.status == DistanceStatus::kConverged) {
        EXPECT_LE(r.distance.lower, exact.distance.lower + 1e-8 * size);
      }
    } else {
      ++open;
    }
  }
  EXPECT_GT(above, casesToAsk(500));
  EXPECT_GT(open, casesToAsk(500));
}

// Up to 32 points run in lanes; more (here copies of one of them) in scalar steps.
TEST(SweptDistance, LanesFindWhatPlainStepsFind) {
  Scratch scratch;
  Random random(11);
  int apart = 0, near = 0, above = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    const auto pointsAround = [&](int count) {
      std::vector<Vector3d> points;
      for (int k = 0; k < count; ++k)
        points.push_back(random.direction().cwiseProduct(Vector3d(1, 0.7, random.unit())));
      return points;
    };
    std::vector<Vector3d> a = pointsAround(1 + random.below(32));
    const std::vector<Vector3d> b = pointsAround(1 + random.below(50));
    const auto count = static_cast<int>(a.size());
    const Vector3d first = a.front();
    a.resize(40, first);
    const Pose X0{random.rotation(), random.uniform(0.5, 4.0) * random.direction()};
    Pose X1{random.rotation(), X0.translation + random.uniform(0.0, 2.0) * random.direction()};
    if (random.chance(0.3)) X1.rotation = X0.rotation;
    const ConvexView view_b = random.chance(0.3)
                                  ? viewOf(Shape::box({0.3, 0.2, 0.5}))
                                  : viewOfPoints(b.data(), static_cast<int>(b.size()), 0.01);
    DistanceRequest request;
    if (random.chance(0.6)) request.threshold = random.uniform(0.0, 1.0);
    const auto ask = [&](int points) {
      return convexSweptDistance(viewOfPoints(a.data(), points, 0), X0, X1, 0.02, view_b, request,
                                 scratch, nullptr, 0);
    };
    const DistanceResult lanes = ask(count), plain = ask(40);
    if (std::isnan(request.threshold)) {
      ASSERT_EQ(lanes.distance.lower > 0, plain.distance.lower > 0) << "case " << i;
      if (!(lanes.distance.lower > 0)) {
        ++near;
        continue;
      }
      ++apart;
      ASSERT_NEAR(lanes.distance.lower, plain.distance.lower, 2e-9) << "case " << i;
    } else {
      above += lanes.distance.lower > request.threshold;
      ASSERT_EQ(lanes.distance.lower > request.threshold, plain.distance.lower > request.threshold)
          << "case " << i;
    }
  }
  EXPECT_GT(apart, casesToAsk(4000) / 10);
  EXPECT_GT(near, casesToAsk(4000) / 20);
  EXPECT_GT(above, casesToAsk(4000) / 10);
}

TEST(SweptDistance, BadPosesAreRefused) {
  Scratch scratch;
  const Shape box = Shape::box({1, 1, 1});
  Pose good, bad;
  good.translation.x() = 5;
  bad.translation.x() = std::nan("");
  EXPECT_EQ(sweptDistance(box, good, bad, 0, box, {}, scratch).status, DistanceStatus::kInvalid);
  EXPECT_EQ(sweptDistance(box, bad, good, 0, box, {}, scratch).status, DistanceStatus::kInvalid);
  EXPECT_EQ(sweptDistance(box, good, good, -1, box, {}, scratch).status, DistanceStatus::kInvalid);
  EXPECT_EQ(sweptDistance(box, good, good, std::nan(""), box, {}, scratch).status,
            DistanceStatus::kInvalid);
}

}  // namespace
}  // namespace leeway::collision
