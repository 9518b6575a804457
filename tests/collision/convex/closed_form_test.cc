#include "collision/convex/pairs/closed_form.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "collision/convex/gjk/support.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

const std::set<Core> kWithPointDistance = {Core::kPoint,    Core::kSegment, Core::kBox,
                                           Core::kCylinder, Core::kCone,    Core::kHalfSpace};

/// Only the listed cores have a closed form.
TEST(PointDistance, IsOnlyForCoresThatHaveOne) {
  for (int i = 0; i < 256; ++i) {
    const auto core = static_cast<Core>(i);
    EXPECT_EQ(hasPointDistance(core), kWithPointDistance.contains(core)) << i;
    ConvexView view;
    view.core = core;
    view.size = {1, 1, 1};
    EXPECT_EQ(std::isnan(pointDistance(view, {3, 2, 1}).distance), !hasPointDistance(core)) << i;
  }
}

/// The distance of the point from the plane that supports the core along `normal`, and the nearest
/// point in that plane. Both hold only at the nearest point.
TEST(PointDistance, IsThatOfTheSupportingPlane) {
  Random random(20261124);
  int inside = 0, cases = 0;
  for (const Core core : kWithPointDistance) {
    if (core == Core::kHalfSpace) continue;  // has no support
    for (int i = 0; i < 500; ++i, ++cases) {
      ConvexView view;
      view.core = core;
      view.size = {random.uniform(0.1, 1), 0, random.uniform(0.1, 1)};
      view.size.y() = core == Core::kBox ? random.uniform(0.1, 1) : view.size.x();
      view.extent = view.size.norm();
      Vector3d p = random.uniform(0, 3) * random.direction();
      if (random.chance(0.3)) p = 0.2 * p.cwiseProduct(view.size);
      const PointDistance d = pointDistance(view, p);
      int hint = 0;
      const double reach = d.normal.dot(farthest(view, d.normal, hint));
      EXPECT_NEAR(d.distance, d.normal.dot(p) - reach, 1e-14) << i;
      EXPECT_NEAR(d.normal.dot(d.nearest), reach, 1e-14) << i;
      EXPECT_NEAR((p - d.nearest).norm(), std::abs(d.distance), 1e-14) << i;
      inside += d.distance < 0;
    }
  }
  EXPECT_GT(inside, cases / 10);
}

}  // namespace
}  // namespace leeway::collision
