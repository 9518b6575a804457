// Obstacles of a LaneSweep: cores in single precision.

#include <Eigen/Geometry>
#include <algorithm>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/shapes/hull_of_part.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

LaneSweep::Impl::Obstacle LaneSweep::Impl::obstacleOf(const Shape& shape, const Pose& X_WG) {
  Obstacle o;
  Eigen::Vector3d center_G = Eigen::Vector3d::Zero(), half = Eigen::Vector3d::Zero();
  double radius = 0;
  o.exact = true;
  switch (shape.type()) {
    case ShapeType::kSphere:
      radius = shape.radius();
      break;
    case ShapeType::kCapsule:
      half.z() = shape.halfLength();
      radius = shape.radius();
      break;
    case ShapeType::kBox:
      half = shape.halfExtents();
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      o.kind = Kind::kCylinder;
      o.exact = shape.type() == ShapeType::kCylinder;
      half = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kHalfSpace:
      o.kind = Kind::kHalfSpace;
      break;
    case ShapeType::kEllipsoid:
      o.exact = false;
      half = shape.halfExtents();
      break;
    case ShapeType::kConvexHull:
    case ShapeType::kMesh:
    case ShapeType::kDeformable: {
      o.exact = false;
      const AxisBox box = boxOf(shape);
      center_G = box.center;
      half = box.half;
      break;
    }
  }
  const Eigen::Matrix3d rotation_GW = X_WG.rotation.transpose();
  const Eigen::Vector3d center = X_WG * center_G;
  o.aligned = rotation_GW.isIdentity(0);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      o.rotation[3 * row + column] = static_cast<float>(rotation_GW(row, column));
  setSingle(center, o.center);
  // Rounded to nearest: what that changes is relative to `scale`.
  for (int k = 0; k < 3; ++k) o.half[k] = static_cast<float>(half[k]);
  o.radius = static_cast<float>(radius);
  o.scale = center.lpNorm<1>() + half.lpNorm<1>() + radius;
  const Eigen::Vector3d extent =
      rotation_GW.transpose().cwiseAbs() * half + Eigen::Vector3d::Constant(radius);
  o.low = center - extent;
  o.high = center + extent;
  if (o.kind == Kind::kHalfSpace) {
    o.low.setConstant(-static_cast<double>(kFar));
    o.high.setConstant(static_cast<double>(kFar));
  }
  o.shape = shape;
  o.X_WG = X_WG;
  if (shape.isConvex()) {
    o.view = viewOf(shape);
  } else if (shape.type() == ShapeType::kMesh) {
    o.view = shape.mesh()->tree().hullView();
  }
  o.has_view = shape.type() != ShapeType::kDeformable && shape.type() != ShapeType::kHalfSpace;
  return o;
}

ObstacleBoxes::Box LaneSweep::boxAround(const Shape& shape, const Pose& X_WG) {
  const Impl::Obstacle o = Impl::obstacleOf(shape, X_WG);
  const double rounding = kTransferRounding * (X_WG.translation.lpNorm<1>() + o.scale);
  ObstacleBoxes::Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::max(floatBelow(o.low[k] - rounding), -kFar);
    box.high[k] = std::min(floatAbove(o.high[k] + rounding), kFar);
  }
  return box;
}

// A part of a mesh: its hull, grown by how far the part stands out of it.
LaneSweep::Impl::Obstacle LaneSweep::Impl::partOf(const CoverPart& part, const Pose& X_WG) {
  const bool fine = !part.points.fine.empty();
  const std::shared_ptr<const ConvexHull> hull =
      hullOfPart(fine ? part.points.fine : part.points.points);
  const double radius =
      (fine ? part.points.fine_radius : part.points.radius) * (1 + kRelativeRounding);
  Obstacle o = obstacleOf(Shape::convexHull(hull), X_WG);
  for (float& half : o.half) half = floatAbove(static_cast<double>(half) + radius);
  o.view.excess += radius;
  return o;
}

}  // namespace leeway::collision
