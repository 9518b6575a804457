#include "collision/convex/round_depth/curved_facet.h"

#include <gtest/gtest.h>

#include <cmath>

#include "leeway/collision/distance.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;

constexpr ShapeType kRound[] = {ShapeType::kCylinder, ShapeType::kCone, ShapeType::kEllipsoid};
constexpr ShapeType kAny[] = {ShapeType::kSphere,    ShapeType::kCapsule,  ShapeType::kBox,
                              ShapeType::kCone,      ShapeType::kCylinder, ShapeType::kEllipsoid,
                              ShapeType::kConvexHull};

// A cover against the support function in many directions of the cone.
TEST(CurvedFacets, WhatIsCoveredIsFarEnoughOutInEveryDirection) {
  Random random(71);
  int covered = 0, refused = 0, gained = 0;
  for (int i = 0; i < 4000; ++i) {
    const Shape a = oracle::randomShape(random, kRound[random.below(3)], Flavour::kPlain);
    const Shape b = oracle::randomShape(random, kAny[random.below(7)], Flavour::kPlain);
    const ConvexView view_a = viewOf(a), view_b = viewOf(b);
    const Pose X_BA{random.rotation(), random.logUniform(1e-6, 0.3) * random.direction()};
    const bool turned_about = random.chance(0.5);
    const Pose X_AB = X_BA.inverse();
    Difference<false> difference = turned_about ? Difference<false>(view_b, view_a, X_AB, X_AB)
                                                : Difference<false>(view_a, view_b, X_BA, X_BA);
    const double size = view_a.extent + view_b.extent + X_BA.translation.norm();
    CurvedFacets curved(difference, kUnitRoundoff * size, 10000);
    ASSERT_TRUE(curved.any());
    const Vector3d middle = random.direction();
    const double width = random.logUniform(1e-3, 1);
    SupportPoint w[3];
    double nearest = 1e300;
    for (SupportPoint& s : w) {
      difference.support(-Vector3d(middle + width * random.direction()).normalized(), s);
      nearest = std::min(nearest, s.w.norm());
    }
    const Vector3d normal = cross(w[1].w - w[0].w, w[2].w - w[0].w).normalized();
    const double flat = std::abs(normal.dot(w[0].w));
    // From the triangle's own depth to more than possible.
    const double depth = flat + random.uniform(-0.1, 1.1) * (nearest - flat);
    if (!(depth > 0)) continue;
    if (!curved.covers(w[0], w[1], w[2], depth)) {
      ++refused;
      continue;
    }
    ++covered;
    gained += depth > flat * (1 + 1e-6);
    for (int k = 0; k < 100; ++k) {
      double mu[3] = {random.unit(), random.unit(), random.unit()};
      if (k < 20) mu[k % 3] = 0;
      const Vector3d x = Vector3d(mu[0] * w[0].w + mu[1] * w[1].w + mu[2] * w[2].w).normalized();
      SupportPoint s;
      difference.support(-x, s);
      EXPECT_GE(x.dot(s.w), depth - 1e-14 * size) << "case " << i;
    }
  }
  EXPECT_GT(covered, 300);
  EXPECT_GT(gained, 100);
  EXPECT_GT(refused, 300);
}

// Bodies about each other's middle: the surface of their difference is about equally far out all
// around the origin. Regression: ended at the limit with relative widths of 1e-6 to 1e-4.
TEST(RoundDepth, ConvergesWhereTheDifferenceIsNearlyABall) {
  Random random(72);
  Scratch scratch;
  int overlapping = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d axes(random.uniform(0.3, 0.4), random.uniform(0.3, 0.31),
                        random.uniform(0.3, 0.8));
    const Shape a = Shape::ellipsoid(axes);
    const Shape b = random.chance(0.3)   ? Shape::sphere(random.uniform(0.1, 0.9))
                    : random.chance(0.5) ? Shape::ellipsoid(Vector3d(axes.z(), axes.x(), axes.y()))
                                         : a;
    const Pose X_WA{random.rotation(), random.direction()};
    const Pose X_WB{random.chance(0.5) ? X_WA.rotation : random.rotation(),
                    X_WA.translation + random.logUniform(1e-9, 0.1) * random.direction()};
    const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
    const std::string replay = oracle::replay(a) + " at " + oracle::replay(X_WA) + " with " +
                               oracle::replay(b) + " at " + oracle::replay(X_WB);
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << replay;
    overlapping += r.distance.upper < 0;
    // No direction separates them by less.
    for (int k = 0; k < 200; ++k) {
      const Vector3d n =
          (k < 100 ? Vector3d(random.direction()) : Vector3d(r.normal + 0.1 * random.direction()))
              .normalized();
      const auto most = [&](const Shape& s, const Pose& X) {
        const Vector3d local = X.rotation.transpose() * n;
        return s.type() == ShapeType::kSphere ? s.radius()
                                              : s.halfExtents().cwiseProduct(local).norm();
      };
      const double apart =
          n.dot(X_WB.translation - X_WA.translation) - most(a, X_WA) - most(b, X_WB);
      EXPECT_LE(apart, r.distance.upper + 1e-15) << replay;
    }
    // The witnesses belong to the bodies and are one depth apart.
    const auto outside = [](const Shape& s, const Pose& X, const Vector3d& p) {
      const Vector3d local = X.rotation.transpose() * (p - X.translation);
      return s.type() == ShapeType::kSphere ? local.norm() / s.radius() - 1
                                            : local.cwiseQuotient(s.halfExtents()).norm() - 1;
    };
    EXPECT_LT(outside(a, X_WA, r.point_a), 1e-3) << replay;
    EXPECT_LT(outside(b, X_WB, r.point_b), 1e-3) << replay;
    EXPECT_NEAR((r.point_b - r.point_a).norm(), -r.distance.upper, 1e-3) << replay;
  }
  EXPECT_EQ(overlapping, 300);
}

TEST(RoundDepth, IsTheSameAtAnyScale) {
  Random random(74);
  Scratch scratch;
  int overlapping = 0;
  for (int i = 0; i < 150; ++i) {
    const Vector3d axes_a(random.uniform(0.3, 1), random.uniform(0.3, 1), random.uniform(0.3, 1)),
        axes_b(random.uniform(0.3, 1), random.uniform(0.3, 1), random.uniform(0.3, 1));
    const Pose X_WA{random.rotation(), Vector3d::Zero()};
    const Pose X_WB{random.rotation(), random.logUniform(1e-6, 0.3) * random.direction()};
    DistanceRequest request;
    request.tolerance = 1e-9;
    const DistanceResult one =
        distance(Shape::ellipsoid(axes_a), X_WA, Shape::ellipsoid(axes_b), X_WB, request, scratch);
    overlapping += one.distance.upper < 0;
    for (const int exponent : {-20, 20}) {
      const double scale = std::ldexp(1.0, exponent);
      request.tolerance = 1e-9 * scale;
      Pose X_WC = X_WB;
      X_WC.translation *= scale;
      const DistanceResult r = distance(Shape::ellipsoid(scale * axes_a), X_WA,
                                        Shape::ellipsoid(scale * axes_b), X_WC, request, scratch);
      EXPECT_LE(r.distance.lower, scale * one.distance.upper) << i << " at 2^" << exponent;
      EXPECT_GE(r.distance.upper, scale * one.distance.lower) << i << " at 2^" << exponent;
    }
  }
  EXPECT_EQ(overlapping, 150);
}

/// Regression: left with widths of 2.4e-5 and 8.2e-5.
TEST(RoundDepth, AnEllipsoidInASphereAndInItself) {
  const Shape ellipsoid =
      Shape::ellipsoid({0.37465775030863552, 0.7106268018102665, 0.37810982192072623});
  Scratch scratch;
  Pose X_WA, X_WB;
  X_WA.rotation << -0.43932613294322764, -0.85134303226625341, 0.28671866058010698,
      0.71667659353751367, -0.13971984752269084, 0.68326643740469306, -0.54163383312770885,
      0.50566135468308948, 0.67152020460403727;
  X_WA.translation = {0.23641246799010435, 0.88706549188624151, -0.39651476408410347};
  X_WB.translation = {0.23641386584120941, 0.88706919585642607, -0.39650865192543727};
  const DistanceResult r =
      distance(ellipsoid, X_WA, Shape::sphere(0.89164479956916121), X_WB, {}, scratch);
  EXPECT_EQ(r.status, DistanceStatus::kConverged);
  EXPECT_NEAR(r.distance.upper, -1.2662989, 1e-5);
  const DistanceResult twin = distance(ellipsoid, X_WA, ellipsoid, X_WA, {}, scratch);
  EXPECT_EQ(twin.status, DistanceStatus::kConverged);
  EXPECT_NEAR(twin.distance.lower, -2 * 0.37465775030863552, 1e-9);
  EXPECT_NEAR(twin.distance.upper, -2 * 0.37465775030863552, 1e-9);
}

}  // namespace
}  // namespace leeway::collision
