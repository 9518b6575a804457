#include "collision/deform/query/deform_side.h"

#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

DeformSide deformSide(const Shape& shape) {
  DeformSide side;
  if (shape.type() == ShapeType::kDeformable) {
    side.snapshot = &shape.deformable()->impl();
    side.low = side.snapshot->low;
    side.high = side.snapshot->high;
    side.extent = shape.extent();
    return side;
  }
  side.rigid = descentSide(shape);
  side.low = side.rigid.low;
  side.high = side.rigid.high;
  side.extent = side.rigid.extent;
  if (shape.type() == ShapeType::kConvexHull) {
    // This box is tighter than the box of the sphere around the vertices.
    Eigen::Vector3d low = shape.hull()->vertices()[0], high = low;
    for (const Eigen::Vector3d& v : shape.hull()->vertices()) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    side.low = low;
    side.high = high;
  }
  return side;
}

}  // namespace leeway::collision
