#include "collision/shapes/hull_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "collision/convex/gjk/convex_view.h"
#include "collision/convex/gjk/support.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

/// Points whose hull has its vertices spread evenly or in clusters.
std::vector<Vector3d> pointsOfHull(Random& random, int kind) {
  std::vector<Vector3d> points;
  const int count = 1 + random.below(kind == 0 ? 700 : 90);
  const bool grid = random.chance(0.3);
  for (int k = 0; k < count; ++k) {
    if (kind == 2) {  // two exactly coplanar rims: more vertices than a table cell lists
      const double angle = 2 * M_PI * k / count;
      for (const double z : {-1.0, 1.0}) points.emplace_back(std::cos(angle), std::sin(angle), z);
    } else {
      points.push_back(grid ? Vector3d(random.below(3), random.below(3), random.below(3))
                            : random.direction());
    }
  }
  return points;
}

/// Vector scans, tables and climbs against the plain scan: same vertex, or one within rounding.
/// Full scans return the first of equal vertices.
TEST(HullSupport, FindsTheFarthestVertex) {
  Random random(62);
  int scanned = 0, looked_up = 0, climbed = 0, tied = 0;
  for (int i = 0; i < casesToAsk(150); ++i) {
    const Shape shape = Shape::convexHull(pointsOfHull(random, i % 3));
    const ConvexView view = viewOf(shape);
    ASSERT_NE(view.support, nullptr);
    const bool scans = view.support->length() > 0;
    (scans ? scanned : looked_up) += 1;
    for (int k = 0; k < 400; ++k) {
      Vector3d d = random.direction();
      if (random.chance(0.3)) d = Vector3d::Unit(random.below(3)) * (random.chance(0.5) ? 1 : -1);
      // On cell boundaries, and slightly off the axes.
      if (random.chance(0.3)) d = Vector3d(random.below(9) - 4, random.below(9) - 4, 4) / 8;
      if (random.chance(0.3)) d += std::pow(10, random.uniform(-16, 0)) * random.direction();
      if (random.chance(0.1)) d *= std::pow(10, random.uniform(-200, 200));
      if (!(d.norm() > 0)) continue;
      int hint = random.below(view.count);
      climbed += scanFarthest(*view.support, d, hint) < 0 ? 1 : 0;
      const double length = d.norm();
      const int found = farthestPoint(view, d / length, random.below(view.count));
      int expected = 0, equal = 0;
      double most = -std::numeric_limits<double>::infinity();
      d /= length;
      for (int v = 0; v < view.count; ++v) {
        const Vector3d& p = view.points[v];
        const double value = p.x() * d.x() + p.y() * d.y() + p.z() * d.z();
        equal = value > most ? 1 : equal + (value == most ? 1 : 0);
        if (value > most) {
          most = value;
          expected = v;
        }
      }
      tied += equal > 1 ? 1 : 0;
      if (scans) {
        ASSERT_EQ(found, expected);
      } else {
        ASSERT_GE(view.points[found].dot(d), most - 8 * kUnitRoundoff * view.extent);
      }
    }
  }
  EXPECT_GT(scanned, casesToAsk(50));
  EXPECT_GT(looked_up, casesToAsk(30));
  EXPECT_GT(climbed, casesToAsk(300));
  EXPECT_GT(tied, casesToAsk(500));
}

}  // namespace
}  // namespace leeway::collision
