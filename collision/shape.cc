#include "leeway/collision/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "collision/default_tolerance.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/tolerances.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

namespace {

void requireSize(double value, const char* shape, const char* name) {
  // Written so that a NaN fails, too. Squares and cubes of larger sizes overflow: the fuzzer found
  // a half-space that an ellipsoid of 1e308 m was said to touch.
  if (value >= 0 && value <= kLargestCoordinate) return;
  std::ostringstream message;
  message.precision(17);
  message << shape << ": " << name << " is " << value
          << ", but must be a number that is not negative and at most 1e60 [m]";
  throw InvalidShape(message.str());
}

void requireSizes(const Eigen::Vector3d& value, const char* shape, const char* const names[3]) {
  for (int i = 0; i < 3; ++i) requireSize(value[i], shape, names[i]);
}

// hypot never overflows before its result does.
double outwardNorm(double x, double y, double z) { return std::hypot(x, y, z) * kOutwards; }

struct Sphere {
  Eigen::Vector3d center;
  double radius;
  double extent;
};

Sphere sphereAround(std::span<const Eigen::Vector3d> points, double excess) {
  Eigen::Vector3d lowest = points[0], highest = points[0];
  for (const Eigen::Vector3d& p : points) {
    lowest = lowest.cwiseMin(p);
    highest = highest.cwiseMax(p);
  }
  Sphere sphere{0.5 * lowest + 0.5 * highest, 0, 0};
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = p - sphere.center;
    sphere.radius = std::max(sphere.radius, std::hypot(d.x(), d.y(), d.z()));
    sphere.extent = std::max(sphere.extent, std::hypot(p.x(), p.y(), p.z()));
  }
  // The differences are rounded in proportion to the coordinates, not to the radius.
  sphere.radius = (sphere.radius + excess) * kOutwards + sphere.extent * 0x1p-51;
  sphere.extent = (sphere.extent + excess) * kOutwards;
  return sphere;
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
  Shape shape;
  shape.type_ = ShapeType::kSphere;
  shape.radius_ = radius;
  shape.setReach(radius, radius);
  return shape;
}

Shape Shape::capsule(double radius, double half_length) {
  requireSize(radius, "capsule", "radius");
  requireSize(half_length, "capsule", "half length");
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
  requireSize(radius, "cylinder", "radius");
  requireSize(half_length, "cylinder", "half length");
  Shape shape;
  shape.type_ = ShapeType::kCylinder;
  shape.radius_ = radius;
  shape.half_length_ = half_length;
  const double reach = outwardNorm(radius, half_length, 0);
  shape.setReach(reach, reach);
  return shape;
}

Shape Shape::cone(double radius, double half_length) {
  requireSize(radius, "cone", "radius");
  requireSize(half_length, "cone", "half length");
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
  const Sphere sphere = sphereAround(hull->vertices(), hull->excess());
  Shape shape;
  shape.type_ = ShapeType::kConvexHull;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, sphere.extent);
  shape.hull_ = std::move(hull);
  return shape;
}

Shape Shape::mesh(std::shared_ptr<const TriangleMesh> mesh) {
  if (!mesh || mesh->vertices().empty()) {
    throw InvalidShape("mesh: it has no triangles; at least one is needed");
  }
  const Sphere sphere = sphereAround(mesh->vertices(), 0);
  Shape shape;
  shape.type_ = ShapeType::kMesh;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, sphere.extent);
  shape.mesh_ = std::move(mesh);
  return shape;
}

Shape Shape::deformable(std::shared_ptr<const DeformableSnapshot> snapshot) {
  if (!snapshot) throw InvalidShape("deformable: there is no snapshot");
  const Eigen::Vector3d corners[2] = {snapshot->low(), snapshot->high()};
  const Eigen::Vector3d farthest = corners[0].cwiseAbs().cwiseMax(corners[1].cwiseAbs());
  const Sphere sphere = sphereAround(corners, 0);
  Shape shape;
  shape.type_ = ShapeType::kDeformable;
  shape.bounding_center_ = sphere.center;
  shape.setReach(sphere.radius, outwardNorm(farthest.x(), farthest.y(), farthest.z()));
  shape.deformable_ = std::move(snapshot);
  return shape;
}

}  // namespace leeway::collision
