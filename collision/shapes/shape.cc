#include "leeway/collision/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "collision/base/tolerances.h"
#include "collision/shapes/bounding_sphere.h"
#include "collision/shapes/default_tolerance.h"
#include "collision/shapes/size_limits.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

namespace {

void requireSize(double value, const char* shape, const char* name) {
  // This is also false for NaN.
  if (value >= 0 && value <= kLargestSize) return;
  std::ostringstream message;
  message.precision(17);
  message << shape << ": " << name << " is " << value
          << ", but must be a number that is not negative and at most ";
  message.precision(6);
  message << kLargestSize << " [m]";
  throw InvalidShape(message.str());
}

void requireExtent(double largest, const char* shape, const char* name) {
  collision::requireExtent(largest, (std::string(shape) + ": " + name).c_str());
}

void requireSizes(const Eigen::Vector3d& value, const char* shape, const char* const names[3]) {
  for (int i = 0; i < 3; ++i) requireSize(value[i], shape, names[i]);
  Eigen::Index largest = 0;
  const double size = value.maxCoeff(&largest);
  requireExtent(size, shape, names[largest]);
}

// Shapes with a radius and a half length.
void requireSizes(double radius, double half_length, const char* shape) {
  requireSize(radius, shape, "radius");
  requireSize(half_length, shape, "half length");
  if (radius > half_length) {
    requireExtent(radius, shape, "radius");
  } else {
    requireExtent(half_length, shape, "half length");
  }
}

}  // namespace

const char* toString(ShapeType type) {
  switch (type) {
    case ShapeType::kSphere:
      return "sphere";
    case ShapeType::kCapsule:
      return "capsule";
    case ShapeType::kBox:
      return "box";
    case ShapeType::kCylinder:
      return "cylinder";
    case ShapeType::kCone:
      return "cone";
    case ShapeType::kEllipsoid:
      return "ellipsoid";
    case ShapeType::kHalfSpace:
      return "half-space";
    case ShapeType::kConvexHull:
      return "hull";
    case ShapeType::kMesh:
      return "mesh";
    case ShapeType::kDeformable:
      return "deformable";
  }
  return "unknown";
}

void Shape::setReach(double bounding_radius, double extent) {
  bounding_radius_ = bounding_radius;
  extent_ = extent;
  default_tolerance_ = toleranceOf(bounding_radius, extent);
}

Shape Shape::sphere(double radius) {
  requireSize(radius, "sphere", "radius");
  requireExtent(radius, "sphere", "radius");
  Shape shape;
  shape.type_ = ShapeType::kSphere;
  shape.radius_ = radius;
  shape.setReach(radius, radius);
  return shape;
}

Shape Shape::capsule(double radius, double half_length) {
  requireSizes(radius, half_length, "capsule");
  Shape shape;
  shape.type_ = ShapeType::kCapsule;
  shape.radius_ = radius;
  shape.half_length_ = half_length;
  const double reach = (radius + half_length) * kOutwards;
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::box(const Eigen::Vector3d& half_extents) {
  static const char* const kNames[3] = {"half extent in x", "half extent in y", "half extent in z"};
  requireSizes(half_extents, "box", kNames);
  Shape shape;
  shape.type_ = ShapeType::kBox;
  shape.half_extents_ = half_extents;
  const double reach = outwardNorm(half_extents.x(), half_extents.y(), half_extents.z());
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::cylinder(double radius, double half_length) {
  requireSizes(radius, half_length, "cylinder");
  Shape shape;
  shape.type_ = ShapeType::kCylinder;
  shape.radius_ = radius;
  shape.half_length_ = half_length;
  const double reach = outwardNorm(radius, half_length, 0);
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::cone(double radius, double half_length) {
  requireSizes(radius, half_length, "cone");
  Shape shape;
  shape.type_ = ShapeType::kCone;
  shape.radius_ = radius;
  shape.half_length_ = half_length;
  const double reach = outwardNorm(radius, half_length, 0);
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::ellipsoid(const Eigen::Vector3d& semi_axes) {
  static const char* const kNames[3] = {"semi-axis in x", "semi-axis in y", "semi-axis in z"};
  requireSizes(semi_axes, "ellipsoid", kNames);
  Shape shape;
  shape.type_ = ShapeType::kEllipsoid;
  shape.half_extents_ = semi_axes;
  const double reach = semi_axes.maxCoeff();
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::halfSpace() {
  Shape shape;
  shape.type_ = ShapeType::kHalfSpace;
  const double reach = std::numeric_limits<double>::infinity();
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::convexHull(std::span<const Eigen::Vector3d> vertices) {
  return convexHull(ConvexHull::compute(vertices));
}

Shape Shape::convexHull(std::shared_ptr<const ConvexHull> hull) {
  if (!hull || hull->vertices().empty()) {
    throw InvalidShape("hull: it has no points; at least one is needed");
  }
  const BoundingSphere sphere = sphereAround(hull->vertices());
  Shape shape;
  shape.type_ = ShapeType::kConvexHull;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, sphere.extent);
  shape.hull_ = std::move(hull);
  return shape;
}

}  // namespace leeway::collision
