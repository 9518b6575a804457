#include "collision/solids/contains_at.h"

#include "collision/base/tolerances.h"
#include "collision/deform/snapshot.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/solids/point_inside.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

// Whether a point, given to within `error` in the mesh's frame, is inside a closed component.
Containment holds(const Shape& shape, const Vector3d& p, double error, double gap,
                  Scratch& scratch) {
  if (!isInBox(shape, p, error)) return Containment::kNo;
  // There must be no surface between the true point and the rounded one.
  if (!(gap > error) && !(distanceFromSurface(shape, p, 2 * error, scratch) > error))
    return Containment::kUndecided;
  switch (sideOfMesh(shape, p, scratch)) {
    case Side::kInside:
      return Containment::kYes;
    case Side::kOutside:
      return Containment::kNo;
    case Side::kUnknown:
      break;
  }
  return Containment::kUndecided;
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
  // One point of each component is enough, because where surfaces are apart, a connected body is
  // inside or outside as a whole.
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
