#include "collision/solids/point_inside.h"

#include "collision/deform/query/deform_descent.h"
#include "collision/deform/query/point_in_snapshot.h"
#include "collision/deform/snapshot.h"

namespace leeway::collision {
namespace {

template <class Mesh, class SideOf>
Side sideOfAny(const Mesh& mesh, const SideOf& side) {
  Side answer = Side::kOutside;
  for (int c = 0; c < mesh.componentCount(); ++c) {
    if (!mesh.isClosed(c)) continue;
    const Side s = side(c);
    if (s == Side::kInside) return s;
    if (s == Side::kUnknown) answer = s;
  }
  return answer;
}

}  // namespace

bool isSolidMesh(const Shape& shape) {
  if (shape.type() == ShapeType::kDeformable)
    return shape.deformable()->mesh().closedComponentCount() > 0;
  return shape.type() == ShapeType::kMesh && shape.mesh()->closedComponentCount() > 0;
}

Side sideOfMesh(const Shape& mesh, const Vector& point, Scratch& scratch) {
  if (mesh.type() == ShapeType::kMesh)
    return sideOfAny(*mesh.mesh(), [&](int c) { return sideOf(*mesh.mesh(), c, point); });
  const DeformableSnapshot& snapshot = *mesh.deformable();
  return sideOfAny(snapshot.mesh(),
                   [&](int c) { return sideOf(snapshot.impl(), c, point, scratch); });
}

DescentResult surfaceAbout(const Shape& mesh, const Vector& point, const DistanceRequest& request,
                           Scratch& scratch, Vector& towards) {
  DescentSide side;
  side.view.core = Core::kPoint;
  side.center = side.low = side.high = Vector::Zero();
  DescentPlacement placement;
  PairCache cache;
  if (mesh.type() == ShapeType::kMesh) {
    placement.X_BA0.translation = placement.X_BA1.translation = -point;
    const DescentResult r = descend(descentSide(mesh), side, placement, request, scratch, &cache);
    towards = r.witness.point_a - r.witness.point_b;
    return r;
  }
  // The point is the placed body, because a deforming mesh is bounded in its own frame.
  DeformSide moving;
  moving.rigid = side;
  moving.low = moving.high = Vector::Zero();
  placement.X_BA0.translation = placement.X_BA1.translation = point;
  const DescentResult r =
      deformDescend(moving, deformSide(mesh), placement, request, scratch, &cache);
  towards = r.witness.point_b - r.witness.point_a;
  return r;
}

double distanceFromSurface(const Shape& mesh, const Vector& point, double threshold,
                           Scratch& scratch) {
  DistanceRequest request;
  // An interval of this width that contains the threshold is above half of it.
  request.tolerance = 0.5 * threshold;
  request.threshold = threshold;
  request.depth = false;
  Vector towards;
  return surfaceAbout(mesh, point, request, scratch, towards).lower;
}

bool isInBox(const Shape& mesh, const Vector& point, double error) {
  const bool deforms = mesh.type() == ShapeType::kDeformable;
  const Vector& low = deforms ? mesh.deformable()->low() : mesh.mesh()->tree().node(0).low;
  const Vector& high = deforms ? mesh.deformable()->high() : mesh.mesh()->tree().node(0).high;
  // (Also true for NaN.)
  return !((low - point).array() > error).any() && !((point - high).array() > error).any();
}

double ballInside(const Shape& mesh, const Vector& point, double wanted, Scratch& scratch) {
  if (!isSolidMesh(mesh) || !isInBox(mesh, point, 0)) return 0;
  // The distance is tested first, because most points that are not inside are on the surface, where
  // the other test takes longest.
  const double radius = distanceFromSurface(mesh, point, wanted, scratch);
  return radius > 0 && sideOfMesh(mesh, point, scratch) == Side::kInside ? radius : 0;
}

}  // namespace leeway::collision
