#include "collision/distance/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/pose_check.h"
#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/base/triple.h"
#include "collision/base/vector.h"
#include "collision/distance/mesh_separation.h"
#include "collision/mesh/descent/descent_answer.h"
#include "collision/mesh/descent/mesh_descent.h"
#include "collision/mesh/descent/obb_descent.h"
#include "collision/mesh/descent/touching_triangles.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

namespace {

ConvexView hullOf(const DescentSide& side) {
  return side.tree != nullptr ? side.tree->hullView() : side.view;
}

// Distance of a mesh's box from the bounding sphere of another body, and the unit vector to it.
// `gap` is the vector between the centres of both bounding spheres, in the world's axes.
double boxToSphere(const Shape& mesh, const Eigen::Matrix3d& R, const Triple& gap, double radius,
                   Triple& normal) {
  const MeshNode& root = mesh.mesh()->tree().node(0);
  const Triple p = tripleOf(mesh.boundingCenter()) + rotatedBack(R, gap);
  const Triple w = {p.x - within(p.x, root.low.x(), root.high.x()),
                    p.y - within(p.y, root.low.y(), root.high.y()),
                    p.z - within(p.z, root.low.z(), root.high.z())};
  const double apart = std::sqrt(squared(w));
  normal = rotated(R, (1 / apart) * w);
  return apart - radius;
}

// Separation of the boxes around two meshes along the best of the axes of either (six of the
// fifteen axes of the separating axis theorem), and that axis. `t` is the vector from A's origin to
// B's, in the world's axes.
double boxToBox(const Shape& a, const Eigen::Matrix3d& R_A, const Shape& b,
                const Eigen::Matrix3d& R_B, const Triple& t, Triple& normal) {
  const auto middle = [](const MeshNode& n) {
    return 0.5 * tripleOf(n.low) + 0.5 * tripleOf(n.high);
  };
  const auto half = [](const MeshNode& n) {
    return 0.5 * tripleOf(n.high) - 0.5 * tripleOf(n.low);
  };
  const MeshNode &root_a = a.mesh()->tree().node(0), &root_b = b.mesh()->tree().node(0);
  const Triple half_a = half(root_a), half_b = half(root_b);
  const Triple way = t + (rotated(R_B, middle(root_b)) - rotated(R_A, middle(root_a)));
  double best = -std::numeric_limits<double>::infinity();
  const auto offer = [&](const Triple& axis) {
    const double along = dot(axis, way);
    const double apart = std::abs(along) - reach(rotatedBack(R_A, axis), half_a) -
                         reach(rotatedBack(R_B, axis), half_b);
    if (!(apart > best)) return;
    best = apart;
    normal = std::copysign(1, along) * axis;
  };
  for (int i = 0; i < 3; ++i) {
    offer(column(R_A, i));
    offer(column(R_B, i));
  }
  return best;
}

// Whether bounding spheres, a sphere and a mesh's box, or two such boxes are already farther apart
// than the threshold. This decides most pairs of a scene. It uses the world poses, because a
// relative pose would cost as much as the answer. Invalid poses decide nothing.
bool boundsDecide(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                  const DistanceRequest& request, DistanceResult& result) {
  if (std::isnan(request.threshold)) return false;
  const PoseCheck check = checkRotations(X_WA.rotation, X_WB.rotation);
  const Triple t = tripleOf(X_WB.translation) - tripleOf(X_WA.translation);
  const Triple gap = t + (rotated(X_WB.rotation, tripleOf(b.boundingCenter())) -
                          rotated(X_WA.rotation, tripleOf(a.boundingCenter())));
  const double norm = std::sqrt(squared(gap)), least = std::max(request.threshold, 0.0);
  // The factor is 2 because a box is transformed by a transpose instead of an inverse, which
  // doubles the departure from orthogonality. This also holds along the axes of either matrix,
  // which need not be unit vectors, because a box's reach is computed from the same matrix.
  const double rounding = 2 * (check.departure + kRelativeRounding) *
                          (a.extent() + b.extent() + std::sqrt(squared(t)) + kLeastSum);
  const double radius_a = a.boundingRadius(), radius_b = b.boundingRadius();
  // A NaN, which results from infinite sizes, decides nothing.
  const auto decides = [&](double lower, const Triple& normal) {
    if (!(lower - rounding > least && check.rotations)) return false;
    result.distance.lower = lower - rounding;
    write(normal, result.normal);
    result.status = DistanceStatus::kAboveThreshold;
    return true;
  };
  if (decides(norm - (radius_a + radius_b), (1 / norm) * gap)) return true;
  Triple normal;
  if (b.type() == ShapeType::kMesh) {
    const double lower = boxToSphere(b, X_WB.rotation, -gap, radius_a, normal);
    if (decides(lower, -normal)) return true;
  }
  if (a.type() != ShapeType::kMesh) return false;
  const double lower = boxToSphere(a, X_WA.rotation, gap, radius_b, normal);
  if (decides(lower, normal)) return true;
  if (b.type() != ShapeType::kMesh) return false;
  const double boxes = boxToBox(a, X_WA.rotation, b, X_WB.rotation, t, normal);
  return decides(boxes, normal);
}

}  // namespace

DistanceResult meshDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const DistanceRequest& request, Scratch& scratch, PairCache* cache) {
  DistanceResult at_once;
  if (boundsDecide(a, X_WA, b, X_WB, request, at_once)) return at_once;
  const RelativePose relative = relativePose(X_WA, X_WB);
  if (!relative.valid) return {};
  const DescentSide side_a = descentSide(a), side_b = descentSide(b);
  const DescentPlacement placement = placementOf(relative, side_a, side_b);
  scratch.impl().touching.start(touchingWithin(placement, side_a, side_b));
  PairCache own;
  PairCache& warm = cache != nullptr ? *cache : own;
  DescentResult found;
  if (takesPair(side_a, side_b, placement)) {
    found = descendPair(side_a, side_b, placement, request, scratch, &warm);
    remember(found, warm);
    if (found.upper <= 0 && request.depth && !deepensPair(side_a, side_b)) {
      const double lower = found.lower;
      const int iterations = found.iterations;
      found = descend(side_a, side_b, placement, request, scratch, &warm);
      found.lower = std::max(found.lower, lower);
      found.iterations += iterations;
    }
  } else {
    found = descend(side_a, side_b, placement, request, scratch, &warm);
  }
  remember(found, warm);

  DistanceResult result = surfaceDistance(found, X_WB);
  if (!(found.hull_lower > 0))
    decideOverlap({a, X_WA, b, X_WB, relative, hullOf(side_a), hullOf(side_b), placement.slack},
                  found.lower, found.hull_lower, request, scratch, result);
  result.status = statusOf(result.distance, request);
  return result;
}

DistanceResult meshSweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1,
                                 double growth, const Shape& b, const DistanceRequest& request,
                                 Scratch& scratch, PairCache* cache) {
  return sweptByDescent(a, X_BA0, X_BA1, growth, b, request, scratch, cache, descentSide, descend);
}

}  // namespace leeway::collision
