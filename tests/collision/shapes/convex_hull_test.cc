#include "leeway/collision/convex_hull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/exact_predicates.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/shape.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using testing::Random;

// Checks by exact signs, without tolerances: convex, closed, holds every point.
void expectExactHull(const ConvexHull& hull, const std::vector<Vector3d>& points,
                     const std::string& what) {
  SCOPED_TRACE(what);
  const auto at = [&](std::int32_t i) { return hull.vertices()[static_cast<std::size_t>(i)]; };
  ASSERT_FALSE(hull.vertices().empty());
  for (const Vector3d& v : hull.vertices())
    EXPECT_TRUE(std::find(points.begin(), points.end(), v) != points.end());
  if (hull.facets().empty()) return;
  EXPECT_EQ(hull.facets().size(), 2 * hull.vertices().size() - 4);
  int outside = 0;
  for (const auto& f : hull.facets()) {
    for (const Vector3d& p : points)
      outside += orientation(at(f[0]), at(f[1]), at(f[2]), p) > 0 ? 1 : 0;
    EXPECT_FALSE(collinear(at(f[0]), at(f[1]), at(f[2])));
  }
  EXPECT_EQ(outside, 0);
}

// Support over the vertices equals support over all points: slow twin of every hull, flat ones
// included.
void expectSameSupport(const ConvexHull& hull, const std::vector<Vector3d>& points,
                       const std::string& what) {
  SCOPED_TRACE(what);
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Vector3d d = random.direction();
    double of_points = -std::numeric_limits<double>::infinity(), of_hull = of_points;
    for (const Vector3d& p : points) of_points = std::max(of_points, d.dot(p));
    for (const Vector3d& p : hull.vertices()) of_hull = std::max(of_hull, d.dot(p));
    EXPECT_EQ(of_points, of_hull);
  }
}

TEST(ConvexHull, HoldsEveryPointExactly) {
  Random random(1);
  const int most = kSanitized ? 150 : 400;  // exact arithmetic, as many facets as points
  for (const double size : {1e-6, 1.0, 1e3}) {
    for (int n = 4; n < most; n = n * 3 / 2) {
      std::vector<Vector3d> ball, cube, grid, line, plane, sphere;
      const Pose X = random.pose(size);
      for (int i = 0; i < n; ++i) {
        cube.push_back(size * random.vector());
        sphere.push_back(X * (size * random.direction()));
        grid.push_back(size * Vector3d(random.below(4), random.below(4), random.below(4)));
        plane.push_back(X * (size * Vector3d(random.uniform(), random.uniform(), 0)));
        line.push_back(X * (size * Vector3d(random.uniform(), 0, 0)));
      }
      for (const auto& [name, points] : {std::pair{"cube", &cube},
                                         {"sphere", &sphere},
                                         {"grid", &grid},
                                         {"rounded plane", &plane},
                                         {"rounded line", &line}}) {
        const auto hull = ConvexHull::compute(*points);
        const std::string what =
            std::string(name) + " " + std::to_string(n) + " size " + std::to_string(size);
        expectExactHull(*hull, *points, what);
        expectSameSupport(*hull, *points, what);
      }
    }
  }
}

TEST(ConvexHull, FlatSetsHaveNoFacets) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) points.emplace_back(i, j, i + 2 * j);  // exactly flat, oblique
  }
  points.insert(points.end(), points.begin(), points.end());
  const auto square = ConvexHull::compute(points);
  EXPECT_EQ(square->vertices().size(), 4U);
  EXPECT_TRUE(square->facets().empty());
  expectSameSupport(*square, points, "square");

  std::vector<Vector3d> straight;
  for (int i = 0; i < 9; ++i) straight.emplace_back(3 * (i % 5), -i % 5, 7 * (i % 5));
  EXPECT_EQ(
      ConvexHull::compute(std::vector<Vector3d>{{0, 0, 0}, {3, -1, 7}, {6, -2, 14}, {0, 0, 0}})
          ->vertices()
          .size(),
      2U);
  EXPECT_EQ(
      ConvexHull::compute(std::vector<Vector3d>(5, Vector3d(0.1, 0.2, 0.3)))->vertices().size(),
      1U);
}

// Regression: only the first 64 vertices of flat hulls were used; this disc was cut off at 154
// degrees.
TEST(ConvexHull, FlatHullsOfManyVerticesReachAsFarAsTheirVertices) {
  constexpr int kCount = 150;
  std::vector<Vector3d> points;
  for (int i = 0; i < kCount; ++i) {
    const double angle = 2 * 3.14159265358979312 * i / kCount;
    points.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  const Shape disc = Shape::convexHull(points), point = Shape::sphere(0);
  const Shape other = Shape::convexHull(std::vector<Vector3d>{{0, 0, 0}, {0, 0, 1}, {0, 1, 1}});
  Scratch scratch;
  for (const Vector3d& p : points) {
    const Pose X{Eigen::Matrix3d::Identity(), 2 * p};
    EXPECT_NEAR(distance(disc, {}, point, X, {}, scratch).distance.upper, 1, 1e-9);
    EXPECT_NEAR(distance(point, X, disc, {}, {}, scratch).distance.lower, 1, 1e-9);
    const Interval hulls = distance(disc, {}, other, X, {}, scratch).distance;
    EXPECT_LE(hulls.width(), 1e-9);
    EXPECT_LE(hulls.lower, 1);
    EXPECT_GE(hulls.upper, distance(disc, {}, Shape::sphere(1), X, {}, scratch).distance.lower);
  }
}

TEST(ConvexHull, PointsWithinFacesAndEdgesAreNoVertices) {
  std::vector<Vector3d> points;
  for (int i = 0; i <= 8; ++i) {
    for (int j = 0; j <= 8; ++j) {
      for (int k = 0; k <= 8; ++k) points.emplace_back(i, j, k);
    }
  }
  const auto cube = ConvexHull::compute(points);
  EXPECT_EQ(cube->vertices().size(), 8U);
  EXPECT_EQ(cube->facets().size(), 12U);
  expectExactHull(*cube, points, "grid of a cube");
}

TEST(ConvexHull, NeighboursAreTheEdges) {
  Random random(3);
  std::vector<Vector3d> points;
  for (int i = 0; i < 300; ++i) points.push_back(random.direction());
  const auto hull = ConvexHull::compute(points);
  ASSERT_TRUE(hull->hasNeighbours());
  // Climbing from any vertex reaches the farthest one.
  for (int i = 0; i < 300; ++i) {
    const Vector3d d = random.direction();
    const auto value = [&](std::int32_t v) {
      return d.dot(hull->vertices()[static_cast<std::size_t>(v)]);
    };
    std::int32_t v = random.below(static_cast<int>(hull->vertices().size()));
    for (bool better = true; better;) {
      better = false;
      for (const std::int32_t n : hull->neighbours(v)) {
        if (value(n) <= value(v)) continue;
        v = n;
        better = true;
      }
    }
    for (std::size_t w = 0; w < hull->vertices().size(); ++w)
      EXPECT_LE(value(static_cast<std::int32_t>(w)), value(v));
  }
}

TEST(ConvexHull, ManyPointsOnASphere) {
  Random random(4);
  std::vector<Vector3d> points;
  const int count = casesToAsk(50000);
  for (int i = 0; i < count; ++i) points.push_back(random.direction());
  const auto hull = ConvexHull::compute(points);
  EXPECT_EQ(hull->facets().size(), 2 * hull->vertices().size() - 4);
  EXPECT_GT(hull->vertices().size(), points.size() * 98 / 100);
}

TEST(ConvexHull, CoordinatesTooSmallForExactnessAreZero) {
  const std::vector<Vector3d> points = {
      {0, 0, 0}, {1, 0, 1e-200}, {0, 1, 0}, {1, 1, -1e-200}, {0.5, 0.5, 1}};
  const auto hull = ConvexHull::compute(points);
  for (const Vector3d& v : hull->vertices()) {
    EXPECT_TRUE(v.z() == 0 || v.z() == 1);
  }
}

TEST(ConvexHull, RejectsWhatHasNoHull) {
  EXPECT_THROW(ConvexHull::compute({}), InvalidShape);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), -std::nextafter(1e9, 2e9)}) {
    EXPECT_THROW(ConvexHull::compute(std::vector<Vector3d>{{0, bad, 0}}), InvalidShape);
  }
}

}  // namespace
}  // namespace leeway::collision
