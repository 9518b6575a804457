#include "tools/lab/fcl/fcl_shape.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::lab {

using collision::Shape;
using collision::ShapeType;
using Eigen::Isometry3d;

Isometry3d isometry(const collision::Pose& X) {
  Isometry3d result = Isometry3d::Identity();
  result.linear() = X.rotation;
  result.translation() = X.translation;
  return result;
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
      return fclMesh(shape.hull()->vertices(), shape.hull()->facets());
    case ShapeType::kMesh:
      return fclMesh(shape.mesh()->vertices(), shape.mesh()->triangles());
    case ShapeType::kDeformable:
      return fclMesh(shape.deformable()->vertices(), shape.deformable()->mesh().triangles());
    case ShapeType::kHalfSpace:
      break;
  }
  return std::make_shared<fcl::Halfspaced>(Eigen::Vector3d::UnitZ(), 0);
}

}  // namespace leeway::lab
