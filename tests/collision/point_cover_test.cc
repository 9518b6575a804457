#include "leeway/collision/point_cover.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tools/oracle/generate.h"

namespace leeway::collision {
namespace {

using oracle::Random;

// The farthest that the shape and the points reach along random directions: the shape no farther
// than points and radius, points that would be a tenth of it too near are found out.
TEST(PointCover, HoldsTheShape) {
  Random random(41);
  Scratch scratch;
  int directions = 0, tight = 0;
  for (int round = 0; round < 150; ++round) {
    const auto type = static_cast<ShapeType>(random.below(9));
    const oracle::Flavour flavour = oracle::kFlavours[static_cast<std::size_t>(random.below(6))];
    const Shape shape = oracle::randomShape(random, type, flavour);
    const PointCover cover = coverWithPoints(shape, 24);
    if (type == ShapeType::kHalfSpace) {
      EXPECT_TRUE(cover.points.empty());
      continue;
    }
    ASSERT_FALSE(cover.points.empty());
    const double size = shape.boundingRadius();
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector3d n = random.direction();
      double reach = -std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& p : cover.points) reach = std::max(reach, n.dot(p));
      // The shape's own reach: its distance from a far plane.
      Pose X_GP;
      X_GP.rotation =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -n).toRotationMatrix();
      X_GP.translation = n * (n.dot(shape.boundingCenter()) + 2 * size);
      const Interval gap = distance(shape, Pose{}, Shape::halfSpace(), X_GP, {}, scratch).distance;
      const double own = n.dot(X_GP.translation) - gap.lower;
      ++directions;
      EXPECT_LE(own, reach + cover.radius + 1e-9 * size + 1e-12 * shape.extent())
          << oracle::replay(shape);
      tight += own > reach - 0.1 * size;
    }
  }
  EXPECT_GT(directions, 4000);
  EXPECT_GT(tight, directions * 3 / 4);
}

}  // namespace
}  // namespace leeway::collision
