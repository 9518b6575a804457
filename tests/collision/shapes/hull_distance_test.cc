#include "collision/shapes/hull_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

/// Against quadruple precision: never below the distance, and equal to it up to rounding.
TEST(HullDistance, BoundsTheDistanceFromAbove) {
  Random random(63);
  int outside = 0, inside = 0;
  for (int i = 0; i < casesToAsk(300); ++i) {
    std::vector<Vector3d> points;
    for (int k = 0; k < 12; ++k) points.push_back(random.vector());
    const Vector3d p = random.uniform(0, 2) * random.vector();
    const double found = distanceFromHull(p, points, HullBuilder(points, 12));
    const oracle::Truth truth =
        oracle::signedSeparation(Shape::convexHull(points), {}, Shape::convexHull({&p, 1}), {});
    EXPECT_GE(found, truth.lower);
    EXPECT_LE(found, std::max(truth.upper, 0.0) + 1e-12);
    ++(found > 0 ? outside : inside);
  }
  EXPECT_GT(outside, casesToAsk(100));
  EXPECT_GT(inside, casesToAsk(30));
}

}  // namespace
}  // namespace leeway::collision
