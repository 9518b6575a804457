#include "collision/cover/ball_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using oracle::Random;

/// Separation of a point from the shape.
Interval at(const Shape& shape, const Eigen::Vector3d& p, Scratch& scratch) {
  Pose X_GP;
  X_GP.translation = p;
  return distance(Shape::sphere(0), X_GP, shape, Pose{}, {}, scratch).distance;
}

bool inside(const std::vector<Ball>& balls, const Eigen::Vector3d& p, double share) {
  for (const Ball& ball : balls)
    if ((p - ball.center).norm() <= share * ball.radius) return true;
  return false;
}

TEST(BallCover, HoldsTheShapeAndIsHeldByIt) {
  Random random(21);
  Scratch scratch;
  int points = 0, lost = 0, inner_points = 0, left = 0;
  for (int round = 0; round < casesToAsk(120); ++round) {
    const auto type = static_cast<ShapeType>(random.below(9));
    if (type == ShapeType::kHalfSpace) continue;
    const oracle::Flavour flavour = oracle::kFlavours[static_cast<std::size_t>(random.below(6))];
    const Shape shape = oracle::randomShape(random, type, flavour);
    const BallCover cover = coverWithBalls(shape, 8);
    ASSERT_FALSE(cover.outer.empty());
    ASSERT_LE(cover.outer.size(), 8U);
    const double size = shape.boundingRadius();
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d p =
          shape.boundingCenter() + random.direction() * size * random.uniform(0, 1.05);
      if (at(shape, p, scratch).upper < 0) {
        ++points;
        EXPECT_TRUE(inside(cover.outer, p, 1)) << oracle::replay(shape) << p.transpose();
        if (!inside(cover.outer, p, 0.8)) ++lost;
      }
    }
    // Surface points: those nearest to points outside.
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3d p = shape.boundingCenter() + random.direction() * size * 1.5;
      Pose X_GP;
      X_GP.translation = p;
      const DistanceResult r = distance(Shape::sphere(0), X_GP, shape, Pose{}, {}, scratch);
      ++points;
      EXPECT_TRUE(inside(cover.outer, r.point_b, 1 + 1e-6)) << oracle::replay(shape);
      if (!inside(cover.outer, r.point_b, 0.8)) ++lost;
    }
    for (const Ball& ball : cover.inner)
      for (int i = 0; i < 20; ++i) {
        const Eigen::Vector3d direction = random.direction();
        ++inner_points;
        EXPECT_LE(at(shape, ball.center + ball.radius * direction, scratch).lower, 1e-9 * size)
            << oracle::replay(shape);
        if (at(shape, ball.center + 1.3 * ball.radius * direction, scratch).lower > 0) ++left;
      }
  }
  EXPECT_GT(points, casesToAsk(3000));
  EXPECT_GT(lost, casesToAsk(300));  // detects balls a fifth too small
  EXPECT_GT(inner_points, casesToAsk(2000));
  EXPECT_GT(left, casesToAsk(100));
}

/// A small body in a large cavity of a closed mesh is inside its balls.
TEST(BallCover, HoldsWhatIsInsideAClosedMesh) {
  Random random(22);
  const Shape box = Shape::mesh(oracle::boxMesh({1, 0.7, 0.4}));
  const BallCover cover = coverWithBalls(box, 8);
  for (int i = 0; i < 2000; ++i)
    EXPECT_TRUE(
        inside(cover.outer,
               {random.uniform(-1, 1), random.uniform(-0.7, 0.7), random.uniform(-0.4, 0.4)}, 1));
  EXPECT_EQ(cover.inner.size(), 8U);
  EXPECT_EQ(coverOf(box).get(), coverOf(box).get());  // made once
}

/// Distance of a point outside the hull of a part's coarse points, and of its fine points.
std::pair<double, double> outside(const CoverPart& part, const Eigen::Vector3d& p,
                                  Scratch& scratch) {
  const auto from = [&](const std::vector<Eigen::Vector3d>& points) {
    return at(Shape::convexHull(ConvexHull::compute(points)), p, scratch).lower;
  };
  const PointCover& points = part.points;
  return {from(points.points) - points.radius,
          points.fine.empty() ? 0 : from(points.fine) - points.fine_radius};
}

/// A mesh in parts: every point on or in it is in some part's ball and hulls.
TEST(BallCover, PartsHoldTheMeshAndWhatIsInside) {
  Random random(23);
  Scratch scratch;
  int points = 0, lost = 0, covers = 0, empty = 0;
  for (int round = 0; round < casesToAsk(24); ++round) {
    // Two bars and a corner block, randomly turned; every fourth has large faces only.
    const double x = random.uniform(0.2, 1), y = random.uniform(0.2, 1), w = 0.1;
    std::vector<Eigen::Vector3d> vertices;
    std::vector<TriangleMesh::Triangle> triangles;
    const Eigen::Matrix3d R = round % 4 == 0 ? Eigen::Matrix3d::Identity() : random.rotation();
    const auto addBox = [&](const Eigen::Vector3d& center, const Eigen::Vector3d& half) {
      const auto box = oracle::boxMesh(half);
      const auto first = static_cast<std::int32_t>(vertices.size());
      for (const Eigen::Vector3d& v : box->vertices()) vertices.push_back(R * (center + v));
      for (const auto& t : box->triangles())
        triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    };
    addBox({x, 0, 0}, {x, w, w});
    addBox({0, y, 0}, {w, y, w});
    addBox({0, 0, random.uniform(-0.3, 0.3)}, {1.5 * w, 1.2 * w, w});
    const Shape shape = Shape::mesh(TriangleMesh::make(vertices, triangles));
    const int most = 2 + static_cast<int>(random.below(7));
    const std::vector<CoverPart> parts = coverWithParts(shape, most);
    ASSERT_LE(static_cast<int>(parts.size()), most);
    ++covers;
    if (parts.empty()) ++empty;
    const auto isHeld = [&](const Eigen::Vector3d& p) {
      return std::any_of(parts.begin(), parts.end(), [&](const CoverPart& part) {
        const auto [few, fine] = outside(part, p, scratch);
        return (p - part.ball.center).norm() <= part.ball.radius * (1 + 1e-9) && few <= 1e-9 &&
               fine <= 1e-9;
      });
    };
    const Shape hull = Shape::convexHull(ConvexHull::compute(vertices));
    for (int i = 0; i < 60 && !parts.empty(); ++i) {
      const auto& t =
          triangles[static_cast<std::size_t>(random.below(static_cast<int>(triangles.size())))];
      const auto corner = [&](std::size_t k) { return vertices[static_cast<std::size_t>(t[k])]; };
      const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
      const Eigen::Vector3d on =
          corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0));
      ++points;
      EXPECT_TRUE(isHeld(on)) << on.transpose();
      const Eigen::Vector3d p = shape.boundingCenter() +
                                random.direction() * shape.boundingRadius() * random.uniform(0, 1);
      if (at(shape, p, scratch).upper < 0) {
        ++points;
        EXPECT_TRUE(isHeld(p)) << p.transpose();
      } else if (at(hull, p, scratch).upper < 0 && !isHeld(p)) {
        ++lost;  // in the hull, but in no part
      }
    }
  }
  EXPECT_EQ(empty, 0);
  EXPECT_GT(points, 50 * covers);
  EXPECT_GT(lost, 2 * covers);
  EXPECT_TRUE(coverWithParts(Shape::mesh(oracle::boxMesh({1, 0.7, 0.4})), 8).empty());
}

}  // namespace
}  // namespace leeway::collision
