// The closed form of overlapping boxes; its slow twin is the expanding polytope on the hulls of
// their corners.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "leeway/collision/distance.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

Shape cornersOf(const Vector3d& half) {
  std::array<Vector3d, 8> corners;
  for (unsigned i = 0; i < 8; ++i) {
    corners[i] = {i & 1u ? half.x() : -half.x(), i & 2u ? half.y() : -half.y(),
                  i & 4u ? half.z() : -half.z()};
  }
  return Shape::convexHull(corners);
}

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  Eigen::Matrix3d K;
  K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
}

double outside(const Vector3d& half, const Pose& X_WS, const Vector3d& p_W) {
  const Vector3d p = X_WS.rotation.transpose() * (p_W - X_WS.translation);
  return (p.cwiseAbs() - half).maxCoeff();
}

TEST(BoxOverlap, AgreesWithThePolytopeOfTheCorners) {
  Random random(41);
  Scratch scratch;
  int overlapping = 0, parallel = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    Vector3d half_a, half_b;
    for (Vector3d* half : {&half_a, &half_b}) {
      for (int k = 0; k < 3; ++k) (*half)[k] = random.uniform(0.1, 1);
      if (random.chance(0.1)) (*half)[random.below(3)] *= random.logUniform(1e-9, 1);
      if (random.chance(0.1)) (*half)[random.below(3)] = 0;
    }
    const Pose X_WA{random.rotation(), random.direction()};
    Pose X_WB{random.rotation(), X_WA.translation + random.uniform(0, 1.5) * random.direction()};
    // Edges from exactly to nearly parallel.
    if (random.chance(0.6)) {
      ++parallel;
      const Vector3d axis = random.chance(0.5) ? Vector3d(Vector3d::Unit(random.below(3)))
                                               : Vector3d(random.direction());
      const double tilt = random.chance(0.3) ? 0 : random.logUniform(1e-17, 1e-3);
      const double quarters = 0.5 * 3.14159265358979312 * random.below(4);
      X_WB.rotation =
          X_WA.rotation * turned(Vector3d::Unit(random.below(3)), quarters) * turned(axis, tilt);
    }
    const Shape a = Shape::box(half_a), b = Shape::box(half_b);
    const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
    const DistanceResult s =
        distance(cornersOf(half_a), X_WA, cornersOf(half_b), X_WB, {}, scratch);
    const std::string replay = oracle::replay(a) + " at " + oracle::replay(X_WA) + " with " +
                               oracle::replay(b) + " at " + oracle::replay(X_WB);
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << replay;
    EXPECT_LE(r.distance.lower, s.distance.upper) << replay;
    EXPECT_GE(r.distance.upper, s.distance.lower) << replay;
    if (!(r.distance.upper < 0)) continue;
    ++overlapping;
    // The witnesses belong to the bodies and are one depth apart along the normal.
    EXPECT_LT(outside(half_a, X_WA, r.point_a), 1e-12) << replay;
    EXPECT_LT(outside(half_b, X_WB, r.point_b), 1e-12) << replay;
    EXPECT_LT((r.point_b - r.point_a - r.distance.upper * r.normal).norm(), 1e-12) << replay;
    // Moving B by the depth separates the boxes.
    Pose moved = X_WB;
    moved.translation += (1e-12 - r.distance.lower) * r.normal;
    EXPECT_GT(distance(a, X_WA, b, moved, {}, scratch).distance.upper, 0) << replay;
    EXPECT_GT(distance(a, X_WA, b, moved, {}, scratch).distance.lower, -1e-12) << replay;
  }
  EXPECT_GT(overlapping, casesToAsk(1000));
  EXPECT_GT(parallel, casesToAsk(1000));
}

TEST(BoxOverlap, FacesThatLieInOnePlaneShareTheirMiddle) {
  Scratch scratch;
  const Shape a = Shape::box({1, 1, 1}), b = Shape::box({0.5, 2, 0.5});
  // B's end reaches 0.25 into A's face x = 1, from y = 0.5 on.
  const Pose X_WB{Eigen::Matrix3d::Identity(), {1.25, 2.5, 0}};
  const DistanceResult r = distance(a, {}, b, X_WB, {}, scratch);
  EXPECT_NEAR(r.distance.upper, -0.25, 1e-13);
  EXPECT_LT((r.normal - Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_LT((r.point_a - Vector3d(1, 0.75, 0)).norm(), 1e-14);
  EXPECT_LT((r.point_b - Vector3d(0.75, 0.75, 0)).norm(), 1e-14);
}

}  // namespace
}  // namespace leeway::collision
