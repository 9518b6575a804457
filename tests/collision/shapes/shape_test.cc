#include "leeway/collision/shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

std::string messageOf(const std::function<void()>& make) {
  try {
    make();
  } catch (const InvalidShape& error) {
    return error.what();
  }
  return "no error";
}

TEST(Shape, RefusesSizesThatAreNoSizes) {
  for (const double bad : {-1e-300, -1.0, kNaN, kInfinity, -kInfinity}) {
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

// Makes every kind of shape that has sizes, with this largest one and the others thin or 0.
std::vector<std::function<void()>> shapesOf(double size) {
  const double thin = std::min(size, 1e-200);
  const std::vector<Eigen::Vector3d> corners = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
  const std::vector<TriangleMesh::Triangle> triangle = {{0, 1, 2}};
  return {[=] { Shape::sphere(size); },
          [=] { Shape::capsule(size, 0); },
          [=] { Shape::capsule(thin, size); },
          [=] {
            Shape::box({0, size, thin});
          },
          [=] { Shape::cylinder(size, 0); },
          [=] { Shape::cylinder(0, size); },
          [=] { Shape::cone(size, thin); },
          [=] { Shape::cone(0, size); },
          [=] {
            Shape::ellipsoid({thin, 0, size});
          },
          [=] { Shape::convexHull(corners); },
          [=] { ConvexHull::compute(corners); },
          [=] { TriangleMesh::make(corners, triangle); },
          [=] { DeformableMesh::make(corners, triangle); }};
}

TEST(Shape, TakesSizesFromTheSmallestToTheLargest) {
  for (const double size : {0.0, 1e-9, 1e9}) {
    for (const auto& make : shapesOf(size)) EXPECT_NO_THROW(make()) << size;
  }
  for (const double size :
       {5e-324, 1e-300, std::nextafter(1e-9, 0), std::nextafter(1e9, 2e9), 1e154}) {
    for (const auto& make : shapesOf(size)) EXPECT_THROW(make(), InvalidShape) << size;
  }
}

TEST(Shape, SaysWhatSizesAreAccepted) {
  EXPECT_EQ(messageOf([] { Shape::sphere(1e-12); }),
            "sphere: radius is 9.9999999999999998e-13; the largest size must be 0 or from 1e-09 to "
            "1e+09 [m]");
  EXPECT_EQ(messageOf([] {
              Shape::ellipsoid({0, 2e-10, 1e-10});
            }),
            "ellipsoid: semi-axis in y is 2.0000000000000001e-10; the largest size must be 0 or "
            "from 1e-09 to 1e+09 [m]");
  EXPECT_EQ(messageOf([] { Shape::cylinder(1, 2e9); }),
            "cylinder: half length is 2000000000, but must be a number that is not negative and at "
            "most 1e+09 [m]");
  const std::vector<Eigen::Vector3d> far = {{0, 0, 0}, {0, -1e18, 0}},
                                     near = {{0, 0, 0}, {0, 0, 1e-18}};
  EXPECT_EQ(messageOf([&] { Shape::convexHull(far); }),
            "convex hull: point 1 has the coordinate -1e+18; finite numbers up to 1e+09 are "
            "accepted [m]");
  EXPECT_EQ(messageOf([&] { Shape::convexHull(near); }),
            "convex hull: the longest side of its box is 1.0000000000000001e-18; the largest size "
            "must be 0 or from 1e-09 to 1e+09 [m]");
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
