#include "collision/solid_depth.h"

#include <algorithm>
#include <cmath>

#include "collision/convex.h"
#include "collision/mesh_descent.h"
#include "collision/point_in_solid.h"
#include "collision/vector.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

// A point in a solid: how far its surface is at least, and the way to it. 0: outside, on the
// surface or undecided.
struct Inside {
  double distance = 0;
  Vector outwards = Vector::Zero();  // unit, in W
};

bool isInside(const TriangleMesh& mesh, const Vector& p) {
  for (int c = 0; c < mesh.componentCount(); ++c) {
    if (mesh.isClosed(c) && sideOf(mesh, c, p) == Side::kInside) return true;
  }
  return false;
}

Inside insideOf(const Shape& shape, const Pose& X_WS, const Vector& p_W, Scratch& scratch) {
  const RelativePose relative = relativePose(Pose{Eigen::Matrix3d::Identity(), p_W}, X_WS);
  if (!relative.valid) return {};
  const Vector& p = relative.X_BA.translation;
  const double extent = std::isfinite(shape.extent()) ? shape.extent() : 0;
  const double error = (relative.slack + kRelativeRounding) * (extent + p.norm());
  DistanceRequest request;
  request.tolerance = kSolidShare * extent;
  DescentSide point;
  point.view.core = Core::kPoint;
  point.center = point.low = point.high = Vector::Zero();
  Interval distance;
  Vector normal;
  if (shape.isConvex()) {
    request.tolerance = kSolidTolerance;
    const DistanceResult r = convexDistance(viewOf(shape), Pose{Eigen::Matrix3d::Identity(), -p},
                                            point.view, request, scratch, nullptr, error);
    distance = {-r.distance.upper, -r.distance.lower};
    // From the shape to the point, which leaves along it.
    normal = r.normal;
  } else {
    if (!isInside(*shape.mesh(), p)) return {};
    DescentPlacement placement;
    placement.X_BA0.translation = placement.X_BA1.translation = -p;
    request.depth = false;
    PairCache cache;
    const DescentResult r = descend(descentSide(shape), point, placement, request, scratch, &cache);
    distance = {r.lower - error, r.upper};
    normal = r.witness.point_a - r.witness.point_b;
  }
  const double norm = normal.norm();
  if (!(distance.lower > 0 && norm > 0)) return {};
  return {distance.lower, rotated(X_WS.rotation, normal / norm)};
}

}  // namespace

SolidDepth solidDepth(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      const Vector* starts, int count, Scratch& scratch) {
  SolidDepth result;
  double& best = result.depth;
  Vector at = Vector::Zero(), way = Vector::Zero();
  int looked = 0;
  const auto look = [&](const Vector& p) {
    ++looked;
    const Inside in_a = insideOf(a, X_WA, p, scratch);
    if (!(in_a.distance > 0)) return false;
    const Inside in_b = insideOf(b, X_WB, p, scratch);
    if (!(in_b.distance > 0)) return false;
    // (A rounding of the sum.)
    const double depth = (in_a.distance + in_b.distance) * (1 - 4 * kUnitRoundoff);
    if (!(depth > best)) return false;
    best = depth;
    result.way_out = in_a.outwards - in_b.outwards;
    at = p;
    // Away from both surfaces; what turned back and forth before evens out.
    way = 0.5 * way - in_a.outwards - in_b.outwards;
    return true;
  };
  for (int i = 0; i < count; ++i) look(starts[i]);
  if (!(best > 0)) return result;
  for (double step = 0.5 * best; looked < kDeepestPointSteps && step > 0.02 * best;) {
    const double norm = way.norm();
    if (!(norm > 0)) break;
    if (look(at + (step / norm) * way)) {
      step *= 1.5;
    } else {
      step *= 0.5;
    }
  }
  return result;
}

}  // namespace leeway::collision
