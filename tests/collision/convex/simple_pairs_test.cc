// Closed forms of simple pairs against their slow twin, generalDistance() by GJK.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "collision/convex/pairs/simple_answer.h"
#include "leeway/collision/distance.h"
#include "tests/collision/convex/pair_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::moveApart;
using testing::outside;
using testing::Pair;

double size(Random& random) {
  const double some = random.uniform(0.1, 1);
  return random.chance(0.05) ? 0 : random.chance(0.1) ? some * random.logUniform(1e-6, 1) : some;
}

Shape simpleShape(Random& random, ShapeType type) {
  const double first = size(random), second = size(random);
  switch (type) {
    case ShapeType::kSphere:
      return Shape::sphere(first);
    case ShapeType::kCapsule:
      return Shape::capsule(first, second);
    case ShapeType::kBox:
      return Shape::box({first, second, size(random)});
    default:
      return Shape::cylinder(first, second);
  }
}

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  Eigen::Matrix3d K;
  K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
}

// Usually 1e-9 to 10 m apart; a third of them with (nearly) parallel axes.
Pair simplePair(Random& random, ShapeType type_a, ShapeType type_b, Scratch& scratch) {
  Pair pair{simpleShape(random, type_a), simpleShape(random, type_b), {}, {}};
  const Vector3d middle =
      random.chance(0.2) ? Vector3d(1e3 * random.direction()) : Vector3d(0, 0, 0);
  pair.X_WA = {random.rotation(), middle + random.direction()};
  pair.X_WB = {random.rotation(), middle + random.uniform(0.5, 3) * random.direction()};
  if (random.chance(0.3)) {
    const double tilt = random.chance(0.5) ? 0 : random.logUniform(1e-17, 1e-2);
    const double quarters = 0.5 * 3.14159265358979312 * random.below(4);
    pair.X_WB.rotation = pair.X_WA.rotation * turned(Vector3d::Unit(random.below(3)), quarters) *
                         turned(random.direction(), tilt);
  }
  const double gap = random.logUniform(1e-9, 10);
  for (int i = 0; i < 3; ++i) moveApart(pair, gap, scratch);
  return pair;
}

bool answerSimplePair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      const DistanceRequest& request, PairCache* cache, DistanceResult& result) {
  const auto segments = [&]<bool kSegmentA, bool kSegmentB>() {
    PairAnswer found;
    if (!answerSegments<kSegmentA, kSegmentB>(a, X_WA, b, X_WB, request, cache, found)) {
      return false;
    }
    found.writeTo(result);
    return true;
  };
  const bool capsule_a = a.type() == ShapeType::kCapsule,
             capsule_b = b.type() == ShapeType::kCapsule;
  if ((capsule_a || a.type() == ShapeType::kSphere) &&
      (capsule_b || b.type() == ShapeType::kSphere)) {
    return capsule_a
               ? capsule_b ? segments.operator()<true, true>() : segments.operator()<true, false>()
           : capsule_b ? segments.operator()<false, true>()
                       : segments.operator()<false, false>();
  }
  return answerBoxPair(a, X_WA, b, X_WB, request, cache, result);
}

constexpr ShapeType kTypes[] = {ShapeType::kSphere, ShapeType::kCapsule, ShapeType::kBox,
                                ShapeType::kCylinder};

TEST(SimplePairs, AgreeWithTheGeneralWay) {
  Random random(71);
  Scratch scratch;
  for (const ShapeType type_a : kTypes) {
    for (const ShapeType type_b : kTypes) {
      int apart = 0, closed = 0;
      for (int i = 0; i < casesToAsk(1500); ++i) {
        const Pair p = simplePair(random, type_a, type_b, scratch);
        const DistanceResult slow =
            generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr);
        apart += slow.distance.lower > 1e-10;
        DistanceResult r;
        PairCache cache;
        if (!answerSimplePair(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), &cache, r)) continue;
        closed += slow.distance.lower > 1e-10;
        EXPECT_EQ(r.status, DistanceStatus::kConverged) << p.replay();
        EXPECT_LE(r.distance.width(), 1e-9) << p.replay();
        EXPECT_LE(r.distance.lower, slow.distance.upper) << p.replay();
        EXPECT_GE(r.distance.upper, slow.distance.lower) << p.replay();
        EXPECT_NEAR(r.normal.norm(), 1, 1e-12) << p.replay();
        EXPECT_LT(((r.point_b - r.point_a) - r.distance.upper * r.normal).norm(), 2e-9)
            << p.replay();
        EXPECT_LT(outside(p.a, p.X_WA, r.point_a, scratch), 1e-11) << p.replay();
        EXPECT_LT(outside(p.b, p.X_WB, r.point_b, scratch), 1e-11) << p.replay();
        EXPECT_LT((p.X_WB.rotation * cache.direction_B - r.normal).norm(), 1e-12) << p.replay();
      }
      EXPECT_GT(apart, casesToAsk(1000)) << toString(type_a) << " and " << toString(type_b);
      // (Rims that nearly touch along a line, or two at once, are left to generalDistance().)
      EXPECT_GT(closed, apart * 90 / 100) << toString(type_a) << " and " << toString(type_b);
    }
  }
}

TEST(SimplePairs, ThresholdsAreDecidedAsTheGeneralWayDoes) {
  Random random(72);
  Scratch scratch;
  int early = 0;
  for (int i = 0; i < casesToAsk(8000); ++i) {
    const Pair p = simplePair(random, kTypes[random.below(4)], kTypes[random.below(4)], scratch);
    const Interval truth =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr).distance;
    DistanceRequest request = testing::nanometre();
    request.threshold =
        random.chance(0.5) ? truth.upper * random.uniform(0.5, 2) : random.logUniform(1e-9, 10);
    DistanceResult r;
    if (!answerSimplePair(p.a, p.X_WA, p.b, p.X_WB, request, nullptr, r)) continue;
    early += r.distance.width() > 1e-9;
    EXPECT_LE(r.distance.lower, truth.upper) << p.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << p.replay();
    EXPECT_NEAR((r.point_b - r.point_a).norm(), std::abs(r.distance.upper), 1e-11) << p.replay();
    if (truth.lower > request.threshold) {
      EXPECT_GT(r.distance.lower, request.threshold) << p.replay();
    }
    if (truth.upper <= request.threshold) {
      EXPECT_LE(r.distance.upper, request.threshold) << p.replay();
    }
    EXPECT_LT(outside(p.a, p.X_WA, r.point_a, scratch), 1e-11) << p.replay();
    EXPECT_LT(outside(p.b, p.X_WB, r.point_b, scratch), 1e-11) << p.replay();
  }
  EXPECT_GT(early, casesToAsk(500));
}

// Thresholds close to the distance and at impossible distances, with all kinds of boxes: no verdict
// may contradict generalDistance(), and if that decides, the closed forms must decide, too.
TEST(SimplePairs, ThresholdsOfBoxesNextToTheDistance) {
  Random random(75);
  Scratch scratch;
  int above = 0, below = 0;
  for (int i = 0; i < casesToAsk(20000); ++i) {
    const double scale = random.chance(0.1) ? random.logUniform(1e-2, 1e8) : 1;
    const auto box = [&] {
      return Shape::box(scale * Vector3d(size(random), size(random), size(random)));
    };
    Pair p{box(), box(), {}, {}};
    p.X_WA = {random.rotation(), scale * random.direction()};
    p.X_WB = {random.chance(0.1) ? p.X_WA.rotation : random.rotation(),
              scale * random.uniform(0, 4) * random.direction()};
    const DistanceResult exact =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr);
    const Interval truth = exact.distance;
    DistanceRequest request = testing::nanometre();
    request.tolerance = random.chance(0.5) ? 1e-9 : 0;
    request.threshold = random.chance(0.6) ? truth.upper + (random.chance(0.5) ? 1 : -1) * scale *
                                                               random.logUniform(1e-17, 1e-11)
                        : random.chance(0.3) ? truth.upper
                        : random.chance(0.1) ? 0
                                             : scale * random.uniform(-1, 4);
    const DistanceResult r = distance(p.a, p.X_WA, p.b, p.X_WB, request, scratch);
    EXPECT_LE(r.distance.lower, truth.upper) << p.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << p.replay();
    const bool is_above = r.distance.lower > request.threshold;
    const bool is_below = r.distance.upper <= request.threshold;
    above += is_above;
    below += is_below;
    EXPECT_EQ(r.status == DistanceStatus::kAboveThreshold,
              is_above && r.distance.width() > request.tolerance)
        << p.replay();
    const double room = 1e-13 * (scale + std::abs(truth.upper));
    if (truth.lower > request.threshold + room) {
      EXPECT_TRUE(is_above) << p.replay();
    }
    if (truth.upper < request.threshold - room) {
      EXPECT_TRUE(is_below) << p.replay();
    }
  }
  EXPECT_GT(above, casesToAsk(4000));
  EXPECT_GT(below, casesToAsk(5000));
}

// Every path checks the poses.
TEST(SimplePairs, PosesThatAreNoneAreRefused) {
  Random random(76);
  Scratch scratch;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    Pair p = simplePair(random, kTypes[random.below(4)], kTypes[random.below(4)], scratch);
    Pose& X = random.chance(0.5) ? p.X_WA : p.X_WB;
    const double wrong[] = {std::nan(""), std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity(), 1e200};
    const int k = random.below(3);
    if (random.chance(0.2)) {
      X.translation[k] = wrong[random.below(3)];
    } else if (random.chance(0.5)) {
      X.rotation(random.below(3), k) = wrong[random.below(4)];
    } else {
      X.rotation.col(k) *= 1 + (random.chance(0.5) ? 1 : -1) * random.logUniform(2e-6, 1);
    }
    DistanceRequest request = testing::nanometre();
    if (random.chance(0.5)) request.threshold = random.uniform(-1, 2);
    const DistanceResult r = distance(p.a, p.X_WA, p.b, p.X_WB, request, scratch);
    EXPECT_EQ(r.status, DistanceStatus::kInvalid) << p.replay();
    EXPECT_EQ(r.distance.upper, std::numeric_limits<double>::infinity()) << p.replay();
  }
}

TEST(SimplePairs, AnyCacheAgrees) {
  Random random(73);
  Scratch scratch;
  int closed = 0, apart = 0;
  for (int i = 0; i < casesToAsk(400); ++i) {
    Pair p = simplePair(random, ShapeType::kBox,
                        random.chance(0.8) ? ShapeType::kBox : kTypes[random.below(4)], scratch);
    PairCache cache;
    if (random.chance(0.1)) cache.direction_B = random.uniform(0, 2) * random.direction();
    if (random.chance(0.1)) cache.direction_B = Vector3d::Unit(random.below(3));
    if (random.chance(0.05)) cache.direction_B.x() = std::nan("");
    const Vector3d step = 0.01 * random.direction();
    const Eigen::Matrix3d turn = turned(random.direction(), 0.02);
    for (int frame = 0; frame < 20; ++frame) {
      const DistanceResult slow =
          generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr);
      apart += slow.distance.lower > 1e-10;
      DistanceResult r;
      if (answerSimplePair(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), &cache, r)) {
        closed += slow.distance.lower > 1e-10;
        EXPECT_LE(r.distance.width(), 1e-9) << p.replay();
        EXPECT_LE(r.distance.lower, slow.distance.upper) << p.replay();
        EXPECT_GE(r.distance.upper, slow.distance.lower) << p.replay();
        EXPECT_LT(outside(p.a, p.X_WA, r.point_a, scratch), 1e-11) << p.replay();
        EXPECT_LT(outside(p.b, p.X_WB, r.point_b, scratch), 1e-11) << p.replay();
      }
      p.X_WB.translation += step;
      p.X_WB.rotation = turn * p.X_WB.rotation;
    }
  }
  EXPECT_GT(apart, casesToAsk(4000));
  EXPECT_GT(closed, apart * 95 / 100);
}

// The reach of a shape along n from its centre.
double reachOf(const Shape& shape, const Pose& X_WS, const Vector3d& n) {
  const Vector3d d = (X_WS.rotation.transpose() * n).cwiseAbs();
  switch (shape.type()) {
    case ShapeType::kSphere:
      return shape.radius();
    case ShapeType::kCapsule:
      return shape.radius() + shape.halfLength() * d.z();
    case ShapeType::kBox:
      return d.dot(shape.halfExtents());
    default:
      return shape.halfLength() * d.z() + shape.radius() * std::hypot(d.x(), d.y());
  }
}

// Thin segments and cylinders next to a point. Regression: the normal was not perpendicular to the
// axis, and the plane, which certifies motions, was up to 1e-4 below the lower end.
TEST(SimplePairs, LowerEndsAreThoseOfThePlaneAcrossTheNormal) {
  Random random(74);
  Scratch scratch;
  int closed = 0;
  for (int i = 0; i < casesToAsk(20000); ++i) {
    Pair p = simplePair(random, kTypes[random.below(4)], kTypes[random.below(4)], scratch);
    if (random.chance(0.5)) {
      const double thin = random.chance(0.3) ? 0 : random.logUniform(1e-9, 1e-3);
      const double length = random.uniform(0.1, 1);
      p.a = Shape::sphere(thin);
      p.b = random.chance(0.5) ? Shape::capsule(thin, length) : Shape::cylinder(thin, length);
      const Vector3d across = p.X_WB.rotation * Vector3d(0.6, 0.8, 0);
      p.X_WA.translation = p.X_WB.translation +
                           random.uniform(-0.9, 0.9) * length * p.X_WB.rotation.col(2) +
                           (2 * thin + random.logUniform(1e-12, 1e-6)) * across;
      if (random.chance(0.5)) {
        std::swap(p.a, p.b);
        std::swap(p.X_WA, p.X_WB);
      }
    }
    DistanceResult r;
    if (!answerSimplePair(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), nullptr, r)) continue;
    ++closed;
    const double plane = r.normal.dot(p.X_WB.translation - p.X_WA.translation) -
                         reachOf(p.a, p.X_WA, r.normal) - reachOf(p.b, p.X_WB, r.normal);
    EXPECT_LE(r.distance.lower, plane + 1e-14) << p.replay();
  }
  EXPECT_GT(closed, casesToAsk(10000));
}

// Edges that are parallel except for an entry whose square is the smallest double. Regression:
// their normal was 1.2 long, and the lower end was above the distance, which is 1.
TEST(SimplePairs, EdgesThatAreParallelButForTheSmallestNumbers) {
  Scratch scratch;
  const Shape box = Shape::box({1, 1, 1});
  for (const double tiny : {1.6e-162, 2.7e-162, 3e-160, 1e-150, 1e-30}) {
    for (const double x : {-2, 0, 2}) {
      for (const double side : {-1, 1}) {
        Pose X_WA{Eigen::Matrix3d::Identity(), {x, 3 * side, 0}};
        X_WA.rotation(0, 2) = tiny;
        PairCache cache;
        cache.direction_B = Vector3d(1, -side, 0) / std::sqrt(2.0);
        const Interval d = distance(box, X_WA, box, {}, {}, scratch, &cache).distance;
        EXPECT_LE(d.lower, 1) << tiny << " " << x;
        EXPECT_NEAR(d.upper, 1, 1e-9) << tiny << " " << x;
      }
    }
  }
}

// Matrices close to rotations are accepted, and their departure widens the interval. Regression: a
// cylinder's axis that was not of unit length put a witness a radius off.
TEST(SimplePairs, DeparturesFromRotationsAreInTheWidth) {
  Random random(99);
  Scratch scratch;
  int answered = 0;
  for (int i = 0; i < casesToAsk(40000); ++i) {
    Pair p = simplePair(random, kTypes[random.below(4)], kTypes[random.below(4)], scratch);
    const Interval truth =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr).distance;
    for (Pose* X : {&p.X_WA, &p.X_WB}) {
      Eigen::Matrix3d strain = Eigen::Matrix3d::Identity();
      if (random.chance(0.7)) {
        for (int k = 0; k < 3; ++k) strain.col(k) = random.direction();
        strain = (0.5 * (strain + strain.transpose())).eval();
      }
      const double small = random.logUniform(1e-12, 2.5e-7);
      X->rotation = (X->rotation * (Eigen::Matrix3d::Identity() + small * strain)).eval();
    }
    DistanceRequest request = testing::nanometre();
    request.tolerance = 1e-3;
    if (random.chance(0.3)) request.threshold = truth.upper * random.uniform(0.5, 2);
    DistanceResult r;
    if (!answerSimplePair(p.a, p.X_WA, p.b, p.X_WB, request, nullptr, r)) continue;
    ++answered;
    EXPECT_LE(r.distance.lower, truth.upper) << p.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << p.replay();
  }
  EXPECT_GT(answered, casesToAsk(25000));
}

}  // namespace
}  // namespace leeway::collision
