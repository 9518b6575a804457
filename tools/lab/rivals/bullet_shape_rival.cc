#include "tools/lab/rivals/bullet_shape_rival.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

namespace leeway::tools::report {

using collision::Shape;
using collision::ShapeType;
using BulletShape = std::unique_ptr<btConvexShape>;

namespace {

BulletShape withoutMargin(BulletShape shape) {
  shape->setMargin(0);
  return shape;
}

}  // namespace

btVector3 toBullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

btTransform toBullet(const collision::Pose& pose) {
  const Eigen::Matrix3d& R = pose.rotation;
  const btMatrix3x3 rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                             R(2, 2));
  return btTransform(rotation, toBullet(pose.translation));
}

BulletShape makeBulletShape(const ReportShape& s) {
  const Shape& shape = s.shape;
  const double radius = shape.radius(), half = shape.halfLength();
  switch (shape.type()) {
    case ShapeType::kSphere:
      return std::make_unique<btSphereShape>(radius);
    case ShapeType::kCapsule:
      return std::make_unique<btCapsuleShapeZ>(radius, 2 * half);
    case ShapeType::kBox:
      return withoutMargin(std::make_unique<btBoxShape>(toBullet(shape.halfExtents())));
    case ShapeType::kCylinder:
      return withoutMargin(std::make_unique<btCylinderShapeZ>(btVector3(radius, radius, half)));
    case ShapeType::kCone:
      return withoutMargin(std::make_unique<btConeShapeZ>(radius, 2 * half));
    case ShapeType::kConvexHull: {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const Eigen::Vector3d& p : s.points) hull->addPoint(toBullet(p), false);
      hull->recalcLocalAabb();
      return withoutMargin(std::move(hull));
    }
    case ShapeType::kEllipsoid:  // unsupported by Bullet
    default:                     // half-spaces (nor convex half-spaces) and meshes
      break;
  }
  return nullptr;
}

}  // namespace leeway::tools::report
