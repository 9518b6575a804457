#include "tools/lab/rivals/fcl_shape_rival.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>

#include <array>
#include <map>

#include "leeway/collision/convex_hull.h"

namespace leeway::tools::report {

using collision::Shape;
using collision::ShapeType;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

namespace {

/// Uses the points as given; facets refer to the first point equal to each vertex. A set without
/// facets becomes one polygon, because FCL reads faces only above 32 vertices.
Geometry makeConvex(const ReportShape& s) {
  const auto vertices = std::make_shared<std::vector<fcl::Vector3d>>(s.points);
  const auto faces = std::make_shared<std::vector<int>>();
  std::map<std::array<double, 3>, int> first;
  for (std::size_t i = 0; i < s.points.size(); ++i)
    first.insert({{s.points[i].x(), s.points[i].y(), s.points[i].z()}, static_cast<int>(i)});
  const auto index = [&](std::int32_t i) {
    const Eigen::Vector3d& v = s.shape.hull()->vertices()[static_cast<std::size_t>(i)];
    return first.at({v.x(), v.y(), v.z()});
  };
  int count = 0;
  for (const auto& facet : s.shape.hull()->facets()) {
    faces->insert(faces->end(), {3, index(facet[0]), index(facet[1]), index(facet[2])});
    ++count;
  }
  if (count == 0) {
    faces->push_back(static_cast<int>(s.points.size()));
    for (std::size_t i = 0; i < s.points.size(); ++i) faces->push_back(static_cast<int>(i));
    count = 1;
  }
  return std::make_shared<fcl::Convexd>(vertices, count, faces);
}

}  // namespace

Geometry makeFclShape(const ReportShape& s) {
  const Shape& shape = s.shape;
  const double radius = shape.radius(), length = 2 * shape.halfLength();
  switch (shape.type()) {
    case ShapeType::kSphere:
      return std::make_shared<fcl::Sphered>(radius);
    case ShapeType::kCapsule:
      return std::make_shared<fcl::Capsuled>(radius, length);
    case ShapeType::kBox:
      return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * shape.halfExtents()));
    case ShapeType::kCylinder:
      return std::make_shared<fcl::Cylinderd>(radius, length);
    case ShapeType::kCone:
      return std::make_shared<fcl::Coned>(radius, length);
    case ShapeType::kEllipsoid:
      return std::make_shared<fcl::Ellipsoidd>(fcl::Vector3d(shape.halfExtents()));
    case ShapeType::kConvexHull:
      return makeConvex(s);
    default:  // half-spaces (contacts only, no distances) and meshes
      break;
  }
  return nullptr;
}

fcl::Transform3d toFcl(const collision::Pose& pose) {
  fcl::Transform3d X = fcl::Transform3d::Identity();
  X.linear() = pose.rotation;
  X.translation() = pose.translation;
  return X;
}

std::vector<fcl::Triangle> toFcl(std::span<const std::array<std::int32_t, 3>> triangles) {
  std::vector<fcl::Triangle> result;
  for (const auto& t : triangles)
    result.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                        static_cast<std::size_t>(t[2]));
  return result;
}

}  // namespace leeway::tools::report
