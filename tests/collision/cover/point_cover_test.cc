#include "collision/cover/point_cover.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using oracle::Random;

// Support along random directions: the shape's never exceeds that of points and radius; detects
// points a tenth too near.
TEST(PointCover, HoldsTheShape) {
  Random random(41);
  Scratch scratch;
  int directions = 0, tight = 0, fine = 0;
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
      double reach = -std::numeric_limits<double>::infinity(), fine_reach = reach;
      for (const Eigen::Vector3d& p : cover.points) reach = std::max(reach, n.dot(p));
      for (const Eigen::Vector3d& p : cover.fine) fine_reach = std::max(fine_reach, n.dot(p));
      // The shape's support: its distance from a far plane.
      Pose X_GP;
      X_GP.rotation =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -n).toRotationMatrix();
      X_GP.translation = n * (n.dot(shape.boundingCenter()) + 2 * size);
      const Interval gap = distance(shape, Pose{}, Shape::halfSpace(), X_GP, {}, scratch).distance;
      const double own = n.dot(X_GP.translation) - gap.lower;
      ++directions;
      EXPECT_LE(own, reach + cover.radius + 1e-9 * size + 1e-12 * shape.extent() + 1e-50)
          << oracle::replay(shape);
      tight += own > reach - 0.1 * size;
      if (cover.fine.empty()) continue;
      ++fine;
      EXPECT_LE(own, fine_reach + cover.fine_radius + 1e-9 * size + 1e-12 * shape.extent() + 1e-50)
          << oracle::replay(shape);
    }
    if (!cover.own) continue;
    for (const auto* points : {&cover.points, &cover.fine})
      for (const Eigen::Vector3d& p : *points) {
        Pose X_GP;
        X_GP.translation = p;
        EXPECT_LE(distance(Shape::sphere(0), X_GP, shape, Pose{}, {}, scratch).distance.lower,
                  cover.fine_radius + 1e-9 * size)
            << oracle::replay(shape);
      }
  }
  EXPECT_GT(directions, 4000);
  EXPECT_GT(tight, directions * 3 / 4);
  EXPECT_GT(fine, 100);
}

}  // namespace
}  // namespace leeway::collision
