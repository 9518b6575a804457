// Obstacles of a LaneSweep: cores in single precision.

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/lane_sweep_impl.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/shapes/hull_of_part.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

namespace {

/// The core of a shape in its own frame, relative to its centre.
struct ShapeCore {
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), half = Eigen::Vector3d::Zero();
  double radius = 0;
};

ShapeCore coreOf(const Shape& shape) {
  ShapeCore core;
  switch (shape.type()) {
    case ShapeType::kSphere:
      core.radius = shape.radius();
      break;
    case ShapeType::kCapsule:
      core.half.z() = shape.halfLength();
      core.radius = shape.radius();
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      core.half = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kHalfSpace:
      break;
    case ShapeType::kBox:
    case ShapeType::kEllipsoid:
      core.half = shape.halfExtents();
      break;
    case ShapeType::kConvexHull:
    case ShapeType::kMesh:
    case ShapeType::kDeformable: {
      const AxisBox box = boxOf(shape);
      core.center = box.center;
      core.half = box.half;
      break;
    }
  }
  return core;
}

/// Whether the shape is identical to its core.
bool isCore(ShapeType type) {
  return type == ShapeType::kSphere || type == ShapeType::kCapsule || type == ShapeType::kBox ||
         type == ShapeType::kCylinder || type == ShapeType::kHalfSpace;
}

}  // namespace

LaneSweep::Impl::Obstacle LaneSweep::Impl::obstacleOf(const Shape& shape, const Pose& X_WG) {
  const ShapeType type = shape.type();
  const ShapeCore core = coreOf(shape);
  Obstacle o;
  o.exact = isCore(type);
  if (type == ShapeType::kCylinder || type == ShapeType::kCone) o.kind = Kind::kCylinder;
  if (type == ShapeType::kHalfSpace) o.kind = Kind::kHalfSpace;
  const Eigen::Matrix3d rotation_GW = X_WG.rotation.transpose();
  const Eigen::Vector3d center = X_WG * core.center;
  o.aligned = rotation_GW == Eigen::Matrix3d::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      o.rotation[3 * row + column] = static_cast<float>(rotation_GW(row, column));
  setSingle(center, o.center);
  // Rounded to nearest; the rounding error is relative to `scale`.
  for (int k = 0; k < 3; ++k) o.half[k] = static_cast<float>(core.half[k]);
  o.radius = static_cast<float>(core.radius);
  o.scale = center.lpNorm<1>() + core.half.lpNorm<1>() + core.radius;
  o.deforms = type == ShapeType::kDeformable;
  o.has_view = !o.deforms && type != ShapeType::kHalfSpace;
  return o;
}

LaneSweep::Impl::Exact LaneSweep::Impl::keptExactOf(const Shape& shape, const Pose& X_WG) {
  auto kept = std::make_shared<const Shape>(shape);
  Exact exact = exactOf(*kept, X_WG);
  exact.kept = std::move(kept);
  return exact;
}

LaneSweep::Impl::Exact LaneSweep::Impl::exactOf(const Shape& shape, const Pose& X_WG) {
  Exact exact{nullptr, &shape, X_WG, {}};
  if (shape.isConvex()) {
    exact.view = viewOf(shape);
  } else if (shape.type() == ShapeType::kMesh) {
    exact.view = shape.mesh()->tree().hullView();
  }
  return exact;
}

LaneSweep::Impl::Obstacle LaneSweep::Impl::obstacleIn(std::int32_t place) const {
  const LaneWorld::Placed placed = world->placed(place);
  Obstacle o;
  if (placed.shape != nullptr) {
    o = obstacleOf(*placed.shape, placed.X_WG);
    o.exact_shape = exactOf(*placed.shape, placed.X_WG);
  } else {
    const Shape sphere = Shape::sphere(placed.ball.radius);
    const Pose X_WG{Eigen::Matrix3d::Identity(), placed.ball.center};
    o = obstacleOf(sphere, X_WG);
    o.exact_shape = exactOf(sphere, X_WG);  // the view of a sphere borrows nothing
    o.exact_shape.shape = nullptr;
  }
  o.place = place;
  return o;
}

double LaneSweep::scaleOf(const Shape& shape, const Pose& X_WG) {
  const ShapeCore core = coreOf(shape);
  return (X_WG * core.center).lpNorm<1>() + core.half.lpNorm<1>() + core.radius;
}

Eigen::AlignedBox3d LaneSweep::Impl::boxOf(const Shape& shape, const Pose& X_WG) {
  if (shape.type() == ShapeType::kHalfSpace) {
    const Eigen::Vector3d far = Eigen::Vector3d::Constant(static_cast<double>(kFar));
    return {-far, far};
  }
  const ShapeCore core = coreOf(shape);
  const Eigen::Matrix3d rotation_GW = X_WG.rotation.transpose();
  const Eigen::Vector3d center = X_WG * core.center;
  const Eigen::Vector3d extent =
      rotation_GW.transpose().cwiseAbs() * core.half + Eigen::Vector3d::Constant(core.radius);
  return {center - extent, center + extent};
}

namespace {

/// A box in single precision around one whose corners are off by the rounding of a pose with this
/// translation.
ObstacleBoxes::Box grownBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                            const Eigen::Vector3d& translation, bool is_ball) {
  const double rounding =
      kTransferRounding * (2 * translation.lpNorm<1>() + low.lpNorm<1>() + high.lpNorm<1>());
  ObstacleBoxes::Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::max(roundedDown(low[k] - rounding), -kFar);
    box.high[k] = std::min(roundedUpToFloat(high[k] + rounding), kFar);
  }
  box.is_ball = is_ball;
  return box;
}

}  // namespace

ObstacleBoxes::Box LaneSweep::boxAround(const Shape& shape, const Pose& X_WG) {
  const Eigen::AlignedBox3d exact = Impl::boxOf(shape, X_WG);
  return grownBox(exact.min(), exact.max(), X_WG.translation, shape.type() == ShapeType::kSphere);
}

ObstacleBoxes::Box LaneSweep::boxAroundBall(const Ball& ball, const Eigen::Vector3d& origin) {
  const Eigen::Vector3d radius = Eigen::Vector3d::Constant(ball.radius);
  // The centre was placed by the body's pose; as the pose of a geometry its own translation counts.
  return grownBox(ball.center - radius, ball.center + radius,
                  origin.cwiseAbs() + ball.center.cwiseAbs(), true);
}

// The obstacle of a part of a mesh: its hull, grown by how far the part protrudes from it.
LaneSweep::Impl::Obstacle LaneSweep::Impl::partOf(const CoverPart& part, const Pose& X_WG) {
  const bool fine = !part.points.fine.empty();
  const std::shared_ptr<const ConvexHull> hull =
      hullOfPart(fine ? part.points.fine : part.points.points);
  const double radius =
      (fine ? part.points.fine_radius : part.points.radius) * (1 + kRelativeRounding);
  const Shape shape = Shape::convexHull(hull);
  Obstacle o = obstacleOf(shape, X_WG);
  for (float& half : o.half) half = floatAbove(static_cast<double>(half) + radius);
  o.exact_shape = keptExactOf(shape, X_WG);
  o.exact_shape.view.excess += radius;
  return o;
}

}  // namespace leeway::collision
