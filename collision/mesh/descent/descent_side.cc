#include "collision/mesh/descent/descent_side.h"

#include <limits>

#include "collision/base/numbers.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

using Eigen::Vector3d;

DescentSide descentSide(const Shape& shape) {
  DescentSide side;
  if (shape.type() == ShapeType::kMesh) {
    side.tree = &shape.mesh()->tree();
    const MeshNode& root = side.tree->node(0);
    side.center = root.center;
    side.radius = root.radius;
    side.low = root.low;
    side.high = root.high;
    side.extent = side.tree->extent();
    side.hull_excess = shape.mesh()->hullExcess();
    const PieceSummary& pieces = shape.mesh()->pieces();
    side.has_solid_pieces =
        pieces.loose_triangles == 0 && pieces.pieces == shape.mesh()->componentCount();
    return side;
  }
  side.view = viewOf(shape);
  side.center = shape.boundingCenter();
  side.radius = shape.boundingRadius();
  side.extent = side.view.extent + side.view.radius + side.view.excess;
  const Vector3d& size = shape.halfExtents();
  Vector3d half = Vector3d::Constant(side.radius);
  switch (shape.type()) {
    case ShapeType::kBox:
    case ShapeType::kEllipsoid:
      half = size;
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      half = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kCapsule:
      half = {shape.radius(), shape.radius(), shape.radius() + shape.halfLength()};
      break;
    case ShapeType::kHalfSpace:
      side.low = Vector3d::Constant(-kInfinity);
      side.high = Vector3d(kInfinity, kInfinity, 0);
      side.extent = kInfinity;
      return side;
    default:
      side.low = side.center - half;
      side.high = side.center + half;
      return side;
  }
  side.low = -half;
  side.high = half;
  return side;
}

}  // namespace leeway::collision
