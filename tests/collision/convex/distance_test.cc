#include "leeway/collision/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

// Known answers, and properties that every answer has. (oracle_test.cc compares all pairs with
// quadruple precision.)

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

Pose at(double x, double y, double z) { return {Eigen::Matrix3d::Identity(), Vector3d(x, y, z)}; }

Eigen::Matrix3d quarterTurnAboutY() {
  Eigen::Matrix3d r;
  r << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  return r;
}

Shape hullOf(const std::vector<Vector3d>& points) { return Shape::convexHull(points); }

std::vector<Vector3d> corners(const Vector3d& h) {
  std::vector<Vector3d> points;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) points.emplace_back(x * h.x(), y * h.y(), z * h.z());
  return points;
}

struct Known {
  const char* name;
  Shape a;
  Pose X_WA;
  Shape b;
  Pose X_WB;
  double distance;
};

std::vector<Known> knownAnswers() {
  const Pose lying{quarterTurnAboutY(), Vector3d::Zero()};  // z goes to x
  const Shape cube = Shape::box({1, 1, 1});
  const Shape cube_hull = hullOf(corners({1, 1, 1}));
  return {
      {"spheres apart", Shape::sphere(1), at(0, 0, 0), Shape::sphere(2), at(0, 3, 4), 2},
      {"spheres overlapping", Shape::sphere(1), at(0, 0, 0), Shape::sphere(2), at(0, 0, 1), -2},
      {"spheres with one centre", Shape::sphere(1), at(5, 0, 0), Shape::sphere(2), at(5, 0, 0), -3},
      {"points", Shape::sphere(0), at(0, 0, 0), Shape::sphere(0), at(3, 0, 4), 5},
      {"one point", Shape::sphere(0), at(1, 2, 3), Shape::sphere(0), at(1, 2, 3), 0},
      {"capsule on its side", Shape::capsule(0.5, 2), lying, Shape::sphere(0.25), at(1, 0, 2),
       1.25},
      {"capsule's end", Shape::capsule(0.5, 2), lying, Shape::sphere(0.25), at(6, 0, 3), 4.25},
      {"crossing capsules", Shape::capsule(0.5, 2), lying, Shape::capsule(0.25, 2), at(0, 2, 0),
       1.25},
      {"crossing segments", Shape::capsule(0, 2), lying, Shape::capsule(0, 2), at(0, 0, 0), 0},
      {"crossing axes", Shape::capsule(0.5, 2), lying, Shape::capsule(0.25, 2), at(0, 0, 0), -0.75},
      {"parallel capsules", Shape::capsule(0.5, 2), at(0, 0, 0), Shape::capsule(0.5, 1),
       at(2, 0, 1), 1},
      {"cubes face to face", cube, at(0, 0, 0), cube, at(3, 0.5, 0), 1},
      {"cubes corner to corner", cube, at(0, 0, 0), cube, at(3, 3, 3), std::sqrt(3.0)},
      {"cubes overlapping", cube, at(0, 0, 0), cube, at(1.5, 0.25, 0), -0.5},
      {"cubes with one centre", cube, at(0, 0, 0), cube, at(0, 0, 0), -2},
      {"cubes touching", cube, at(0, 0, 0), cube, at(2, 0.5, -0.25), 0},
      {"hull cubes with one centre", cube_hull, at(0, 0, 0), cube_hull, at(0, 0, 0), -2},
      {"hull cube in a cube", cube_hull, at(0.25, 0, 0), cube, at(0, 0, 0), -1.75},
      {"sphere over a cube", Shape::sphere(0.5), at(0, 0.5, 2), cube, at(0, 0, 0), 0.5},
      {"sphere in a cube", Shape::sphere(0.5), at(0, 0.75, 0), cube, at(0, 0, 0), -0.75},
      {"capsule over a cube",
       Shape::capsule(0.5, 3),
       {quarterTurnAboutY(), {0, 0, 2}},
       cube,
       at(0, 0, 0),
       0.5},
      {"cylinders side by side", Shape::cylinder(1, 2), at(0, 0, 0), Shape::cylinder(0.5, 1),
       at(2, 0, 0), 0.5},
      {"cylinders on end", Shape::cylinder(1, 2), at(0, 0, 0), Shape::cylinder(0.5, 1),
       at(0.25, 0, 4), 1},
      {"cylinders rim to rim", Shape::cylinder(1, 1), at(0, 0, 0), Shape::cylinder(1, 1),
       at(5, 0, 6), 5},
      {"sphere beside a cylinder", Shape::sphere(0.5), at(3, 0, 0.5), Shape::cylinder(1, 1),
       at(0, 0, 0), 1.5},
      {"point on a cylinder's axis", Shape::sphere(0), at(0, 0, 0.25), Shape::cylinder(1, 1),
       at(0, 0, 0), -0.75},
      {"sphere over a cone's apex", Shape::sphere(0.5), at(0, 0, 3), Shape::cone(1, 1), at(0, 0, 0),
       1.5},
      {"sphere beside a flat cone", Shape::sphere(0.5), at(3, 0, 0), Shape::cone(1, 0), at(0, 0, 0),
       1.5},
      {"sphere over a cone that is a segment", Shape::sphere(0.5), at(0, 0, 3), Shape::cone(0, 1),
       at(0, 0, 0), 1.5},
      {"sphere under a cone", Shape::sphere(0.5), at(0.25, 0, -3), Shape::cone(1, 1), at(0, 0, 0),
       1.5},
      {"cones, apex to base", Shape::cone(1, 1), at(0, 0, 0), Shape::cone(1, 1), at(0.5, 0, 3), 1},
      {"ellipsoid over a cube", Shape::ellipsoid({2, 1, 0.5}), at(0.5, 0, 3), cube, at(0, 0, 0),
       1.5},
      {"ellipsoids along an axis", Shape::ellipsoid({2, 1, 1}), at(0, 0, 0),
       Shape::ellipsoid({3, 1, 2}), at(6, 0, 0), 1},
      {"ellipsoid as a sphere", Shape::ellipsoid({1, 1, 1}), at(0, 0, 0), Shape::sphere(1),
       at(0, 3, 4), 3},
      {"cube over a plane", cube, at(7, 8, 3), Shape::halfSpace(), at(0, 0, 1), 1},
      {"cube in a half-space", cube, at(0, 0, -3), Shape::halfSpace(), at(0, 0, 0), -4},
      {"ellipsoid on a plane", Shape::ellipsoid({3, 2, 1}), at(0, 0, 1), Shape::halfSpace(),
       at(0, 0, 0), 0},
      {"triangles in one plane", hullOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), at(0, 0, 0),
       hullOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), at(2, 0, 0), 1},
      {"triangles overlapping in one plane", hullOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), at(0, 0, 0),
       hullOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), at(0.25, 0.25, 0), 0},
      {"a triangle through a triangle", hullOf({{-1, -1, 0}, {1, -1, 0}, {0, 2, 0}}), at(0, 0, 0),
       hullOf({{0, 0, -2 / std::sqrt(10.0)}, {0, 0, 1}, {4, 0, 0}}), at(0, 0, 0),
       -2 / std::sqrt(10.0)},
      {"a segment through a square", hullOf({{0, 0, -1}, {0, 0, 3}}), at(0, 0, 0),
       Shape::box({2, 2, 0}), at(0, 0, 0), -1},
      {"hull of one point", hullOf({{1, 1, 1}}), at(0, 0, 0), cube, at(3, 1, 1), 1},
      {"hull of equal points", hullOf({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), at(0, 0, 0),
       hullOf({{0, 0, 0}, {0, 0, 0}}), at(1, 1, 1), 0},
      {"hull on one line", hullOf({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}), at(0, 0, 0), cube,
       at(1, 0, 3), 2},
  };
}

TEST(Distance, KnownAnswersBothWaysRound) {
  Scratch scratch;
  for (const Known& k : knownAnswers()) {
    for (const bool swapped : {false, true}) {
      const DistanceResult r = swapped ? distance(k.b, k.X_WB, k.a, k.X_WA, {}, scratch)
                                       : distance(k.a, k.X_WA, k.b, k.X_WB, {}, scratch);
      EXPECT_EQ(r.status, DistanceStatus::kConverged) << k.name << (swapped ? ", swapped" : "");
      // (The expected number is itself rounded.)
      EXPECT_LE(r.distance.lower, k.distance + 1e-15) << k.name << (swapped ? ", swapped" : "");
      EXPECT_GE(r.distance.upper, k.distance - 1e-15) << k.name << (swapped ? ", swapped" : "");
      EXPECT_LE(r.distance.width(), 1e-9) << k.name;
      EXPECT_NEAR(r.normal.norm(), 1, 1e-14) << k.name;
      // Along the normal, the witnesses are one signed separation apart.
      EXPECT_NEAR((r.point_b - r.point_a).dot(r.normal), k.distance, 2e-9) << k.name;
    }
  }
}

TEST(Distance, MovingAlongTheNormalSeparates) {
  Scratch scratch;
  int overlapping = 0;
  for (const Known& k : knownAnswers()) {
    const DistanceResult r = distance(k.a, k.X_WA, k.b, k.X_WB, {}, scratch);
    if (!(r.distance.upper < 0)) continue;
    ++overlapping;
    Pose moved = k.X_WB;
    moved.translation += (1e-6 - r.distance.lower) * r.normal;
    const DistanceResult after = distance(k.a, k.X_WA, k.b, moved, {}, scratch);
    EXPECT_GT(after.distance.lower, 0.9e-6) << k.name;
  }
  EXPECT_GE(overlapping, 8);
}

TEST(Distance, HalfSpaceWithHalfSpaceIsRefused) {
  Scratch scratch;
  const DistanceResult r =
      distance(Shape::halfSpace(), at(0, 0, 0), Shape::halfSpace(), at(0, 0, 5), {}, scratch);
  EXPECT_EQ(r.status, DistanceStatus::kInvalid);
  EXPECT_EQ(r.distance.lower, -kInfinity);
  EXPECT_EQ(r.distance.upper, kInfinity);
}

TEST(Distance, PosesThatAreNoneAreRefused) {
  Scratch scratch;
  const Shape box = Shape::box({1, 1, 1}), sphere = Shape::sphere(1);
  int refused = 0;
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int i = 0; i < 12; ++i) {
      Pose X = at(4, 0, 0);
      (i < 9 ? X.rotation(i % 3, i / 3) : X.translation[i - 9]) = bad;
      for (const Shape& other : {box, sphere}) {
        for (const bool first : {true, false}) {
          const DistanceResult r = first ? distance(box, X, other, at(0, 0, 0), {}, scratch)
                                         : distance(other, at(0, 0, 0), box, X, {}, scratch);
          EXPECT_EQ(r.status, DistanceStatus::kInvalid);
          EXPECT_EQ(r.distance.lower, -kInfinity);
          EXPECT_EQ(r.distance.upper, kInfinity);
          ++refused;
        }
      }
    }
  }
  EXPECT_EQ(refused, 3 * 12 * 4);
  Pose scaled = at(4, 0, 0);
  scaled.rotation *= 1.001;
  EXPECT_EQ(distance(box, scaled, box, at(0, 0, 0), {}, scratch).status, DistanceStatus::kInvalid);
  Pose mended = at(4, 0, 0);
  mended.rotation *= 1 + 1e-9;  // a departure that is counted, not rejected
  const DistanceResult r = distance(box, mended, box, at(0, 0, 0), {}, scratch);
  EXPECT_LE(r.distance.lower, 2 - 1e-9);
  EXPECT_GE(r.distance.upper, 2);
}

// Numbers whose squares are the smallest doubles. Truth by the oracle.
TEST(Distance, NumbersWhoseSquaresVanish) {
  Scratch scratch;
  Pose X_WA, X_WB;
  // Regression: the common perpendicular of these two was longer than 1, and the lower end was
  // 0.02758.
  X_WA.rotation << 0.81665118714799267, 0.17042211198766891, 0.55139563135323866,
      -0.055319088620273758, 0.97412279154383496, -0.21914512412798201, -0.5744742265445828,
      0.14846242198114909, 0.80494613005808946;
  X_WB.rotation << -0.40138976503756951, 0.5512015406140176, -0.73148009712713069,
      -0.86082836199431023, -0.49980814177907934, 0.09574106385133635, -0.31282708571488882,
      0.66810829784188019, 0.67510778375453118;
  X_WB.translation = {0.2250263143251364, 1.2862371956192964, 0.1960306129085059};
  const Interval thin =
      distance(Shape::capsule(0.47873772263622649, 0.24146918311135102), X_WA,
               Shape::capsule(0.81540785969530871, 8.0564659812763688e-161), X_WB, {}, scratch)
          .distance;
  EXPECT_LE(thin.lower, 0.026260024567584146);
  EXPECT_GE(thin.upper, 0.026260024567584143);
  // Matrices depart from rotations by 1e-7. Regression: this was not counted.
  X_WA.rotation << 0.096889880715726684, 0.73779114274847191, -0.66803935564964745,
      0.86307292937712388, -0.39656557261089231, -0.3127952448426688, -0.49569897073857472,
      -0.54625998965849487, -0.67519075386665262;
  X_WB.rotation << -0.16918375302751315, 0.31612156958055793, 0.93351169676396739,
      -0.91568502665297635, 0.29992471060393799, -0.26751855444132, -0.36455159677712956,
      -0.90006244130769064, 0.23872539050586258;
  X_WB.translation = {-1.3447714173951063e-170, 7.2568424102612709e-170, -3.6541324836274395e-171};
  const Shape a = Shape::capsule(0, 0), b = Shape::sphere(0);
  for (const Interval& tiny : {distance(a, X_WA, b, X_WB, {}, scratch).distance,
                               distance(b, X_WB, a, X_WA, {}, scratch).distance}) {
    EXPECT_LE(tiny.lower, 7.3894315596e-170);
    EXPECT_GE(tiny.upper, 7.3894315597e-170);
  }
}

bool isHalfSpace(const Shape& a, const Shape& b) {
  return a.type() == ShapeType::kHalfSpace && b.type() == ShapeType::kHalfSpace;
}

TEST(Distance, PlacesAnywhereGiveNoNan) {
  Scratch scratch;
  Random random(11);
  const double places[] = {0,    1e-320, 1e-300, 1e-200, 1e-160, 1e-100, 1e-50,  1e-9,
                           1e-3, 1,      1e3,    1e9,    1e12,   1e160,  1.7e308};
  int cases = 0, decided = 0, refused = 0;
  for (const double size : {0.0, kSmallestSize, 1.0, kLargestSize}) {
    for (const double far : places) {
      const Shape shapes[] = {Shape::sphere(size),
                              Shape::capsule(size, 0.5 * size),
                              Shape::box({size, 0.5 * size, 0}),
                              Shape::cylinder(size, size),
                              Shape::cone(size, 0.5 * size),
                              Shape::ellipsoid({size, 0.5 * size, 0.25 * size}),
                              Shape::halfSpace()};
      for (const Shape& a : shapes) {
        for (const Shape& b : shapes) {
          Pose X_WA{random.rotation(), far * random.direction()};
          Pose X_WB{random.rotation(), far * random.direction()};
          const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
          EXPECT_LE(r.distance.lower, r.distance.upper);  // false for NaN
          EXPECT_TRUE(r.point_a.allFinite() && r.point_b.allFinite() && r.normal.allFinite())
              << toString(a.type()) << " " << toString(b.type()) << " size " << size << " far "
              << far;
          ++cases;
          decided += r.distance.lower > 0 || r.distance.upper < 0;
          const bool is_answered = r.status != DistanceStatus::kInvalid;
          refused += !is_answered;
          if (far <= kLargestSize && !isHalfSpace(a, b)) {
            EXPECT_TRUE(is_answered) << far;
          }
        }
      }
    }
  }
  EXPECT_GT(decided, cases / 3);
  EXPECT_GT(refused, cases / 10);
}

// Points may be arbitrarily close: the width includes what their squares lose.
TEST(Distance, OfPointsThatAreAsNearAsNumbersAllow) {
  Scratch scratch;
  Random random(12);
  const std::vector<Vector3d> origin = {{0, 0, 0}};
  const Shape points[] = {Shape::sphere(0),         Shape::capsule(0, 0),
                          Shape::box({0, 0, 0}),    Shape::cylinder(0, 0),
                          Shape::cone(0, 0),        Shape::ellipsoid({0, 0, 0}),
                          Shape::convexHull(origin)};
  for (int i = 0; i < casesToAsk(20000); ++i) {
    const Shape &a = points[random.below(7)], &b = points[random.below(7)];
    const Pose X_WA{random.rotation(), Vector3d::Zero()};
    const Pose X_WB{random.rotation(), std::pow(10, random.uniform(-320, -3)) * random.direction()};
    const Vector3d& t = X_WB.translation;
    const double truth = std::hypot(t.x(), t.y(), t.z());
    DistanceRequest request;
    if (random.chance(0.5)) request.threshold = truth * random.uniform(0.5, 1.5);
    const Interval d = distance(a, X_WA, b, X_WB, request, scratch).distance;
    EXPECT_LE(d.lower, truth * (1 + 1e-15)) << toString(a.type()) << " " << toString(b.type());
    EXPECT_GE(d.upper, truth * (1 - 1e-15)) << toString(a.type()) << " " << toString(b.type());
    if (std::isnan(request.threshold)) {
      EXPECT_LE(d.width(), 1e-39 + 1e-12 * truth);
    }
  }
}

// A pair beyond kFarthest is invalid, for any world poses; within it, all pairs are answered.
TEST(Distance, FramesTooFarApartAreRefused) {
  Scratch scratch;
  const std::vector<Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Shape shapes[] = {
      Shape::sphere(1),      Shape::capsule(1, 1),       Shape::box({1, 1, 1}),
      Shape::cylinder(1, 1), Shape::cone(1, 1),          Shape::ellipsoid({1, 2, 3}),
      Shape::halfSpace(),    Shape::convexHull(corners), Shape::mesh(oracle::ellMesh(1))};
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      if (isHalfSpace(a, b)) continue;
      const auto status = [&](double x) {
        return distance(a, at(0, 0, 5), b, at(x, 0, 5), {}, scratch).status;
      };
      EXPECT_EQ(status(kFarthest * 1.001), DistanceStatus::kInvalid)
          << toString(a.type()) << " " << toString(b.type());
      EXPECT_NE(status(kFarthest * 0.999), DistanceStatus::kInvalid)
          << toString(a.type()) << " " << toString(b.type());
    }
  }
}

/// Random pairs without an oracle: two queries of the same pair must agree, and so must any
/// request.
struct RandomPairs {
  explicit RandomPairs(std::uint64_t seed) : random(seed) {}
  static constexpr ShapeType kTypes[8] = {
      ShapeType::kSphere, ShapeType::kCapsule,   ShapeType::kBox,       ShapeType::kCylinder,
      ShapeType::kCone,   ShapeType::kEllipsoid, ShapeType::kHalfSpace, ShapeType::kConvexHull};

  void next() {
    do {
      a = oracle::randomShape(random, kTypes[random.below(8)],
                              oracle::kFlavours[static_cast<std::size_t>(random.below(6))]);
      b = oracle::randomShape(random, kTypes[random.below(8)],
                              oracle::kFlavours[static_cast<std::size_t>(random.below(6))]);
    } while (a.type() == ShapeType::kHalfSpace && b.type() == ShapeType::kHalfSpace);
    size = oracle::sizeOf(a) + oracle::sizeOf(b);
    X_WA.rotation = random.rotation();
    X_WB.rotation = random.chance(0.3) ? X_WA.rotation : random.rotation();
    X_WB.translation =
        random.chance(0.2) ? Vector3d(1e4 * size * random.direction()) : Vector3d::Zero();
    X_WA.translation = X_WB.translation + size * random.uniform(0, 1.3) * random.direction();
  }
  std::string replay() const {
    return oracle::replay(a) + " at " + oracle::replay(X_WA) + " with " + oracle::replay(b) +
           " at " + oracle::replay(X_WB);
  }

  Random random;
  Shape a = Shape::sphere(1), b = Shape::sphere(1);
  Pose X_WA, X_WB;
  double size = 0;
};

TEST(Distance, ThresholdsAreDecidedOnTheRightSide) {
  Scratch scratch;
  RandomPairs pairs(21);
  int above = 0, not_above = 0, open = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    pairs.next();
    const DistanceResult exact = distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, {}, scratch);
    for (const double offset : {-0.3, -1e-3, -1e-7, 1e-7, 1e-3, 0.3}) {
      DistanceRequest request;
      request.tolerance = 0;
      request.threshold = 0.5 * (exact.distance.lower + exact.distance.upper) + offset * pairs.size;
      const DistanceResult r = distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, request, scratch);
      if (r.status == DistanceStatus::kAboveThreshold) {
        ++above;
        EXPECT_GT(exact.distance.upper, request.threshold) << pairs.replay();
      } else if (r.status == DistanceStatus::kNotAboveThreshold) {
        ++not_above;
        EXPECT_LE(exact.distance.lower, request.threshold) << pairs.replay();
      } else {
        // Only if the exact query also left the threshold inside its interval.
        ++open;
        EXPECT_TRUE(exact.distance.lower <= request.threshold + 1e-12 * pairs.size * 1e4 &&
                    exact.distance.upper >= request.threshold - 1e-12 * pairs.size * 1e4)
            << pairs.replay();
      }
      EXPECT_LE(r.distance.lower, exact.distance.upper) << pairs.replay();
      EXPECT_GE(r.distance.upper, exact.distance.lower) << pairs.replay();
    }
  }
  EXPECT_GT(above, casesToAsk(8000));
  EXPECT_GT(not_above, casesToAsk(8000));
  EXPECT_LT(open, casesToAsk(500));
}

TEST(Distance, AnyLimitCacheOrOrderAgreesWithTheExactAnswer) {
  Scratch scratch;
  RandomPairs pairs(22);
  PairCache cache;
  int unconverged = 0;
  for (int i = 0; i < casesToAsk(6000); ++i) {
    pairs.next();
    const DistanceResult exact = distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, {}, scratch);
    const auto agrees = [&](const DistanceResult& r, const char* how) {
      EXPECT_LE(r.distance.lower, exact.distance.upper) << how << " " << pairs.replay();
      EXPECT_GE(r.distance.upper, exact.distance.lower) << how << " " << pairs.replay();
      EXPECT_LE(r.distance.lower, r.distance.upper) << how << " " << pairs.replay();
    };
    for (const int limit : {-1, 0, 1, 2, 3, 4, 7, 12, 30}) {
      DistanceRequest request;
      request.iteration_limit = limit;
      const DistanceResult r = distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, request, scratch);
      agrees(r, "limited");
      EXPECT_LE(r.iterations, std::max(limit, 1)) << pairs.replay();
      unconverged += r.status == DistanceStatus::kLimit;
    }
    agrees(distance(pairs.b, pairs.X_WB, pairs.a, pairs.X_WA, {}, scratch), "swapped");
    agrees(distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, {}, scratch, &cache),
           "foreign cache");
    agrees(distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, {}, scratch, &cache), "own cache");
    DistanceRequest shallow;
    shallow.depth = false;
    agrees(distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, shallow, scratch), "no depth");
  }
  EXPECT_GT(unconverged, casesToAsk(2000));
}

TEST(Distance, TheSameTwiceIsTheSameBitForBit) {
  Scratch scratch, other;
  RandomPairs pairs(23), again(23);
  for (int i = 0; i < 500; ++i) {
    pairs.next();
    again.next();
    const DistanceResult r = distance(pairs.a, pairs.X_WA, pairs.b, pairs.X_WB, {}, scratch);
    // Using the scratch for another query in between changes nothing.
    distance(again.b, again.X_WB, again.b, again.X_WB, {}, other);
    const DistanceResult s = distance(again.a, again.X_WA, again.b, again.X_WB, {}, other);
    EXPECT_EQ(r.distance.lower, s.distance.lower);
    EXPECT_EQ(r.distance.upper, s.distance.upper);
    EXPECT_EQ(r.normal, s.normal);
    EXPECT_EQ(r.iterations, s.iterations);
  }
}

TEST(Distance, FarFromTheOriginOnlyTheRoundingOfTheInputIsLost) {
  Scratch scratch;
  const Shape box = Shape::box({1, 1, 1});
  Random random(31);
  for (const double far : {1e3, 1e6, 1e9, 1e12}) {
    for (int i = 0; i < 100; ++i) {
      const Vector3d offset = far * random.direction();
      Pose X_WA{random.rotation(), offset}, X_WB{random.rotation(), offset};
      X_WB.translation += 4 * random.direction();
      // Subtracting these translations is exact, so the pair near the origin has the same answer.
      Pose X_BA = X_WA;
      X_BA.translation = X_WA.translation - X_WB.translation;
      const Pose origin{X_WB.rotation, Vector3d::Zero()};
      const DistanceResult away = distance(box, X_WA, box, X_WB, {}, scratch);
      const DistanceResult near = distance(box, X_BA, box, origin, {}, scratch);
      EXPECT_EQ(away.distance.lower, near.distance.lower);
      EXPECT_EQ(away.distance.upper, near.distance.upper);
    }
  }
}

// A shape of size about `scale`.
Shape shapeOfScale(ShapeType type, double scale, Random& random) {
  const auto size = [&] { return scale * random.uniform(0.2, 1); };
  switch (type) {
    case ShapeType::kSphere:
      return Shape::sphere(size());
    case ShapeType::kCapsule:
      return Shape::capsule(size(), size());
    case ShapeType::kBox:
      return Shape::box({size(), size(), size()});
    case ShapeType::kCylinder:
      return Shape::cylinder(size(), size());
    case ShapeType::kCone:
      return Shape::cone(size(), size());
    case ShapeType::kEllipsoid:
      return Shape::ellipsoid({size(), size(), size()});
    case ShapeType::kHalfSpace:
      return Shape::halfSpace();
    default: {
      std::vector<Vector3d> points;
      for (int i = 0; i < 12; ++i) points.emplace_back(size() * random.direction());
      return hullOf(points);
    }
  }
}

// Default intervals are as narrow as 1e-9 of the larger body, even for bodies of micrometres, for
// which 1e-9 m is a thousandth. (At 1 km they are 1e-9 m wide.)
TEST(Distance, DefaultToleranceIsOfTheSizes) {
  using enum ShapeType;
  constexpr ShapeType kTypes[] = {kSphere, kCapsule,   kBox,        kCylinder,
                                  kCone,   kEllipsoid, kConvexHull, kHalfSpace};
  Scratch scratch;
  Random random(47);
  int overlapping = 0, apart = 0;
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3})
    for (const ShapeType type_a : kTypes)
      for (const ShapeType type_b : kTypes)
        for (int i = 0; i < casesToAsk(12); ++i) {
          if (type_a == kHalfSpace && type_b == kHalfSpace) continue;
          const Shape a = shapeOfScale(type_a, scale, random),
                      b = shapeOfScale(type_b, scale * (i % 4 == 0 ? 0.01 : 1), random);
          const Pose X_WA{random.rotation(), scale * random.direction()};
          // (A quarter of them a metre away.)
          const double way = i % 4 == 1 ? 1 : scale * random.uniform(0, 3);
          const Pose X_WB{random.rotation(), X_WA.translation + way * random.direction()};
          const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
          const double asked = defaultTolerance(a, X_WA, b, X_WB);
          const auto finite = [](double x) { return std::isfinite(x) ? x : 0; };
          const double larger = std::max(finite(a.boundingRadius()), finite(b.boundingRadius())),
                       most = std::max({finite(a.extent()), finite(b.extent()), 2 * way});
          EXPECT_LE(asked, std::max(std::min(1e-9 * larger, 1e-9), 1e-12 * most));
          EXPECT_EQ(r.status, DistanceStatus::kConverged)
              << oracle::replay(a) << " at " << oracle::replay(X_WA) << " with "
              << oracle::replay(b) << " at " << oracle::replay(X_WB);
          EXPECT_LE(r.distance.width(), asked);
          overlapping += r.distance.upper < 0;
          apart += r.distance.lower > 0;
          // The same as with an explicit tolerance.
          DistanceRequest named;
          named.tolerance = asked;
          const DistanceResult again = distance(a, X_WA, b, X_WB, named, scratch);
          EXPECT_EQ(r.distance.lower, again.distance.lower);
          EXPECT_EQ(r.distance.upper, again.distance.upper);
        }
  EXPECT_GT(overlapping, casesToAsk(500));
  EXPECT_GT(apart, casesToAsk(500));
}

// If offsets overflow, the tolerance is 0, because any interval would meet an infinite one.
TEST(Distance, DefaultToleranceIsFinite) {
  Scratch scratch;
  const Shape ball = Shape::sphere(1), box = Shape::box({1, 1, 1});
  for (const double far : {1e60, 1e160, 1e300, 1.7e308, kInfinity, kNaN}) {
    const Pose X_WA = at(-far, -far, far), X_WB = at(far, far, -far);
    const double asked = defaultTolerance(ball, X_WA, box, X_WB);
    EXPECT_TRUE(asked >= 0 && asked < kInfinity) << far;
    for (const Shape* b : {&ball, &box}) {
      const DistanceResult r = distance(ball, X_WA, *b, X_WB, {}, scratch);
      if (r.status != DistanceStatus::kConverged) continue;
      EXPECT_LE(r.distance.width(), asked) << far;
    }
  }
  EXPECT_EQ(defaultTolerance(ball, at(-1.7e308, 0, 0), box, at(1.7e308, 0, 0)), 0);
}

}  // namespace
}  // namespace leeway::collision
