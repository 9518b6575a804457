#include "collision/convex/round_depth/tilted_axes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "leeway/collision/distance.h"
#include "tests/collision/convex/pair_cases.h"
#include "tests/sanitized.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;
using testing::Pair;

constexpr ShapeType kStraight[] = {ShapeType::kCapsule, ShapeType::kCylinder, ShapeType::kCone};

// How far a body reaches along n, from its definition.
double most(const Shape& s, const Pose& X_WS, const Vector3d& n) {
  const Vector3d d = X_WS.rotation.transpose() * n;
  const double across = std::hypot(d.x(), d.y()), h = s.halfLength(), r = s.radius();
  switch (s.type()) {
    case ShapeType::kCapsule:
      return h * std::abs(d.z()) + r * d.norm();
    case ShapeType::kCylinder:
      return h * std::abs(d.z()) + r * across;
    default:
      return std::max(h * d.z(), r * across - h * d.z());
  }
}

double apartAlong(const Pair& pair, const Vector3d& n) {
  return n.dot(pair.X_WB.translation - pair.X_WA.translation) - most(pair.a, pair.X_WA, n) -
         most(pair.b, pair.X_WB, -n);
}

Eigen::Matrix3d turnAbout(const Vector3d& axis, double angle) {
  Eigen::Matrix3d K;
  K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
}

Pair nearlyCoaxial(Random& random) {
  Pair pair{oracle::randomShape(random, kStraight[random.below(3)], Flavour::kPlain),
            oracle::randomShape(random, kStraight[random.below(3)], Flavour::kPlain),
            {random.rotation(), random.direction()},
            {}};
  const Eigen::Matrix3d& R_WA = pair.X_WA.rotation;
  Eigen::Matrix3d over = Eigen::Matrix3d::Identity();
  if (random.chance(0.5)) over(1, 1) = over(2, 2) = -1;
  const double tilt = random.chance(0.1) ? 0.0 : random.logUniform(1e-12, 0.1);
  pair.X_WB.rotation = R_WA * turnAbout(Vector3d::UnitZ(), random.uniform(0, 6)) *
                       turnAbout(Vector3d::UnitX(), tilt) *
                       turnAbout(Vector3d::UnitZ(), random.uniform(0, 6)) * over;
  pair.X_WB.translation = pair.X_WA.translation + R_WA * Vector3d(0, 0, random.uniform(-0.3, 0.3));
  if (random.chance(0.7)) {
    pair.X_WB.translation += random.logUniform(1e-14, 0.1) * random.direction();
  }
  return pair;
}

// No plane of many separates by less than the depth, and all of them are asked where the nearest
// ones are: at the same angle with either axis as the one found. These ended at the limit with
// widths of up to 4e-4 m.
TEST(TiltedAxes, NoPlaneSeparatesByLess) {
  Random random(81);
  Scratch scratch;
  int overlapping = 0, open = 0;
  for (int i = 0; i < casesToAsk(3000); ++i) {
    const Pair pair = nearlyCoaxial(random);
    const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch);
    const double tilt = pair.X_WA.rotation.col(2).cross(pair.X_WB.rotation.col(2)).norm();
    open += tilt > 0.02 && r.status != DistanceStatus::kConverged;
    if (tilt <= 0.02) {
      EXPECT_EQ(r.status, DistanceStatus::kConverged) << pair.replay();
    }
    if (!(r.distance.upper < 0)) continue;
    ++overlapping;
    const double rounding = 1e-15 * pair.size();
    EXPECT_NEAR(apartAlong(pair, r.normal), r.distance.lower, 1e-9 + rounding) << pair.replay();
    const Vector3d axes[2] = {pair.X_WA.rotation.col(2), pair.X_WB.rotation.col(2)};
    for (int k = 0; k < 200; ++k) {
      Vector3d n = turnAbout(axes[k % 2], random.uniform(0, 6.3)) * r.normal;
      if (k >= 50) n += random.logUniform(1e-10, k < 150 ? 1e-2 : 1) * random.direction();
      if (k >= 190) n = (k % 4 < 2 ? 1 : -1) * axes[k % 2];
      n.normalize();
      EXPECT_LE(apartAlong(pair, n), r.distance.upper + rounding) << pair.replay();
    }
    // The points are of the two bodies, and as far apart as they should be.
    EXPECT_LT(testing::outside(pair.a, pair.X_WA, r.point_a, scratch), 1e-9) << pair.replay();
    EXPECT_LT(testing::outside(pair.b, pair.X_WB, r.point_b, scratch), 1e-9) << pair.replay();
    EXPECT_NEAR((r.point_a - r.point_b).norm(), -r.distance.upper, 1e-8) << pair.replay();
  }
  EXPECT_GT(2 * overlapping, casesToAsk(3000));
  EXPECT_LT(200 * open, casesToAsk(3000));
}

// Verdicts are those of the depth, where it is far enough from the threshold.
TEST(TiltedAxes, ThresholdsAreDecided) {
  Random random(83);
  Scratch scratch;
  for (int i = 0; i < casesToAsk(1000); ++i) {
    const Pair pair = nearlyCoaxial(random);
    const Interval full = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch).distance;
    DistanceRequest request = testing::nanometre();
    request.depth = false;
    const DistanceResult shallow = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch);
    EXPECT_EQ(shallow.distance.upper <= 0, full.upper <= 0) << pair.replay();
    EXPECT_GE(shallow.distance.upper, full.lower) << pair.replay();
    EXPECT_LE(shallow.distance.lower, full.upper) << pair.replay();
    request.depth = true;
    request.threshold = (i % 3 == 0 ? 0.0 : full.lower) + (i % 2 == 0 ? -1 : 1) * 1e-6;
    const DistanceResult verdict = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, request, scratch);
    if (full.upper <= request.threshold) {
      EXPECT_LE(verdict.distance.upper, request.threshold) << pair.replay();
    } else if (full.lower > request.threshold) {
      EXPECT_GT(verdict.distance.lower, request.threshold) << pair.replay();
    }
  }
}

TEST(TiltedAxes, HoldTheTruth) {
  Random random(82);
  Scratch scratch;
  int overlapping = 0;
  for (int i = 0; i < casesToAsk(200); ++i) {
    const Pair pair = nearlyCoaxial(random);
    const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch);
    overlapping += r.distance.upper < 0;
    const oracle::Truth truth = oracle::signedSeparation(pair.a, pair.X_WA, pair.b, pair.X_WB);
    EXPECT_LE(r.distance.lower, truth.upper) << pair.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << pair.replay();
  }
  EXPECT_GT(2 * overlapping, casesToAsk(200));
}

// By itself: it says nothing where a way out along the axes is as short, or the axes' angle is too
// large, and is as narrow as asked where it speaks.
TEST(TiltedAxes, SpeakOfSidesOnly) {
  const Shape a = Shape::cylinder(0.3, 0.5), b = Shape::cone(0.25, 0.6);
  const ConvexView view_a = viewOf(a), view_b = viewOf(b);
  const auto offered = [&](const Pose& X_BA, double& width) {
    DistanceRequest request = testing::nanometre();
    CoreQuery query;
    query.request = request;
    query.roundoff = kUnitRoundoff * (view_a.extent + view_b.extent + X_BA.translation.norm());
    Progress progress(query);
    Difference<false> difference(view_a, view_b, X_BA, X_BA);
    const bool answer = offerTiltedAxes(view_a, X_BA, view_b, difference, progress);
    width = progress.upper() - progress.lower();
    return answer;
  };
  double width = 0;
  for (const double tilt : {0.0, 1e-12, 1e-6, 1e-3}) {
    const Eigen::Matrix3d R = turnAbout(Vector3d::UnitX(), tilt);
    EXPECT_TRUE(offered({R, {1e-7, 0, 0.1}}, width)) << tilt;
    EXPECT_LE(width, 1e-9) << tilt;
    EXPECT_FALSE(offered({R, {1e-7, 0, 1.0}}, width)) << tilt;  // nearly out along the axes
    EXPECT_FALSE(offered({R, {0.9, 0, 0.1}}, width)) << tilt;   // beside one another
  }
  EXPECT_FALSE(offered({turnAbout(Vector3d::UnitX(), 0.1), {1e-7, 0, 0.1}}, width));
}

}  // namespace
}  // namespace leeway::collision
