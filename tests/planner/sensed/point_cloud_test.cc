// Clouds from memory, and what filters promise, against brute force.

#include "leeway/planner/point_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <set>

#include "leeway/collision/distance.h"

namespace leeway::planner {
namespace {

using Eigen::Vector3d;
using Ball = PointCloud::Ball;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PointCloud randomCloud(unsigned seed, std::size_t count, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-size, size), radius(0.001, 0.03);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i)
    cloud.balls.push_back({{place(random), place(random), place(random)}, radius(random)});
  return cloud;
}

bool contains(const Ball& outer, const Ball& inner) {
  return (outer.center - inner.center).norm() + inner.radius <= outer.radius * (1 + 1e-12);
}

TEST(PointCloud, ArraysWithStridesAndBothPrecisions) {
  struct Point {
    std::uint16_t before;
    float xyz[3];
    std::uint8_t rgb[3];
  } const floats[] = {{1, {1, 2, 3}, {}}, {2, {0.1F, NAN, 0}, {}}, {3, {-4, 5, 0.1F}, {}}};
  const PointCloud a = makeCloud({&floats[0].xyz, 3, sizeof(Point)}, 0.5);
  ASSERT_EQ(a.size(), 2U);
  EXPECT_EQ(a.balls[1].center, Vector3d(-4, 5, double(0.1F)));
  EXPECT_EQ(a.balls[1].radius, 0.5);
  EXPECT_EQ(a.filters.at(0).removed, 1U);
  const double doubles[] = {1, 2, 3, 0.1, 0, HUGE_VAL, 7, 8, 9};
  const double radii[] = {1, kNaN, 3};  // that of a dropped point does not matter
  const PointCloud b = makeCloud({doubles, 3, 24, PointArray::Number::kDouble}, radii);
  ASSERT_EQ(b.size(), 2U);
  EXPECT_EQ(b.balls[1].center, Vector3d(7, 8, 9));
  EXPECT_EQ(b.balls[1].radius, 3);
}

TEST(PointCloud, StridesThatPointsDoNotFitInAreRefused) {
  const double doubles[] = {0.5, 0, 0, 0.6, 0, 0};
  const float floats[] = {0.5, 0, 0, 0.6F, 0, 0};
  using Type = PointArray::Number;
  for (const PointArray& packed :
       {PointArray{.first = doubles, .count = 2, .number = Type::kDouble},
        PointArray{.first = floats, .count = 2}}) {
    const PointCloud cloud = makeCloud(packed, 0.02);
    ASSERT_EQ(cloud.size(), 2U);
    EXPECT_NEAR((cloud.balls[1].center - Vector3d(0.6, 0, 0)).norm(), 0, 1e-7);
  }
  for (const std::size_t stride : {1U, 4U, 12U, 23U})
    EXPECT_THROW(makeCloud({doubles, 2, stride, Type::kDouble}, 0.02), std::invalid_argument);
  for (const std::size_t stride : {1U, 4U, 11U})
    EXPECT_THROW(makeCloud({floats, 2, stride}, 0.02), std::invalid_argument);
  EXPECT_THROW(makeCloud({nullptr, 2}, 0.02), std::invalid_argument);
  EXPECT_EQ(makeCloud(PointArray{}, 0.02).size(), 0U);
}

TEST(PointCloud, ACloudWithoutABallIsAFaultUnlessAFilterRemovedAll) {
  EXPECT_NE(cloudFault(makeCloud(PointArray{}, 0.02)), "");
  const float nan[] = {NAN, 0, 0, 1, NAN, 1};
  EXPECT_NE(cloudFault(makeCloud({nan, 2}, 0.02)).find("dropped 2 points"), std::string::npos);
  const float far[] = {9, 0, 0};
  const std::vector<Ball> reach = {{{0, 0, 0}, 1}};
  EXPECT_EQ(cloudFault(cropped(makeCloud({far, 1}, 0.02), {}, reach, 0.1)), "");
  EXPECT_NE(cloudFault(cropped(makeCloud({nan, 2}, 0.02), {}, reach, 0.1)), "");
}

TEST(PointCloud, BadRadiiAndCoordinatesAreRefused) {
  const double points[] = {1, 2, 3, 4, 1.1e9, 6};
  const auto cloud = [&](std::size_t count, double radius) {
    return makeCloud({points, count, 24, PointArray::Number::kDouble}, radius);
  };
  for (const double radius : {0.0, -1.0, 1e-10, 1.1e9, kNaN, double(INFINITY)})
    EXPECT_THROW(cloud(1, radius), std::invalid_argument) << radius;
  EXPECT_EQ(cloud(1, 1e-9).size(), 1U);
  EXPECT_THROW(cloud(2, 1), std::invalid_argument);
  EXPECT_THROW(makeCloud({points, 1, 24}, std::vector<double>{1, 2}), std::invalid_argument);
  EXPECT_THROW(thinned(PointCloud(), 0), std::invalid_argument);
  EXPECT_THROW(thinned(PointCloud(), kNaN), std::invalid_argument);
  EXPECT_THROW(carved(PointCloud(), {}, {}, -1, "x"), std::invalid_argument);
  EXPECT_THROW(cropped(PointCloud(), {}, {}, kNaN), std::invalid_argument);
}

TEST(PointCloud, ThinningContainsAllThatItRemoves) {
  int merged = 0;
  for (unsigned seed = 1; seed <= 5; ++seed)
    for (const double cell : {0.01, 0.08, 1.0}) {
      const PointCloud cloud = randomCloud(seed, 400, 0.3), thin = thinned(cloud, cell);
      for (const Ball& ball : cloud.balls)
        EXPECT_TRUE(std::any_of(thin.balls.begin(), thin.balls.end(),
                                [&](const Ball& outer) { return contains(outer, ball); }));
      EXPECT_EQ(thin.filters.back().removed, cloud.size() - thin.size());
      std::set<std::array<double, 3>> cells;
      for (const Ball& ball : cloud.balls)
        cells.insert({std::floor(ball.center.x() / cell), std::floor(ball.center.y() / cell),
                      std::floor(ball.center.z() / cell)});
      EXPECT_EQ(thin.size(), cells.size());
      EXPECT_LE(thin.largestRadius(), cell * std::sqrt(3.0) / 2 + 0.03 + 1e-9);
      merged += static_cast<int>(cloud.size() - thin.size());
    }
  EXPECT_GT(merged, 2000);
  // A ball alone in its cell stays as it is, also far from the origin.
  PointCloud alone;
  alone.balls = {{{1e9, -1e9, 0.1}, 1e-9}, {{0.3, 0.1, 0.2}, 0.02}};
  const PointCloud kept = thinned(alone, 1e-9);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept.balls[0].center, alone.balls[0].center);
  EXPECT_EQ(kept.balls[1].radius, 0.02);
}

TEST(PointCloud, ThinningToANumberContainsAllThatItRemoves) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1), radius(0.001, 0.03);
  PointCloud cloud;
  for (int i = 0; i < 700; ++i) {
    const double x = place(random), y = place(random);
    cloud.balls.push_back({{x, y, 0.3 * std::sin(3 * x)}, radius(random)});
  }
  for (int i = 0; i < 20; ++i) cloud.balls.push_back(cloud.balls[0]);
  cloud.balls.push_back({{1e9, -1e9, 1e9}, 1e-9});
  cloud.balls.push_back({{0, 0, 1}, 0.1});
  cloud.balls.push_back({{0, 0, std::nextafter(1.0, 2.0)}, 0.2});
  for (const std::size_t most : {1U, 2U, 10U, 100U, 500U, 722U, 723U, 9999U}) {
    const PointCloud thin = thinnedTo(cloud, most);
    EXPECT_LE(thin.size(), most);
    EXPECT_EQ(thin.size(), std::min<std::size_t>(most, most < 703 ? most : thin.size()));
    for (const Ball& ball : cloud.balls)
      ASSERT_TRUE(std::any_of(thin.balls.begin(), thin.balls.end(), [&](const Ball& outer) {
        return contains(outer, ball);
      })) << most;
    EXPECT_EQ(thin.filters.back().name, "thin");
    EXPECT_EQ(thin.filters.back().removed, cloud.size() - thin.size());
    EXPECT_TRUE(cloudFault(thin).empty() || most == 1) << cloudFault(thin);
    // The balls are not much larger than a square grid of as many would make them.
    if (most >= 10 && most < 703) {
      EXPECT_LT(thin.largestRadius(), 0.23 + 4 / std::sqrt(double(most)));
    }
    // A ball that is alone stays as it is.
    if (most >= 2) {
      EXPECT_TRUE(std::any_of(thin.balls.begin(), thin.balls.end(), [&](const Ball& ball) {
        return ball.center == Vector3d(1e9, -1e9, 1e9) && ball.radius == 1e-9;
      }));
    }
  }
  EXPECT_THROW(thinnedTo(cloud, 0), std::invalid_argument);
  EXPECT_EQ(thinnedTo(PointCloud(), 5).size(), 0U);
}

TEST(PointCloud, CarvingRemovesWhatIsNearAndNothingElse) {
  robots::Pose X_WC;
  X_WC.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  X_WC.translation = {0.1, -0.2, 0.3};
  const std::vector<robots::Geometry> shapes = {
      {collision::Shape::box({0.1, 0.05, 0.2}), {Eigen::Matrix3d::Identity(), {0.1, 0, 0.3}}, ""},
      {collision::Shape::cylinder(0.05, 0.1), {Eigen::Matrix3d::Identity(), {0, -0.3, 0.3}}, ""}};
  collision::Scratch scratch;
  for (const double margin : {0.0, 0.02}) {
    const PointCloud cloud = randomCloud(7, 5000, 0.4);
    const PointCloud rest = carved(cloud, X_WC, shapes, margin, "can");
    std::size_t near = 0, k = 0;
    for (const Ball& ball : cloud.balls) {
      double distance = 1;
      for (const robots::Geometry& shape : shapes)
        distance =
            std::min(distance, collision::distance(shape.shape, shape.X_BG,
                                                   collision::Shape::sphere(ball.radius),
                                                   {X_WC.rotation, X_WC * ball.center}, {}, scratch)
                                   .distance.upper);
      if (distance <= margin) {
        ++near;
        continue;
      }
      ASSERT_LT(k, rest.size());
      EXPECT_EQ(rest.balls[k].center, ball.center);
      ++k;
    }
    EXPECT_EQ(k, rest.size());
    EXPECT_EQ(rest.filters.back().removed, near);
    EXPECT_GT(near, 100U);
  }
}

TEST(PointCloud, FiltersRefuseAPoseThatIsNone) {
  const PointCloud cloud = randomCloud(7, 5, 1);
  const robots::Geometry all{collision::Shape::sphere(9), {}, {}};
  robots::Pose nowhere, sheared;
  nowhere.translation.x() = kNaN;
  sheared.rotation(0, 0) = 2;
  for (const robots::Pose& bad : {nowhere, sheared}) {
    EXPECT_THROW((void)carved(cloud, bad, {&all, 1}, 0, "all"), std::invalid_argument);
    EXPECT_THROW((void)cropped(cloud, bad, {}, 1), std::invalid_argument);
  }
}

TEST(PointCloud, CroppingKeepsAllThatIsInReach) {
  const std::vector<Ball> reach = {{{0.1, 0, 0}, 0.1}, {{-0.2, 0, 0.1}, 0.05}};
  robots::Pose X_WC;
  X_WC.translation = {0.05, 0, 0};
  const PointCloud cloud = randomCloud(3, 2000, 0.4);
  const PointCloud kept = cropped(cloud, X_WC, reach, 0.04);
  EXPECT_EQ(kept.completeWithin(), 0.04);
  std::size_t in_reach = 0;
  for (const Ball& ball : cloud.balls)
    in_reach += std::any_of(reach.begin(), reach.end(), [&](const Ball& of) {
      return (X_WC * ball.center - of.center).norm() - ball.radius - of.radius <= 0.04;
    });
  EXPECT_EQ(kept.size(), in_reach);
  EXPECT_GT(in_reach, 50U);
  EXPECT_LT(in_reach, 1000U);
  EXPECT_EQ(cropped(kept, X_WC, reach, 1).completeWithin(), 0.04);
  const PointCloud thin = thinnedTo(thinned(cropped(kept, X_WC, reach, 1), 0.01), 20);
  ASSERT_EQ(thin.crops.size(), 2U);
  EXPECT_EQ(thin.crops[0].X_WC.translation, X_WC.translation);
  EXPECT_EQ(cloud.completeWithin(), INFINITY);
}

TEST(PointCloud, ARegionThatIsSeenAgainIsReplaced) {
  const PointCloud cloud = randomCloud(4, 500, 0.4);
  const double all = std::numeric_limits<double>::infinity();
  const CloudRegion upper{{-all, -all, 0}, {all, all, all}};
  PointCloud seen = randomCloud(5, 30, 0.4);
  seen.filters.push_back({"drop", "points that are not numbers", 3});
  PointCloud now = renewed(renewed(cloud, upper, seen), upper, seen);
  std::vector<Ball> expected;
  const auto isBelow = [&](const Ball& ball) { return ball.center.z() < 0; };
  std::copy_if(cloud.balls.begin(), cloud.balls.end(), std::back_inserter(expected), isBelow);
  const std::size_t kept = expected.size();
  std::copy_if(seen.balls.begin(), seen.balls.end(), std::back_inserter(expected), isBelow);
  expected.insert(expected.end(), seen.balls.begin(), seen.balls.end());
  ASSERT_EQ(now.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(now.balls[i].center, expected[i].center);
  ASSERT_EQ(now.filters.size(), 2U) << "sums";
  EXPECT_EQ(now.filters[0].removed, 500 - kept + 30 - (expected.size() - kept - 30));
  EXPECT_EQ(now.filters[1].removed, 6U);
  now = renewed(now, {{-all, -all, -all}, {all, all, all}}, {});
  EXPECT_EQ(cloudFault(now), "") << "nothing is there any more";
  EXPECT_THROW((void)renewed(cloud, {{0, 0, kNaN}, {1, 1, 1}}, seen), std::invalid_argument);
  EXPECT_THROW((void)renewed(cloud, {{0, 2, 0}, {1, 1, 1}}, seen), std::invalid_argument);
  seen.crops.push_back({});
  EXPECT_THROW((void)renewed(cloud, upper, seen), std::invalid_argument);
}

/// Regression: points outside went with the larger ball that stood for them.
TEST(PointCloud, ARegionKeepsBallsThatMayStandForPointsOutside) {
  PointCloud cloud;
  for (const double x : {0.82, 0.84, 0.98}) cloud.balls.push_back({{x, 0.05, 0.05}, 0.01});
  const PointCloud thin = thinned(cloud, 0.2);
  ASSERT_TRUE(thin.isThinned());
  EXPECT_FALSE(thinned(cloud, 0.001).isThinned());
  const CloudRegion region{{0, -1, -1}, {0.95, 1, 1}}, larger{{0, -1, -1}, {1, 1, 1}};
  EXPECT_EQ(renewed(cloud, region, {}).size(), 1U);
  EXPECT_EQ(renewed(thin, region, {}).size(), 1U);
  EXPECT_EQ(renewed(thin, larger, {}).size(), 0U);
  // So do balls that are seen later.
  const PointCloud now = renewed(cloud, larger, thin);
  EXPECT_EQ(renewed(now, region, {}).size(), 1U);
}

TEST(PointCloud, ACropCoversWhatIsInsideItsReach) {
  const PointCloud::Crop crop{0.1, {}, {{{0.1, 0, 0}, 0.1}, {{-0.2, 0, 0.1}, 0.05}}};
  const auto covers = [&](std::initializer_list<Ball> balls) {
    return crop.covers(std::vector<Ball>(balls));
  };
  EXPECT_TRUE(crop.covers(crop.reach_W));
  EXPECT_TRUE(covers({{{-0.2, 0, 0.1}, 0.04}, {{0.15, 0, 0}, 0.0499}}));
  EXPECT_TRUE(covers({}));
  EXPECT_FALSE(covers({{{0.1, 0, 0}, std::nextafter(0.1, 1)}}));
  EXPECT_FALSE(covers({{{0.15, 0, 0}, 0.0501}}));
  EXPECT_FALSE(covers({{{0.1, 0, 0}, 0.1}, {{1, 0, 0}, 0.01}}));
  EXPECT_FALSE(covers({{{0.1, kNaN, 0}, 0.01}}));
  EXPECT_FALSE(covers({{{0.1, 0, 0}, kNaN}}));
}

}  // namespace
}  // namespace leeway::planner
