// Every interval is as narrow as the default tolerance and contains the truth, for shapes whose
// depth has no unique direction.

#include <gtest/gtest.h>

#include <cmath>

#include "leeway/collision/distance.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;
using oracle::Truth;

// The half-space is last, because only the others have a size.
constexpr ShapeType kTypes[] = {ShapeType::kSphere,     ShapeType::kCapsule,  ShapeType::kBox,
                                ShapeType::kCylinder,   ShapeType::kCone,     ShapeType::kEllipsoid,
                                ShapeType::kConvexHull, ShapeType::kHalfSpace};
constexpr int kBounded = 7;
constexpr ShapeType kStraight[] = {ShapeType::kCapsule, ShapeType::kCylinder, ShapeType::kCone};

double sizes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return oracle::sizeOf(a) + oracle::sizeOf(b) + (X_WB.translation - X_WA.translation).norm();
}

std::string replay(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return oracle::replay(a) + " at " + oracle::replay(X_WA) + " with " + oracle::replay(b) + " at " +
         oracle::replay(X_WB);
}

TEST(NarrowWidth, DefaultToleranceIsMetAndTheTruthWithin) {
  Random random(61);
  Scratch scratch;
  int cases = 0, open = 0, overlapping = 0, held = 0;
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      if (type_a == ShapeType::kHalfSpace && type_b == ShapeType::kHalfSpace) continue;
      for (int i = 0; i < 40; ++i) {
        const Shape a = oracle::randomShape(random, type_a, Flavour::kPlain);
        const Shape b =
            oracle::randomShape(random, type_b, i % 8 == 7 ? Flavour::kHuge : Flavour::kPlain);
        const Pose X_WA{random.rotation(), 10 * random.direction()};
        Pose X_WB{random.rotation(), X_WA.translation};
        X_WB.translation +=
            (oracle::sizeOf(a) + oracle::sizeOf(b)) * random.uniform(0, 1.2) * random.direction();
        const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
        ++cases;
        open += r.status != DistanceStatus::kConverged;
        overlapping += r.distance.upper < 0;
        if (i % 8 != 7 && i != 0) continue;
        ++held;
        const Truth truth = oracle::signedSeparation(a, X_WA, b, X_WB);
        EXPECT_LE(r.distance.lower, truth.upper) << replay(a, X_WA, b, X_WB);
        EXPECT_GE(r.distance.upper, truth.lower) << replay(a, X_WA, b, X_WB);
      }
    }
  }
  EXPECT_EQ(open, 0);
  EXPECT_GT(4 * overlapping, cases);
  EXPECT_GT(held, 300);
}

/// Bodies that barely overlap, curved parts, and straight bodies about nearly one axis.
TEST(NarrowWidth, AsNarrowForTwinsForNearContactAndAboutOneAxis) {
  Random random(66);
  Scratch scratch;
  DistanceRequest request;
  request.iteration_limit *= 36;  // a default query ends within a millisecond
  int open[3] = {0, 0, 0}, overlapping[3] = {0, 0, 0}, held = 0;
  constexpr int kCases = casesToAsk(500);
  for (int i = 0; i < 3 * kCases; ++i) {
    const int family = i % 3;
    const ShapeType type = family == 0   ? ShapeType::kEllipsoid
                           : family == 1 ? kTypes[random.below(kBounded)]
                                         : kStraight[random.below(3)];
    const ShapeType other =
        family == 1 ? kTypes[random.below(kBounded)] : kStraight[random.below(3)];
    const Shape a = oracle::randomShape(random, type, Flavour::kPlain);
    const Shape b =
        family == 0 || random.chance(0.2) ? a : oracle::randomShape(random, other, Flavour::kPlain);
    const Pose X_WA{random.rotation(), random.direction()};
    Pose X_WB = X_WA;
    const double size = oracle::sizeOf(a) + oracle::sizeOf(b);
    if (family == 0) {
      X_WB.translation += random.logUniform(1e-9, 0.2) * size * random.direction();
    } else if (family == 1) {
      X_WB.rotation = random.rotation();
      X_WB.translation += size * random.direction();
      const DistanceResult r = distance(a, X_WA, b, X_WB, request, scratch);
      X_WB.translation -= (r.distance.upper + random.logUniform(1e-16, 1e-12) * size) * r.normal;
    } else {
      const double angle = random.uniform(0, 6);
      Eigen::Matrix3d turn;
      turn << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
      X_WB.rotation = X_WA.rotation * turn;
      X_WB.translation += 0.1 * size * random.uniform(-1, 1) * X_WA.rotation.col(2) +
                          random.logUniform(1e-12, 1e-3) * size * X_WA.rotation.col(0);
    }
    const DistanceResult r = distance(a, X_WA, b, X_WB, request, scratch);
    open[family] += r.status != DistanceStatus::kConverged;
    overlapping[family] += r.distance.lower < 0;
    if (i % 30 > 2) continue;
    ++held;
    const Truth truth = oracle::signedSeparation(a, X_WA, b, X_WB);
    EXPECT_LE(r.distance.lower, truth.upper) << replay(a, X_WA, b, X_WB);
    EXPECT_GE(r.distance.upper, truth.lower) << replay(a, X_WA, b, X_WB);
  }
  for (int family = 0; family < 3; ++family) {
    EXPECT_EQ(open[family], 0) << family;
    EXPECT_GT(2 * overlapping[family], kCases) << family;
  }
  EXPECT_EQ(held, 3 * casesToAsk(50));
}

// R (1 + E) with a symmetric E of this size, still accepted as a rotation.
Eigen::Matrix3d departing(Random& random, double size) {
  Eigen::Matrix3d E;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) E(i, j) = E(j, i) = size * random.uniform(-1, 1);
  }
  const Eigen::Matrix3d R = random.rotation();
  return R + R * E;
}

/// Regression: departures from rotations were counted for only one of the two frames. Intervals
/// missed the truth by up to 9400 units of rounding, and a pair in contact was free.
TEST(NarrowWidth, TheTruthIsWithinWhereMatricesDepartFromRotations) {
  Random random(67);
  Scratch scratch;
  int held = 0, narrow = 0;
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      if (type_a == ShapeType::kHalfSpace && type_b == ShapeType::kHalfSpace) continue;
      for (int i = 0; i < 6; ++i) {
        const Shape a = oracle::randomShape(random, type_a, Flavour::kPlain);
        const Shape b = oracle::randomShape(random, type_b, Flavour::kPlain);
        const Pose X_WA{departing(random, random.logUniform(1e-15, 1e-11)),
                        random.uniform(0, 3) * random.direction()};
        Pose X_WB{departing(random, random.logUniform(1e-15, 1e-11)), X_WA.translation};
        X_WB.translation +=
            (oracle::sizeOf(a) + oracle::sizeOf(b)) * random.uniform(0, 1) * random.direction();
        const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
        narrow += r.distance.width() < 1e-9 * sizes(a, X_WA, b, X_WB);
        ++held;
        const Truth truth = oracle::signedSeparation(a, X_WA, b, X_WB);
        EXPECT_LE(r.distance.lower, truth.upper) << replay(a, X_WA, b, X_WB);
        EXPECT_GE(r.distance.upper, truth.lower) << replay(a, X_WA, b, X_WB);
      }
    }
  }
  EXPECT_EQ(held, 378);
  EXPECT_EQ(narrow, held);
}

TEST(NarrowWidth, ABoxThatIsNotQuiteTurnedIsNotFreeOfALargeBall) {
  Scratch scratch;
  Pose X_WA, X_WB;
  X_WA.rotation *= 1 + 1e-12;
  X_WB.translation.z() = 1e5 + 0.5 - 1e-8;
  const DistanceResult large =
      distance(Shape::box({0.5, 0.5, 0.5}), X_WA, Shape::sphere(1e5), X_WB, {}, scratch);
  EXPECT_LE(large.distance.lower, -9.998e-9);
  EXPECT_GE(large.distance.upper, -9.998e-9);
  X_WB.translation.z() = 1.01 - 5e-13;
  DistanceRequest request;
  request.tolerance = 1e-14;
  const DistanceResult small =
      distance(Shape::box({0.01, 0.01, 0.01}), X_WA, Shape::sphere(1), X_WB, request, scratch);
  EXPECT_LE(small.distance.lower, -5.10e-13);
  EXPECT_GE(small.distance.upper, -5.10e-13);
  // A plane, sheared, and a box ten metres along it.
  X_WA.rotation.setIdentity();
  X_WA.rotation(0, 2) = X_WA.rotation(2, 0) = 1e-12;
  X_WB.translation = {10, 0, 1};
  for (const bool first : {true, false}) {
    const Shape plane = Shape::halfSpace(), box = Shape::box({0.5, 0.5, 0.5});
    const DistanceResult r = first ? distance(plane, X_WA, box, X_WB, request, scratch)
                                   : distance(box, X_WB, plane, X_WA, request, scratch);
    EXPECT_LE(r.distance.lower, 0.4999999999895);
    EXPECT_GE(r.distance.upper, 0.4999999999894);
  }
  // Two overlapping blocks, the smaller one's matrix slightly too long.
  const auto block = [](double x, double y, double z) {
    std::vector<Vector3d> corners;
    for (int k = 0; k < 8; ++k)
      corners.push_back({(k & 1) != 0 ? x : -x, (k & 2) != 0 ? y : -y, (k & 4) != 0 ? z : -z});
    return Shape::convexHull(corners);
  };
  for (const double e : {1e-12, 3e-13}) {
    Pose X;
    X.rotation(0, 0) = 1 + e;
    request.tolerance = 2e-14;
    const DistanceResult r =
        distance(block(1, 1 + e / 2, 3), {}, block(1e-3, 1e-3, 1e-3), X, request, scratch);
    EXPECT_LE(r.distance.lower, -1.001);
    EXPECT_GE(r.distance.upper, -1.001 - 2e-15);
  }
}

/// The default tolerance is 1e-12 of the sizes here.
TEST(NarrowWidth, BodiesOfAHundredKilometresAgainstOneOfAMetreConverge) {
  Random random(62);
  Scratch scratch;
  for (int i = 0; i < 100; ++i) {
    std::vector<Vector3d> large, small;
    for (int k = 0; k < 12; ++k) {
      large.push_back(1e5 * random.direction());
      small.push_back(random.direction());
    }
    const Shape a = Shape::convexHull(large), b = Shape::convexHull(small);
    const Pose X_WA{random.rotation(), random.direction()};
    Pose X_WB{random.rotation(), 2e5 * random.direction()};
    const DistanceResult far = distance(a, X_WA, b, X_WB, {}, scratch);
    X_WB.translation += (random.uniform(-1, 2) - far.distance.upper) * far.normal;
    const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << replay(a, X_WA, b, X_WB);
    if (i % 10 != 0) continue;
    const Truth truth = oracle::signedSeparation(a, X_WA, b, X_WB);
    EXPECT_LE(r.distance.lower, truth.upper) << replay(a, X_WA, b, X_WB);
    EXPECT_GE(r.distance.upper, truth.lower) << replay(a, X_WA, b, X_WB);
  }
}

/// The facet that proves the depth need not be the one that the plane's normal passes through.
/// Regression: witnesses were up to 0.4 m off.
TEST(NarrowWidth, WitnessesOfOverlappingPrismsAreAsDeepAsTheUpperEnd) {
  Random random(64);
  Scratch scratch;
  int overlapping = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<Vector3d> prism;
    const int corners = 3 + random.below(9);
    const double height = random.uniform(0.05, 0.5), radius = random.uniform(0.2, 0.8);
    for (int k = 0; k < corners; ++k) {
      const double angle = 6.283185307179586 * k / corners;
      for (const double z : {-height, height}) {
        prism.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
      }
    }
    const Shape a = Shape::convexHull(prism);
    const Shape b = random.chance(0.5) ? a : Shape::box({0.3, random.uniform(0.1, 1), 0.4});
    const Pose X_WA{random.rotation(), random.direction()};
    const double angle = random.uniform(0, 6);
    Eigen::Matrix3d turn;
    turn << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
    const Pose X_WB{X_WA.rotation * turn,
                    X_WA.translation + X_WA.rotation * Vector3d(random.uniform(-0.1, 0.1),
                                                                random.uniform(-0.1, 0.1),
                                                                random.uniform(-0.4, 0.4))};
    const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
    if (!(r.distance.upper < 0)) continue;
    ++overlapping;
    EXPECT_NEAR((r.point_b - r.point_a).norm(), -r.distance.upper, 1e-8)
        << replay(a, X_WA, b, X_WB);
  }
  EXPECT_GT(overlapping, 150);
}

TEST(ParallelAxes, DepthIsThatOfAPointInAPolygon) {
  Random random(63);
  Scratch scratch;
  int overlapping = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape a = oracle::randomShape(random, kStraight[random.below(3)], Flavour::kPlain);
    const Shape b = oracle::randomShape(random, kStraight[random.below(3)], Flavour::kPlain);
    const Pose X_WA{random.rotation(), random.direction()};
    const double angle = random.uniform(0, 6);
    Eigen::Matrix3d turn;
    turn << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
    Eigen::Matrix3d over = Eigen::Matrix3d::Identity();
    if (random.chance(0.5)) over(1, 1) = over(2, 2) = -1;
    Pose X_WB{X_WA.rotation * turn * over, X_WA.translation};
    X_WB.translation += X_WA.rotation * Vector3d(0, 0, random.uniform(-0.4, 0.4));
    if (random.chance(0.5)) {
      X_WB.translation += random.logUniform(1e-15, 0.3) * X_WA.rotation.col(0);
    }
    const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
    EXPECT_EQ(r.status, DistanceStatus::kConverged) << replay(a, X_WA, b, X_WB);
    if (!(r.distance.upper < 0)) continue;
    ++overlapping;
    // Moved apart by the depth they touch; moved by less they overlap.
    Pose moved = X_WB;
    moved.translation += -r.distance.lower * r.normal;
    EXPECT_GT(distance(a, X_WA, b, moved, {}, scratch).distance.upper, -1e-9)
        << replay(a, X_WA, b, X_WB);
    // (Where the cores of two capsules touch, witness and normal may be any of a circle, and
    // differ.)
    if (a.type() != ShapeType::kCapsule || b.type() != ShapeType::kCapsule) {
      EXPECT_LT((r.point_b - r.point_a - r.distance.upper * r.normal).norm(), 1e-5)
          << replay(a, X_WA, b, X_WB);
    }
    if (i % 20 != 0) continue;
    const Truth truth = oracle::signedSeparation(a, X_WA, b, X_WB);
    EXPECT_LE(r.distance.lower, truth.upper) << replay(a, X_WA, b, X_WB);
    EXPECT_GE(r.distance.upper, truth.lower) << replay(a, X_WA, b, X_WB);
  }
  EXPECT_GT(overlapping, 200);
}

/// Regression: 3e-12 m from a cone's slant, the direction was that of the difference of two points,
/// and wrong by 1e-6.
TEST(PointAndCone, TheSlopeGivesTheDirectionNearContact) {
  Pose X_WA, X_WB;
  X_WA.rotation << -0.893552178092335, 0.36954274810551047, 0.25495619692227811, 0.4382481959101171,
      0.84124967845868381, 0.31660305948409412, -0.097483454021550786, 0.39463544673000234,
      -0.91365192517514004;
  X_WA.translation = {-0.24928288485346636, 0.71932323863371495, -0.64840737324666275};
  X_WB.translation = {0.011620012002404853, 0.090749852144935111, -0.45777736648545886};
  Scratch scratch;
  const Shape cone = Shape::cone(0.93986130395674727, 0.86376011149231213);
  const DistanceResult r = distance(cone, X_WA, Shape::sphere(0), X_WB, {}, scratch);
  ASSERT_GT(r.distance.lower, 0);
  // The plane across the normal proves the lower end: no point of the cone is beyond it.
  const Vector3d n = X_WA.rotation.transpose() * r.normal;
  const double cone_most =
      std::max(cone.halfLength() * n.z(),
               cone.radius() * std::hypot(n.x(), n.y()) - cone.halfLength() * n.z());
  const double apart = r.normal.dot(X_WB.translation - X_WA.translation) - cone_most;
  EXPECT_NEAR(apart, r.distance.lower, 1e-13);
}

}  // namespace
}  // namespace leeway::collision
