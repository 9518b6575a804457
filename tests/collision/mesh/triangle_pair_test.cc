#include "collision/mesh/descent/triangle_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "leeway/collision/distance.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

TEST(TrianglePair, HoldsTheDistance) {
  Random random(54);
  Scratch scratch;
  int unsafe = 0, apart = 0, exact = 0;
  for (int i = 0; i < casesToAsk(20000); ++i) {
    Vector3d p[3], q[3];
    const double size = std::pow(10, random.uniform(-3, 0));
    const Vector3d offset = random.vector();
    for (int k = 0; k < 3; ++k) {
      p[k] = size * random.vector();
      q[k] = size * (random.vector() + (random.below(2) == 0 ? 1.0 : 3.0) * offset);
    }
    // Degenerate, parallel, and sharing an edge.
    const int kind = random.below(12);
    if (kind == 0) p[2] = p[1];
    if (kind == 1) q[2] = 0.5 * (q[0] + q[1]);
    if (kind == 2) q[0] = q[1] = q[2];
    if (kind == 3) {
      for (int k = 0; k < 3; ++k) q[k] = p[k] + size * offset;
    }
    if (kind == 4) q[0] = p[0], q[1] = p[1];
    if (kind == 5) {
      for (int k = 0; k < 3; ++k) p[k].z() = 0, q[k].z() = 0.5 * size;
    }
    const TrianglePair pair = trianglePair(p, q);
    const Interval d =
        distance(Shape::convexHull(p), {}, Shape::convexHull(q), {}, {}, scratch).distance;
    if (pair.above < d.lower - 1e-14 || pair.below > std::max(d.upper, 0.0) + 1e-14) {
      ++unsafe;
      ADD_FAILURE() << "case " << i << " kind " << kind << ": [" << pair.below << ", " << pair.above
                    << "] against [" << d.lower << ", " << d.upper << "]";
    }
    if (!(d.lower > 1e-6)) continue;
    ++apart;
    EXPECT_NEAR((pair.q - pair.p).norm(), pair.above, 1e-14);
    if (pair.above - pair.below < 1e-12) {
      ++exact;
      continue;
    }
    EXPECT_LT(pair.above - d.upper, 1e-9) << "case " << i << " kind " << kind;
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(apart, casesToAsk(10000));
  EXPECT_GT(exact, 0.99 * apart);
}

// Regression: rounding turned a sliver's normal, so a corner's foot fell outside the sliver. Upper
// ends were below the distance for one such pair in five, and below their lower ends for one in a
// hundred.
TEST(TrianglePair, SliversEndWhereTheyAre) {
  Random random(55);
  Scratch scratch;
  const TriangleMesh::Triangle triangle{0, 1, 2};
  const auto meshOf = [&](const std::vector<Vector3d>& corners) {
    return Shape::mesh(TriangleMesh::make(corners, {&triangle, 1}, {.decompose = false}));
  };
  for (int i = 0; i < casesToAsk(400); ++i) {
    const Vector3d a = random.vector(), b = random.vector(), aside = random.vector();
    const Vector3d c =
        a + random.uniform(0, 1) * (b - a) + std::pow(10, random.uniform(-7, -1)) * aside;
    const double share = random.uniform(0, 1), other = random.uniform(0, 1 - share);
    Vector3d p = a + share * (b - a) + other * (c - a) +
                 std::pow(10, random.uniform(-4, 0)) * (b - a).cross(aside).normalized();
    std::vector<Vector3d> sliver{a, b, c};
    if (i == 0) {  // [0.00020282929834526475, 0.00020282929824044969] for 0.000202834046953039
      sliver = {{-0.74479630923030582, -0.52657605048876333, 0.94304054513334212},
                {0.13856943137462299, 0.37920534117385502, 0.15483927037954984},
                {0.71459863945139523, 0.96985148045743763, -0.35913469255712516}};
      p = {0.49512619801297719, 0.74501831484094594, -0.16323240070745573};
    }
    const Vector3d corner[3] = {p, p, p};
    const oracle::Truth truth =
        oracle::signedSeparation(Shape::convexHull(sliver), {}, Shape::convexHull({&p, 1}), {});
    for (const bool turned : {false, true}) {
      const TrianglePair pair =
          turned ? trianglePair(corner, sliver.data()) : trianglePair(sliver.data(), corner);
      ASSERT_GE(pair.above, truth.lower - 1e-14) << i;
      ASSERT_LE(pair.below, truth.upper + 1e-14) << i;
      ASSERT_NEAR(pair.normal.norm(), 1, 1e-14) << i;
      ASSERT_NEAR((pair.q - pair.p).norm(), pair.above, 1e-14) << i;
      const Shape one = meshOf(turned ? std::vector<Vector3d>(3, p) : sliver),
                  two = meshOf(turned ? sliver : std::vector<Vector3d>(3, p));
      for (const double tolerance : {1e-9, 0.0}) {
        DistanceRequest request;
        request.tolerance = tolerance;
        const Interval found = distance(one, {}, two, {}, request, scratch).distance;
        ASSERT_LE(found.lower, truth.upper) << i << " " << tolerance;
        ASSERT_GE(found.upper, truth.lower) << i << " " << tolerance;
        ASSERT_LE(found.lower, found.upper) << i << " " << tolerance;
      }
    }
  }
}

}  // namespace
}  // namespace leeway::collision
