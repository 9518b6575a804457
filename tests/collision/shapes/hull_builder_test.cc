#include "collision/shapes/hull_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "collision/base/exact_predicates.h"
#include "collision/shapes/hull_distance.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// For an interrupted hull, exact signs separate inside from outside, and the largest outside
// distance equals that over all points.
TEST(HullBuilder, StoppedHullsTellWhatIsOutside) {
  Random random(31);
  int outside = 0;
  for (int round = 0; round < (kSanitized ? 12 : 60); ++round) {
    const double size = std::array{1e-6, 1.0, 1e3}[static_cast<std::size_t>(round % 3)];
    const Pose X = random.pose(10 * size);
    std::vector<Vector3d> points;
    for (int i = 0; i < 150; ++i) {
      const double angle = 0.1 * random.below(60);
      const std::array<Vector3d, 4> kinds = {
          random.vector(), random.direction(), Vector3d(random.below(4), random.below(4), 0.1),
          Vector3d(std::cos(angle), std::sin(angle), random.below(3))};
      points.push_back(X * (size * kinds[static_cast<std::size_t>(round / 3 % 4)]));
    }
    const HullBuilder hull(points, 4 + random.below(40));
    if (hull.dimension() < 3) continue;
    ASSERT_EQ(hull.outsideOf().size(), hull.outside().size());
    const auto side = [&](std::int32_t facet, std::int32_t p) {
      const auto& f = hull.facets()[static_cast<std::size_t>(facet)];
      const auto at = [&](std::int32_t i) { return points[static_cast<std::size_t>(i)]; };
      return orientation(at(f[0]), at(f[1]), at(f[2]), at(p));
    };
    std::vector<bool> is_outside(points.size(), false);
    double largest = 0;
    for (std::size_t i = 0; i < hull.outside().size(); ++i) {
      const std::int32_t p = hull.outside()[i];
      is_outside[static_cast<std::size_t>(p)] = true;
      EXPECT_EQ(side(hull.outsideOf()[i], p), 1);
      largest =
          std::max(largest, distanceFromHull(points[static_cast<std::size_t>(p)], points, hull));
      ++outside;
    }
    for (std::size_t p = 0; p < points.size(); ++p) {
      for (std::size_t f = 0; f < hull.facets().size() && !is_outside[p]; ++f) {
        EXPECT_LE(side(static_cast<std::int32_t>(f), static_cast<std::int32_t>(p)), 0);
      }
    }
    EXPECT_EQ(largestDistanceFromHull(points, hull), largest);
  }
  EXPECT_GT(outside, 200);
}

}  // namespace
}  // namespace leeway::collision
