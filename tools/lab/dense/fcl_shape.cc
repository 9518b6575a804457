#include "tools/lab/dense/fcl_shape.h"

#include <vector>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::dense {
namespace {

using collision::Shape;
using collision::ShapeType;
using Eigen::Isometry3d;

template <typename Triangles>
std::shared_ptr<FclSurface> bvhOf(std::span<const Eigen::Vector3d> vertices,
                                  const Triangles& triangles) {
  auto model = std::make_shared<FclSurface>();
  std::vector<fcl::Triangle> indices;
  for (const auto& t : triangles)
    indices.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                         static_cast<std::size_t>(t[2]));
  model->beginModel();
  model->addSubModel(std::vector<Eigen::Vector3d>(vertices.begin(), vertices.end()), indices);
  model->endModel();
  return model;
}

}  // namespace

Isometry3d isometry(const collision::Pose& X) {
  Isometry3d result = Isometry3d::Identity();
  result.linear() = X.rotation;
  result.translation() = X.translation;
  return result;
}

std::shared_ptr<FclSurface> fclMesh(std::span<const Eigen::Vector3d> vertices,
                                    std::span<const std::array<std::int32_t, 3>> triangles) {
  return bvhOf(vertices, triangles);
}

FclGeometry toFcl(const Shape& shape) {
  const double r = shape.radius(), length = 2 * shape.halfLength();
  const Eigen::Vector3d& e = shape.halfExtents();
  switch (shape.type()) {
    case ShapeType::kSphere:
      return std::make_shared<fcl::Sphered>(r);
    case ShapeType::kCapsule:
      return std::make_shared<fcl::Capsuled>(r, length);
    case ShapeType::kBox:
      return std::make_shared<fcl::Boxd>(2 * e.x(), 2 * e.y(), 2 * e.z());
    case ShapeType::kCylinder:
      return std::make_shared<fcl::Cylinderd>(r, length);
    case ShapeType::kCone:
      return std::make_shared<fcl::Coned>(r, length);
    case ShapeType::kEllipsoid:
      return std::make_shared<fcl::Ellipsoidd>(e.x(), e.y(), e.z());
    case ShapeType::kConvexHull:
      return bvhOf(shape.hull()->vertices(), shape.hull()->facets());
    case ShapeType::kMesh:
      return bvhOf(shape.mesh()->vertices(), shape.mesh()->triangles());
    case ShapeType::kDeformable:
      return bvhOf(shape.deformable()->vertices(), shape.deformable()->mesh().triangles());
    case ShapeType::kHalfSpace:
      break;
  }
  return std::make_shared<fcl::Halfspaced>(Eigen::Vector3d::UnitZ(), 0);
}

}  // namespace leeway::dense
