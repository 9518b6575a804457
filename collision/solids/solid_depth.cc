#include "collision/solids/solid_depth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/convex_distance.h"
#include "collision/deform/snapshot.h"
#include "collision/solids/point_inside.h"

namespace leeway::collision {
namespace {

// Points along each axis of a grid over the intersection of the bodies' boxes, if a body deforms.
// Without a grid, deforming solids would have looser depths than rigid ones. A fifth point gains
// almost nothing.
constexpr int kGrid = 4;

// A point in a solid: a lower bound on the distance of the surface, and the direction to it. The
// distance is 0 if the point is outside, on the surface or undecided.
struct Inside {
  double distance = 0;
  Vector outwards = Vector::Zero();  // unit, in W
};

bool isSolid(const Shape& shape) { return shape.isConvex() || isSolidMesh(shape); }

Inside insideOf(const Shape& shape, const Pose& X_WS, const Vector& p_W, int node_limit,
                Scratch& scratch) {
  const RelativePose relative = relativePose(Pose{Eigen::Matrix3d::Identity(), p_W}, X_WS);
  if (!relative.valid) return {};
  const Vector& p = relative.X_BA.translation;
  const double extent = std::isfinite(shape.extent()) ? shape.extent() : 0;
  const double error = (relative.slack + kRelativeRounding) * (extent + p.norm());
  DistanceRequest request;
  // (A half-space has no extent.)
  request.tolerance = shape.type() == ShapeType::kMesh
                          ? kSolidShare * extent
                          : kSolidTolerance * (extent > 0 ? std::min(extent, 1.0) : 1);
  request.node_limit = node_limit;
  Interval distance;
  Vector normal;
  if (shape.isConvex()) {
    ConvexView point;
    point.core = Core::kPoint;
    const DistanceResult r = convexDistance(viewOf(shape), Pose{Eigen::Matrix3d::Identity(), -p},
                                            point, request, scratch, nullptr, error);
    distance = {-r.distance.upper, -r.distance.lower};
    // From the shape to the point; the point leaves the shape along this direction.
    normal = r.normal;
  } else {
    if (sideOfMesh(shape, p, scratch) != Side::kInside) return {};
    request.depth = false;
    const DescentResult r = surfaceAbout(shape, p, request, scratch, normal);
    distance = {r.lower - error, r.upper};
  }
  const double norm = normal.norm();
  if (!(distance.lower > 0 && norm > 0)) return {};
  return {distance.lower, rotated(X_WS.rotation, normal / norm)};
}

// A box around a body in W, rounded; it is used only to place the grid.
struct Box {
  Vector low, high;
};

Box boxAround(const Shape& shape, const Pose& X_WS) {
  Vector middle = shape.boundingCenter(), half = Vector::Constant(shape.boundingRadius());
  const auto take = [&](const Vector& low, const Vector& high) {
    middle = 0.5 * low + 0.5 * high;
    half = 0.5 * high - 0.5 * low;
  };
  if (shape.type() == ShapeType::kDeformable)
    take(shape.deformable()->low(), shape.deformable()->high());
  if (shape.type() == ShapeType::kMesh)
    take(shape.mesh()->tree().node(0).low, shape.mesh()->tree().node(0).high);
  const Vector center = placed(X_WS, middle), reach = X_WS.rotation.cwiseAbs() * half;
  return {center - reach, center + reach};
}

// Two rigid meshes use no grid, because each point takes longer. A deforming mesh without a
// hierarchy uses none either, because each point needs a pass over all triangles.
bool hasGrid(const Shape& a, const Shape& b) {
  const auto isDeforming = [](const Shape& s) { return s.type() == ShapeType::kDeformable; };
  const auto hasTree = [&](const Shape& s) {
    return !isDeforming(s) || s.deformable()->impl().demand != Demand::kNoTree;
  };
  return (isDeforming(a) || isDeforming(b)) && hasTree(a) && hasTree(b) &&
         std::isfinite(a.boundingRadius()) && std::isfinite(b.boundingRadius());
}

}  // namespace

SolidDepth solidDepth(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      std::span<const Vector> starts, int node_limit, Scratch& scratch) {
  SolidDepth result;
  double& best = result.depth;
  Vector at = Vector::Zero(), way = Vector::Zero();
  const auto look = [&](const Vector& p) {
    const Inside in_a = insideOf(a, X_WA, p, node_limit, scratch);
    if (!(in_a.distance > 0)) return false;
    const Inside in_b = insideOf(b, X_WB, p, node_limit, scratch);
    if (!(in_b.distance > 0)) return false;
    // (Rounded inwards.)
    const double depth = (in_a.distance + in_b.distance) * (1 - 4 * kUnitRoundoff);
    if (!(depth > best)) return false;
    best = depth;
    result.way_out = in_a.outwards - in_b.outwards;
    at = p;
    // Moves away from both surfaces, averaged so that zigzags cancel.
    way = 0.5 * way - in_a.outwards - in_b.outwards;
    return true;
  };
  for (const Vector& start : starts) look(start);
  if (!(best > 0)) return result;
  double step = 0.5 * best;
  for (int taken = 0; taken < kDeepestPointSteps && step > 0.02 * best; ++taken) {
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

Vector deepen(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
              const Vector& middle, const DistanceRequest& request, Scratch& scratch,
              DistanceResult& result) {
  if (!isSolid(a) || !isSolid(b)) return Vector::Zero();
  std::array<Vector, 4 + kGrid * kGrid * kGrid> starts;
  std::size_t count = 0;
  for (const Vector& start : {middle, Vector(0.5 * (result.point_a + result.point_b)),
                              placed(X_WA, a.boundingCenter()), placed(X_WB, b.boundingCenter())})
    starts[count++] = start;
  if (hasGrid(a, b)) {
    const Box box_a = boxAround(a, X_WA), box_b = boxAround(b, X_WB);
    const Vector low = box_a.low.cwiseMax(box_b.low),
                 cell = (box_a.high.cwiseMin(box_b.high) - low) / kGrid;
    for (int i = 0; i < kGrid; ++i)
      for (int j = 0; j < kGrid; ++j)
        for (int k = 0; k < kGrid; ++k)
          starts[count++] = low + cell.cwiseProduct(Vector(i + 0.5, j + 0.5, k + 0.5));
  }
  const SolidDepth found =
      solidDepth(a, X_WA, b, X_WB, {starts.data(), count}, request.node_limit, scratch);
  if (found.depth > 0) result.distance.upper = std::min(result.distance.upper, -found.depth);
  return found.way_out;
}

}  // namespace leeway::collision
