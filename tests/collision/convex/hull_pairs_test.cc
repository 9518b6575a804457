// Pairs of hulls from world poses against their slow twin, generalDistance(), and the oracle in
// quadruple precision.

#include "collision/convex/hull_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "collision/convex/pairs/simple_pairs.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tests/collision/convex/pair_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::moveApart;
using testing::outside;
using testing::Pair;

// 1 to 80 vertices, and sometimes 300: scanned, placed or looked up in a table; some thin or flat,
// some with duplicated points.
Shape anyHull(Random& random) {
  const int count = random.chance(0.05)  ? 300
                    : random.chance(0.7) ? 4 + random.below(30)
                                         : 1 + random.below(80);
  Vector3d scale(1, random.uniform(0.3, 1), random.uniform(0.3, 1));
  if (random.chance(0.2)) scale.y() = random.logUniform(1e-6, 1e-2);
  if (random.chance(0.2)) scale.z() = random.chance(0.3) ? 0 : random.logUniform(1e-6, 1);
  const Vector3d shift = random.chance(0.2) ? Vector3d(2 * random.direction()) : Vector3d(0, 0, 0);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(shift + scale.cwiseProduct(random.direction()));
    if (random.chance(0.05)) points.push_back(points.back());
  }
  return Shape::convexHull(points);
}

// Usually 1e-12 to 10 m apart; some parallel.
Pair hullPair(Random& random, Scratch& scratch) {
  Pair pair{anyHull(random), anyHull(random), {}, {}};
  const Vector3d middle =
      random.chance(0.2) ? Vector3d(1e3 * random.direction()) : Vector3d(0, 0, 0);
  pair.X_WA = {random.rotation(), middle + random.direction()};
  pair.X_WB = {random.chance(0.2) ? pair.X_WA.rotation : random.rotation(),
               middle + random.uniform(0, 4) * random.direction()};
  const double gap = random.logUniform(1e-12, 10);
  for (int i = 0; i < 3 && random.chance(0.9); ++i) moveApart(pair, gap, scratch);
  return pair;
}

// A pair of hulls in another unit of length; exact if the scale is a power of two.
Pair scaled(const Pair& pair, double scale) {
  const auto hull = [&](const Shape& shape) {
    std::vector<Vector3d> points(shape.hull()->vertices().begin(), shape.hull()->vertices().end());
    for (Vector3d& point : points) point *= scale;
    return Shape::convexHull(points);
  };
  return {hull(pair.a),
          hull(pair.b),
          {pair.X_WA.rotation, scale * pair.X_WA.translation},
          {pair.X_WB.rotation, scale * pair.X_WB.translation}};
}

// The plane along n, from A's farthest vertex to B's.
double planeAlong(const Pair& p, const Vector3d& n) {
  double a = -1e300, b = 1e300;
  for (const Vector3d& v : p.a.hull()->vertices())
    a = std::max(a, n.dot(p.X_WA.rotation * v + (p.X_WA.translation - p.X_WB.translation)));
  for (const Vector3d& v : p.b.hull()->vertices()) b = std::min(b, n.dot(p.X_WB.rotation * v));
  return b - a;
}

void expectSound(const Pair& p, const DistanceResult& r, const Interval& truth, double rounding,
                 Scratch& scratch) {
  EXPECT_LE(r.distance.lower, truth.upper) << p.replay();
  EXPECT_GE(r.distance.upper, truth.lower) << p.replay();
  EXPECT_NEAR(r.normal.norm(), 1, 1e-12) << p.replay();
  EXPECT_LE(r.distance.lower, planeAlong(p, r.normal) + 1e-15 * p.size()) << p.replay();
  EXPECT_NEAR((r.point_b - r.point_a).norm(), r.distance.upper, rounding) << p.replay();
  EXPECT_LT(outside(p.a, p.X_WA, r.point_a, scratch), rounding) << p.replay();
  EXPECT_LT(outside(p.b, p.X_WB, r.point_b, scratch), rounding) << p.replay();
}

TEST(HullPairs, AgreeWithTheGeneralWay) {
  Random random(131);
  Scratch scratch;
  int apart = 0, answered = 0, handed_over = 0;
  for (int i = 0; i < casesToAsk(9000); ++i) {
    const Pair p = hullPair(random, scratch);
    const DistanceResult slow =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr);
    // (Large hulls without a cache are left to generalDistance().)
    const bool counts = slow.distance.lower > 1e-9 && p.a.hull()->vertices().size() <= 32 &&
                        p.b.hull()->vertices().size() <= 32;
    apart += counts;
    DistanceResult r;
    PairCache cache;
    VertexStart start;
    if (answerHullPair(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), &cache, r, start)) {
      answered += counts;
      EXPECT_EQ(r.status, DistanceStatus::kConverged) << p.replay();
      EXPECT_LE(r.distance.width(), 1e-9) << p.replay();
      expectSound(p, r, slow.distance, 2e-12, scratch);
      EXPECT_LT((p.X_WB.rotation * cache.direction_B - r.normal).norm(), 1e-12) << p.replay();
      continue;
    }
    // Continuing from there gives the result of an independent search.
    handed_over += start.count > 0;
    const DistanceResult on =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr, &start);
    EXPECT_LE(on.distance.lower, slow.distance.upper) << p.replay();
    EXPECT_GE(on.distance.upper, slow.distance.lower) << p.replay();
    EXPECT_LE(on.distance.width(), std::max(2 * slow.distance.width(), 1e-9)) << p.replay();
  }
  EXPECT_GT(apart, casesToAsk(2500));
  EXPECT_GT(answered, apart * (kSanitized ? 95 : 98) / 100);
  EXPECT_GT(handed_over, casesToAsk(50));
}

// Directions have up to the cube of a length.
TEST(HullPairs, SizesAtTheEndsOfTheScale) {
  Random random(135);
  Scratch scratch;
  int converged = 0, asked = 0;
  for (int i = 0; i < casesToAsk(1500); ++i) {
    const Pair p = hullPair(random, scratch);
    const DistanceResult r =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr);
    for (const int power : {-22, -12, 10, 20, 27}) {
      const double scale = std::ldexp(1, power);
      const Pair q = scaled(p, scale);
      DistanceRequest request = testing::nanometre();
      request.tolerance *= scale;
      const DistanceResult large = distance(q.a, q.X_WA, q.b, q.X_WB, request, scratch, nullptr);
      ASSERT_LE(large.distance.lower, scale * r.distance.upper) << power << " " << p.replay();
      ASSERT_GE(large.distance.upper, scale * r.distance.lower) << power << " " << p.replay();
      ++asked;
      converged += large.status == DistanceStatus::kConverged;
    }
  }
  EXPECT_GT(converged, asked * 95 / 100);
}

// A cached direction has length 1 for any sizes. Regression: it was used unscaled, which narrowed
// the fan of small bodies, so that they took half as many steps again.
TEST(HullPairs, StepsFromADirectionDoNotDependOnTheScale) {
  Random random(136);
  Scratch scratch;
  int asked = 0;
  for (int i = 0; i < casesToAsk(300); ++i) {
    const Pair p = hullPair(random, scratch);
    const Vector3d direction = random.direction();
    int steps = 0;
    for (const int power : {0, -10, 10}) {
      const double scale = std::ldexp(1, power);
      const Pair q = scaled(p, scale);
      DistanceRequest request = testing::nanometre();
      request.tolerance *= scale;
      PairCache cache;
      cache.direction_B = direction;
      DistanceResult r;
      VertexStart start;
      if (!answerHullPair(q.a, q.X_WA, q.b, q.X_WB, request, &cache, r, start)) break;
      if (power == 0) steps = r.iterations;
      EXPECT_EQ(r.iterations, steps) << power << " " << p.replay();
      ++asked;
    }
  }
  EXPECT_GT(asked, 3 * casesToAsk(100));
}

TEST(HullPairs, HoldTheTruth) {
  Random random(132);
  Scratch scratch;
  int answered = 0;
  for (int i = 0; i < 60; ++i) {
    const Pair p = hullPair(random, scratch);
    if (p.a.hull()->vertices().size() > 40 || p.b.hull()->vertices().size() > 40) continue;
    DistanceRequest request = testing::nanometre();
    request.tolerance = random.chance(0.5) ? 1e-9 : 1e-12;
    DistanceResult r;
    VertexStart start;
    if (!answerHullPair(p.a, p.X_WA, p.b, p.X_WB, request, nullptr, r, start)) continue;
    ++answered;
    const oracle::Truth truth = oracle::signedSeparation(p.a, p.X_WA, p.b, p.X_WB);
    EXPECT_LE(r.distance.lower, truth.upper) << p.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << p.replay();
  }
  EXPECT_GT(answered, 15);
}

TEST(HullPairs, ThresholdsAreDecidedAsTheGeneralWayDoes) {
  Random random(133);
  Scratch scratch;
  int above = 0, below = 0;
  for (int i = 0; i < casesToAsk(4000); ++i) {
    const Pair p = hullPair(random, scratch);
    const Interval truth =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr).distance;
    DistanceRequest request = testing::nanometre();
    request.threshold =
        random.chance(0.5) ? truth.upper * random.uniform(0.5, 2) : random.logUniform(1e-9, 10);
    request.depth = random.chance(0.5);
    PairCache cache;
    cache.direction_B = random.direction();
    DistanceResult r;
    VertexStart start;
    if (!answerHullPair(p.a, p.X_WA, p.b, p.X_WB, request, random.chance(0.5) ? &cache : nullptr, r,
                        start)) {
      continue;
    }
    expectSound(p, r, truth, 2e-12, scratch);
    if (truth.lower > request.threshold + request.tolerance) {
      ++above;
      EXPECT_GT(r.distance.lower, request.threshold) << p.replay();
    }
    if (truth.upper <= request.threshold - request.tolerance) {
      ++below;
      EXPECT_LE(r.distance.upper, request.threshold) << p.replay();
    }
  }
  EXPECT_GT(above, casesToAsk(700));
  EXPECT_GT(below, casesToAsk(700));
}

TEST(HullPairs, AnyCacheAgrees) {
  Random random(134);
  Scratch scratch;
  int answered = 0;
  for (int i = 0; i < 400; ++i) {
    Pair p = hullPair(random, scratch);
    PairCache cache;
    if (random.chance(0.3)) {
      cache.simplex_count = random.below(5) - 1;
      for (int k = 0; k < 3; ++k) {
        cache.simplex_a[k] = random.below(40) - 2;
        cache.simplex_b[k] = random.chance(0.1) ? 1 << 30 : random.below(40);
      }
      cache.vertex_a = random.below(1000) - 500;
      cache.vertex_b = random.below(1000) - 500;
      cache.direction_B = random.uniform(0, 2) * random.direction();
    }
    if (random.chance(0.05)) cache.direction_B.x() = std::nan("");
    const Vector3d step = 0.01 * random.direction();
    for (int frame = 0; frame < 10; ++frame) {
      const Interval slow =
          generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr)
              .distance;
      DistanceResult r;
      VertexStart start;
      if (answerHullPair(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), &cache, r, start)) {
        ++answered;
        expectSound(p, r, slow, 2e-12, scratch);
      }
      p.X_WB.translation += step;
    }
  }
  EXPECT_GT(answered, 1200);
}

// Matrices near rotations are accepted, and their departure widens the interval.
TEST(HullPairs, DeparturesFromRotationsAreInTheWidth) {
  Random random(135);
  Scratch scratch;
  int answered = 0;
  for (int i = 0; i < casesToAsk(2000); ++i) {
    Pair p = hullPair(random, scratch);
    const Interval truth =
        generalDistance(p.a, p.X_WA, p.b, p.X_WB, testing::nanometre(), scratch, nullptr).distance;
    for (Pose* X : {&p.X_WA, &p.X_WB}) {
      Eigen::Matrix3d strain;
      for (int k = 0; k < 3; ++k) strain.col(k) = random.direction();
      strain = (0.5 * (strain + strain.transpose())).eval();
      const double small = random.logUniform(1e-12, 2.5e-7);
      X->rotation = (X->rotation * (Eigen::Matrix3d::Identity() + small * strain)).eval();
    }
    DistanceRequest request = testing::nanometre();
    request.tolerance = 1e-3;
    DistanceResult r;
    VertexStart start;
    if (!answerHullPair(p.a, p.X_WA, p.b, p.X_WB, request, nullptr, r, start)) continue;
    ++answered;
    EXPECT_LE(r.distance.lower, truth.upper) << p.replay();
    EXPECT_GE(r.distance.upper, truth.lower) << p.replay();
  }
  EXPECT_GT(answered, casesToAsk(500));
}

// Invalid poses, sizes out of range and a limit of 0 are left to generalDistance().
TEST(HullPairs, LeaveTheRestAlone) {
  Random random(136);
  Scratch scratch;
  const Pair p = hullPair(random, scratch);
  DistanceResult r;
  VertexStart start;
  const auto answers = [&](const Pose& X_WA, const Pose& X_WB, const DistanceRequest& request) {
    return answerHullPair(p.a, X_WA, p.b, X_WB, request, nullptr, r, start);
  };
  DistanceRequest none = testing::nanometre();
  none.iteration_limit = 0;
  EXPECT_FALSE(answers(p.X_WA, p.X_WB, none));
  for (const double bad : {std::nan(""), 1e308, 1.1e10, std::numeric_limits<double>::infinity()}) {
    Pose X = p.X_WB;
    X.translation.y() = bad;
    EXPECT_FALSE(answers(p.X_WA, X, testing::nanometre())) << bad;
    X = p.X_WA;
    X.rotation(1, 2) = bad;
    EXPECT_FALSE(answers(X, p.X_WB, testing::nanometre())) << bad;
  }
}

/// Poses of two bodies at random orientations, about `gap` apart.
DistanceResult asked(const Shape& a, const Shape& b, double gap, Random& random, Scratch& scratch) {
  Pair pair{a, b, {random.rotation(), random.direction()}, {}};
  pair.X_WB = {random.rotation(), pair.X_WA.translation + 2.2 * random.direction()};
  for (int k = 0; k < 3; ++k) moveApart(pair, gap, scratch);
  const DistanceResult r = distance(pair.a, pair.X_WA, pair.b, pair.X_WB, {}, scratch);
  EXPECT_EQ(r.status, DistanceStatus::kConverged);
  return r;
}

// Large hulls start along the normal of two ellipsoids that approximate them: 5.6 steps each,
// against 9.6 from the direction of their middles.
TEST(HullPairs, LargeOnesBeginNearTheirNormal) {
  Random random(137);
  Scratch scratch;
  const auto slab = [&random] {
    std::vector<Vector3d> points;
    for (int i = 0; i < 300; ++i) {
      points.push_back(Vector3d(1, 0.4, 0.15).cwiseProduct(random.direction()));
    }
    return Shape::convexHull(points);
  };
  const int cases = 40;
  int steps = 0;
  for (int i = 0; i < cases; ++i) {
    const Shape a = slab(), b = slab();
    const DistanceResult r = asked(a, b, 0.02, random, scratch);
    EXPECT_NEAR(r.distance.upper, 0.02, 1e-6);
    steps += r.iterations;
  }
  EXPECT_LT(steps, 7 * cases);
}

// Needles start between their axes: 3.0 steps each, against 4.0 from the direction of their
// middles.
TEST(HullPairs, NeedlesBeginBetweenTheirAxes) {
  Random random(138);
  Scratch scratch;
  const auto needle = [&random] {
    const Vector3d thin(1, random.logUniform(1e-5, 1e-2), random.logUniform(1e-5, 1e-1));
    std::vector<Vector3d> points;
    for (int i = 0; i < 12; ++i) points.push_back(thin.cwiseProduct(random.direction()));
    return Shape::convexHull(points);
  };
  const int cases = 200;
  int steps = 0;
  for (int i = 0; i < cases; ++i) {
    const Shape a = needle(), b = needle();
    const double gap = random.logUniform(1e-4, 1);
    steps += asked(a, b, gap, random, scratch).iterations;
  }
  EXPECT_LT(2 * steps, 7 * cases);
}

// Axes that cross, are collinear, parallel or equal give no direction: any is valid.
TEST(HullPairs, AxesThatMeetCostStepsOnly) {
  Random random(139);
  Scratch scratch;
  std::vector<Vector3d> points;
  for (int i = 0; i < 12; ++i) {
    points.push_back(Vector3d(1, 0.01, 0.02).cwiseProduct(random.direction()));
  }
  const Shape needle = Shape::convexHull(points);
  const Eigen::Matrix3d same = Eigen::Matrix3d::Identity(),
                        across{{0.28, -0.96, 0}, {0.96, 0.28, 0}, {0, 0, 1}};
  for (const Eigen::Matrix3d& R : {same, across}) {
    for (const Vector3d& t : {Vector3d(0, 0, 0), Vector3d(2.5, 0, 0), Vector3d(0, 0, 0.05),
                              Vector3d(0.3, 0.2, 0.1), Vector3d(0, 1e-3, 0)}) {
      const Pose X_WB{R, t};
      const DistanceResult quick = distance(needle, {}, needle, X_WB, {}, scratch);
      const DistanceResult slow =
          generalDistance(needle, {}, needle, X_WB, testing::nanometre(), scratch, nullptr);
      EXPECT_LE(quick.distance.lower, slow.distance.upper) << t;
      EXPECT_GE(quick.distance.upper, slow.distance.lower) << t;
      EXPECT_EQ(quick.status, slow.status) << t;
    }
  }
}

// A threshold that the first point meets leaves the normal of a stale cache. Regression: the
// radius was laid off along it, with witnesses 1.412 m apart and an upper end of 0.815 m.
TEST(RoundedHulls, WitnessesAreAsFarApartAsTheUpperEndWithAStaleCache) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? 0.1 : -0.1, i & 2 ? 0.1 : -0.1, i & 4 ? 0.1 : -0.1);
  const Shape capsule = Shape::capsule(0.3, 0.05), hull = Shape::convexHull(corners);
  Scratch scratch;
  DistanceRequest request = testing::nanometre();
  request.threshold = 2;
  PairCache cache;
  cache.direction_B = Vector3d(-1, 0, 0);
  const DistanceResult r =
      distance(capsule, {Eigen::Matrix3d::Identity(), Vector3d(0, 0, 0)}, hull,
               {Eigen::Matrix3d::Identity(), Vector3d(1, 0, 0)}, request, scratch, &cache);
  EXPECT_EQ(r.status, DistanceStatus::kNotAboveThreshold);
  EXPECT_GE(r.distance.upper, 0.6);
  EXPECT_NEAR((r.point_b - r.point_a).norm(), r.distance.upper, 1e-12);
}

}  // namespace
}  // namespace leeway::collision
