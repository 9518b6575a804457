#include "leeway/collision/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "leeway/collision/convex_hull.h"

namespace leeway::collision {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

std::string messageOf(const std::function<void()>& make) {
  try {
    make();
  } catch (const InvalidShape& error) {
    return error.what();
  }
  return "no error";
}

TEST(Shape, RefusesSizesThatAreNoSizes) {
  for (const double bad : {-1e-300, -1.0, kNan, kInfinity, -kInfinity}) {
    EXPECT_THROW(Shape::sphere(bad), InvalidShape) << bad;
    EXPECT_THROW(Shape::capsule(bad, 1), InvalidShape) << bad;
    EXPECT_THROW(Shape::capsule(1, bad), InvalidShape) << bad;
    EXPECT_THROW(Shape::cylinder(bad, 1), InvalidShape) << bad;
    EXPECT_THROW(Shape::cylinder(1, bad), InvalidShape) << bad;
    EXPECT_THROW(Shape::cone(bad, 1), InvalidShape) << bad;
    EXPECT_THROW(Shape::cone(1, bad), InvalidShape) << bad;
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector3d sizes(1, 2, 3);
      sizes[i] = bad;
      EXPECT_THROW(Shape::box(sizes), InvalidShape) << bad << " in " << i;
      EXPECT_THROW(Shape::ellipsoid(sizes), InvalidShape) << bad << " in " << i;
    }
  }
}

TEST(Shape, SaysWhichSizeAndWhatWouldBeAccepted) {
  const std::string message = messageOf([] { Shape::box({1, -0.25, 1}); });
  EXPECT_NE(message.find("box"), std::string::npos) << message;
  EXPECT_NE(message.find("half extent in y"), std::string::npos) << message;
  EXPECT_NE(message.find("-0.25"), std::string::npos) << message;
  EXPECT_NE(message.find("not negative"), std::string::npos) << message;
}

TEST(Shape, RefusesHullsAndMeshesWithoutPoints) {
  EXPECT_THROW(Shape::convexHull(std::vector<Eigen::Vector3d>{}), InvalidShape);
  EXPECT_THROW(Shape::convexHull(std::shared_ptr<const ConvexHull>{}), InvalidShape);
  EXPECT_THROW(Shape::mesh({}), InvalidShape);
}

TEST(Shape, TakesZeroSizes) {
  EXPECT_EQ(Shape::sphere(0).boundingRadius(), 0);
  EXPECT_EQ(Shape::ellipsoid({0, 0, 0}).extent(), 0);
  EXPECT_EQ(Shape::box({0, 0, 0}).boundingRadius(), 0);
}

TEST(Shape, BoundingSphereAndExtentHoldTheShape) {
  const double diagonal = std::sqrt(14.0);
  EXPECT_GE(Shape::box({1, 2, 3}).boundingRadius(), std::nextafter(diagonal, 4.0));
  EXPECT_NEAR(Shape::box({1, 2, 3}).boundingRadius(), diagonal, 1e-14);
  EXPECT_GE(Shape::capsule(0.1, 0.2).extent(), 0.1L + 0.2L);
  EXPECT_NEAR(Shape::cylinder(3, 4).boundingRadius(), 5, 1e-14);
  EXPECT_NEAR(Shape::cone(3, 4).extent(), 5, 1e-14);
  EXPECT_EQ(Shape::ellipsoid({1, 3, 2}).extent(), 3);
  EXPECT_EQ(Shape::halfSpace().boundingRadius(), kInfinity);

  const std::vector<Eigen::Vector3d> points = {{10, 0, 0}, {12, 0, 0}, {11, 1, 0}, {11, 0, 1}};
  const Shape hull = Shape::convexHull(points);
  for (const Eigen::Vector3d& p : points) {
    EXPECT_LE((p - hull.boundingCenter()).norm(), hull.boundingRadius());
    EXPECT_LE(p.norm(), hull.extent());
  }
  EXPECT_LT(hull.boundingRadius(), 1.5);
  EXPECT_LT(hull.extent(), 12.001);
}

TEST(Shape, HasAWordForEveryType) {
  EXPECT_STREQ(toString(ShapeType::kHalfSpace), "half-space");
  EXPECT_STREQ(toString(ShapeType::kConvexHull), "hull");
  EXPECT_STREQ(toString(Shape::sphere(1).type()), "sphere");
}

}  // namespace
}  // namespace leeway::collision
