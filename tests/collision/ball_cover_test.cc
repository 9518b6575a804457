#include "leeway/collision/ball_cover.h"

#include <gtest/gtest.h>

#include "leeway/collision/distance.h"
#include "tests/sanitized.h"
#include "tools/oracle/generate.h"

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
    // Surfaces: what is nearest to points outside.
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
  EXPECT_GT(lost, casesToAsk(300));  // balls that are a fifth too small are found out
  EXPECT_GT(inner_points, casesToAsk(2000));
  EXPECT_GT(left, casesToAsk(100));
}

/// A small thing in a large hollow between the surfaces of a closed mesh is inside its balls.
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

}  // namespace
}  // namespace leeway::collision
