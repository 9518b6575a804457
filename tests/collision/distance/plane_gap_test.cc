#include "collision/distance/plane_gap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <vector>

#include "leeway/collision/distance.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using testing::append;
using testing::boxSoup;
using testing::Random;
using testing::TriangleSoup;

Shape randomConvex(Random& random) {
  const double r = random.uniform(0.02, 0.2), h = random.uniform(0.02, 0.2);
  switch (random.below(6)) {
    case 0:
      return Shape::box({r, h, 0.1});
    case 1:
      return Shape::sphere(r);
    case 2:
      return Shape::cylinder(r, h);
    case 3:
      return Shape::capsule(r, h);
    case 4:
      return Shape::ellipsoid({r, h, 0.1});
    default:
      return Shape::halfSpace();
  }
}

ThreePoses motionOf(Random& random) {
  const Pose from = random.pose(0.7),
             step = {Eigen::AngleAxisd(random.uniform(0, 0.2), Eigen::Vector3d::UnitX())
                         .toRotationMatrix(),
                     0.1 * random.vector()};
  return {from, from * step, from * step * step};
}

TEST(PlaneGaps, AreNoMoreThanDistances) {
  Random random(11);
  Scratch scratch;
  int apart = 0, telling = 0;
  for (int n = 0; n < 3000; ++n) {
    const Shape a = randomConvex(random), b = randomConvex(random);
    const ThreePoses X_BA = motionOf(random);
    const Pose identity;
    const DistanceResult middle = distance(a, X_BA[1], b, identity, {}, scratch);
    const ThreeGaps gaps = planeGaps(a, X_BA, b, -middle.normal);
    if (a.type() == ShapeType::kHalfSpace) {
      EXPECT_EQ(gaps[1], -std::numeric_limits<double>::infinity());
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LE(gaps[k], distance(a, X_BA[k], b, identity, {}, scratch).distance.upper) << n;
    if (!(middle.distance.lower > 0)) continue;
    ++apart;
    telling += gaps[1] > middle.distance.lower - 1e-6 ? 1 : 0;
  }
  std::printf("apart %d, telling %d\n", apart, telling);
  EXPECT_GT(apart, 500);
  EXPECT_GT(telling, apart * 9 / 10);
}

TEST(PlaneGaps, OfSurfacesFollowMeshesThatAreFarFromConvex) {
  Random random(12);
  Scratch scratch;
  int apart = 0, telling = 0, hulls = 0;
  const int asked = casesToAsk(1500);
  for (int n = 0; n < asked; ++n) {
    // Bars around a hollow: the hull is far nearer than they are.
    TriangleSoup soup;
    append(soup, boxSoup({0.02, 0.2, 0.02}), {Eigen::Matrix3d::Identity(), {0.2, 0, 0}});
    append(soup, boxSoup({0.02, 0.2, 0.02}), {Eigen::Matrix3d::Identity(), {-0.2, 0, 0}});
    append(soup, boxSoup({0.2, 0.02, 0.02}), {Eigen::Matrix3d::Identity(), {0, 0.2, 0}});
    const Shape mesh = Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles));
    const Shape other = n % 5 == 4 ? mesh : randomConvex(random);
    const bool is_a = n % 2 == 0 || other.type() == ShapeType::kHalfSpace;
    const Shape &a = is_a ? mesh : other, &b = is_a ? other : mesh;
    const ThreePoses X_BA = motionOf(random);
    const Pose identity;
    const DistanceResult middle = distance(a, X_BA[1], b, identity, {}, scratch);
    if (!(middle.distance.lower > 1e-3)) continue;
    ++apart;
    ThreeGaps wanted;
    wanted.fill(middle.distance.lower - 1e-3);
    int nodes = 2000;
    const ThreeGaps gaps = surfaceGaps(a, X_BA, b, wanted, nodes, scratch);
    for (std::size_t k = 0; k < 3; ++k) {
      const Interval truth = distance(a, X_BA[k], b, identity, {}, scratch).distance;
      if (truth.upper > 0) {
        EXPECT_LE(gaps[k], truth.upper) << n;
      }
    }
    telling += gaps[1] >= wanted[1] ? 1 : 0;
    hulls += planeGaps(a, X_BA, b, -middle.normal)[1] >= wanted[1] ? 1 : 0;
    int few = 3;
    const ThreeGaps rough = surfaceGaps(a, X_BA, b, wanted, few, scratch);
    EXPECT_LE(rough[1], middle.distance.upper) << n;
  }
  std::printf("apart %d, telling %d, by hulls %d\n", apart, telling, hulls);
  EXPECT_GT(apart, asked / 5);
  EXPECT_GT(telling, apart * 3 / 4);
  EXPECT_GT(telling, hulls + apart / 10);
}

}  // namespace
}  // namespace leeway::collision
