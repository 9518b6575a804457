#include "collision/mesh/obb_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/mesh_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

FittedBox fitted(const std::vector<Vector3d>& corners) {
  ObbFit fit;
  fit.start(corners.size() / 3);
  for (const Vector3d& corner : corners) fit.add(corner);
  return fit.fit();
}

/// Against plain projections: the box contains all corners, touches them, and is not larger than
/// the one along the coordinate axes.
TEST(ObbFit, HoldsAndTouchesTheCorners) {
  Random random(61);
  for (int i = 0; i < 500; ++i) {
    const Pose X = random.pose(3);
    const Vector3d size(1, std::pow(10, random.uniform(-3, 0)),
                        std::pow(10, random.uniform(-3, 0)));
    std::vector<Vector3d> corners;
    const int count = 3 * (1 + random.below(30));
    for (int k = 0; k < count; ++k) corners.push_back(X * size.cwiseProduct(random.vector()));
    const FittedBox box = fitted(corners);
    EXPECT_LT((box.axes.transpose() * box.axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(box.axes.determinant(), 1, 1e-12);
    const double infinity = std::numeric_limits<double>::infinity();
    Vector3d low = Vector3d::Constant(infinity), high = -low, reach = Vector3d::Zero();
    for (const Vector3d& corner : corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
      reach = reach.cwiseMax((box.axes.transpose() * (corner - box.center)).cwiseAbs());
    }
    EXPECT_LT((reach - box.half).norm(), 1e-12);
    const Vector3d h = (high - low) / 2;
    EXPECT_LE(box.halfArea(), h.x() * h.y() + h.y() * h.z() + h.z() * h.x() + 1e-12);
  }
}

/// A turned box's own corners give that box.
TEST(ObbFit, FindsATurnedBox) {
  Random random(62);
  const Vector3d half(0.5, 0.3, 0.1);
  const TriangleSoup soup = boxSoup(half);
  for (int i = 0; i < 50; ++i) {
    const Pose X = random.pose(2);
    std::vector<Vector3d> corners;
    for (const auto& t : soup.triangles)
      for (const std::int32_t v : t) corners.push_back(X * soup.vertices[std::size_t(v)]);
    const double area = half.x() * half.y() + half.y() * half.z() + half.z() * half.x();
    EXPECT_NEAR(fitted(corners).halfArea(), area, 1e-9);
  }
}

}  // namespace
}  // namespace leeway::collision
