#include "collision/base/tolerances.h"
#include "collision/deform/query/deform_descent.h"
#include "collision/deform/query/point_in_snapshot.h"
#include "collision/deform/snapshot.h"
#include "collision/mesh/descent/mesh_descent.h"
#include "collision/solids/contains_at.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

bool isSolidMesh(const Shape& shape) {
  if (shape.type() == ShapeType::kDeformable)
    return shape.deformable()->mesh().closedComponentCount() > 0;
  return shape.type() == ShapeType::kMesh && shape.mesh()->closedComponentCount() > 0;
}

// A lower bound on the distance of a point from the surface of a mesh, above `threshold` where the
// distance is well above.
double distanceFromSurface(const Shape& mesh, const Vector3d& p, double threshold,
                           Scratch& scratch) {
  DescentSide point;
  point.view.core = Core::kPoint;
  point.center = point.low = point.high = Vector3d::Zero();
  DescentPlacement placement;
  placement.X_BA0.translation = placement.X_BA1.translation = -p;
  DistanceRequest request;
  // An interval of this width that holds the threshold is above half of it.
  request.tolerance = 0.5 * threshold;
  request.threshold = threshold;
  request.depth = false;
  PairCache cache;
  if (mesh.type() == ShapeType::kDeformable) {
    // The point is the placed body: a deforming mesh is bounded in its own frame.
    DeformSide moving;
    moving.rigid = point;
    moving.low = moving.high = Vector3d::Zero();
    placement.X_BA0.translation = placement.X_BA1.translation = p;
    return deformDescend(moving, deformSide(mesh), placement, request, scratch, &cache).lower;
  }
  return descend(descentSide(mesh), point, placement, request, scratch, &cache).lower;
}

// Whether a point, known to within `error` in the mesh's frame, is inside a closed component.
Containment holds(const Shape& shape, const Vector3d& p, double error, double gap,
                  Scratch& scratch) {
  const bool deforms = shape.type() == ShapeType::kDeformable;
  const Vector3d& low = deforms ? shape.deformable()->low() : shape.mesh()->tree().node(0).low;
  const Vector3d& high = deforms ? shape.deformable()->high() : shape.mesh()->tree().node(0).high;
  if (((low - p).array() > error).any() || ((p - high).array() > error).any())
    return Containment::kNo;
  // No surface may be between the true point and the rounded one.
  if (!(gap > error) && !(distanceFromSurface(shape, p, 2 * error, scratch) > error))
    return Containment::kUndecided;
  Containment answer = Containment::kNo;
  const int components =
      deforms ? shape.deformable()->mesh().componentCount() : shape.mesh()->componentCount();
  for (int c = 0; c < components; ++c) {
    if (!(deforms ? shape.deformable()->mesh().isClosed(c) : shape.mesh()->isClosed(c))) continue;
    const Side side =
        deforms ? sideOf(shape.deformable()->impl(), c, p, scratch) : sideOf(*shape.mesh(), c, p);
    if (side == Side::kInside) return Containment::kYes;
    if (side == Side::kUnknown) answer = Containment::kUndecided;
  }
  return answer;
}

// Whether a component of `inner` is inside a closed component of the mesh `outer`.
Containment oneWay(const Shape& outer, const Pose& X_WO, const Shape& inner, const Pose& X_WI,
                   double gap, Scratch& scratch) {
  if (!isSolidMesh(outer) || inner.type() == ShapeType::kHalfSpace) return Containment::kNo;
  const RelativePose relative = relativePose(X_WI, X_WO);
  if (!relative.valid) return Containment::kUndecided;
  const double size = outer.extent() + inner.boundingCenter().norm() + inner.boundingRadius() +
                      relative.X_BA.translation.norm();
  const double error = (relative.slack + kRelativeRounding) * size;
  // One point of each component is enough: where surfaces are apart, a connected body is inside or
  // outside as a whole.
  if (inner.isConvex()) {
    const Vector3d p =
        inner.type() == ShapeType::kConvexHull ? inner.hull()->vertices()[0] : Vector3d::Zero();
    return holds(outer, relative.X_BA * p, error, gap, scratch);
  }
  Containment answer = Containment::kNo;
  if (inner.type() == ShapeType::kDeformable) {
    const DeformableSnapshot& snapshot = *inner.deformable();
    for (int i = 0; i < snapshot.mesh().componentCount(); ++i) {
      const Vector3d& p =
          snapshot.vertices()[static_cast<std::size_t>(snapshot.mesh().componentVertex(i))];
      const Containment c = holds(outer, relative.X_BA * p, error, gap, scratch);
      if (c == Containment::kYes) return c;
      if (c == Containment::kUndecided) answer = c;
    }
    return answer;
  }
  for (const MeshTree::Component& component : inner.mesh()->tree().components()) {
    const Containment c = holds(outer, relative.X_BA * component.point, error, gap, scratch);
    if (c == Containment::kYes) return c;
    if (c == Containment::kUndecided) answer = c;
  }
  return answer;
}

}  // namespace

Containment containsAt(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                       double gap, Scratch& scratch) {
  const Containment first = oneWay(a, X_WA, b, X_WB, gap, scratch);
  if (first == Containment::kYes) return first;
  const Containment second = oneWay(b, X_WB, a, X_WA, gap, scratch);
  return second == Containment::kNo ? first : second;
}

Containment contains(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                     Scratch& scratch) {
  return containsAt(a, X_WA, b, X_WB, 0, scratch);
}

}  // namespace leeway::collision
