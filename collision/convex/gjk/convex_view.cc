#include "collision/convex/gjk/convex_view.h"

#include <algorithm>
#include <cmath>

#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/shapes/hull_support.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

ConvexView viewOf(const Shape& shape) {
  ConvexView view;
  view.extent = shape.extent();
  switch (shape.type()) {
    case ShapeType::kSphere:
      view.core = Core::kPoint;
      view.radius = shape.radius();
      view.extent = 0;
      break;
    case ShapeType::kCapsule:
      view.core = Core::kSegment;
      view.radius = shape.radius();
      view.size.z() = shape.halfLength();
      view.extent = shape.halfLength();
      break;
    case ShapeType::kBox:
      view.core = Core::kBox;
      view.size = shape.halfExtents();
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      view.core = shape.type() == ShapeType::kCylinder ? Core::kCylinder : Core::kCone;
      view.size = Vector(shape.radius(), 0, shape.halfLength());
      break;
    case ShapeType::kEllipsoid:
      view.core = Core::kEllipsoid;
      view.size = shape.halfExtents();
      break;
    case ShapeType::kHalfSpace:
      view.core = Core::kHalfSpace;
      break;
    case ShapeType::kConvexHull:
      view.core = Core::kPoints;
      view.points = shape.hull()->vertices().data();
      view.count = static_cast<int>(shape.hull()->vertices().size());
      view.hull = shape.hull();
      view.support = &shape.hull()->support();
      view.center = shape.boundingCenter();
      break;
    case ShapeType::kMesh:
    case ShapeType::kDeformable:
      break;  // not convex
  }
  return view;
}

ConvexView viewOfPoints(const Vector* points, int count, double radius) {
  ConvexView view;
  view.core = Core::kPoints;
  view.points = points;
  view.count = count;
  view.radius = radius;
  double extent_squared = 0;
  Vector lowest = points[0], highest = points[0];
  for (int i = 0; i < count; ++i) {
    extent_squared = std::max(extent_squared, points[i].squaredNorm());
    lowest = lowest.cwiseMin(points[i]);
    highest = highest.cwiseMax(points[i]);
  }
  view.extent = std::sqrt(extent_squared) * kOutwards;
  view.center = 0.5 * (lowest + highest);
  return view;
}

// clang-format off
// Rounding of X_BA, in units of roundoff (Frobenius norms; rows and columns of a rotation have length 1):
//
//   R_B^T R_A: each entry errs by 3                              9
//   R_B^T (t_A - t_B)                                            1 + 3 sqrt(3) of |t|
//   the departure E = R^T R - 1 of each rotation, as computed    9
//
// R_B^T stands for the inverse of R_B. With R_B = Q (1 + F) and |F| <= |E|/2 (1 + small), using it instead of Q^T
// moves points of A by |F| (extent A + |t|) and points of B by |E| extent B. R_A is taken as the matrix that it is,
// but a caller may have meant the rotation next to it: |E_A| extent A.
// In sum departures plus at most 9 + 9/2 + 9 units.
// clang-format on
RelativePose relativePose(const Pose& X_WA, const Pose& X_WB) {
  RelativePose result;
  const PoseCheck check = checkRotations(X_WA.rotation, X_WB.rotation);
  const Vector &a = X_WA.translation, &b = X_WB.translation;
  const Vector way = a - b;
  // (Written so that NaN fails.)
  if (!(check.rotations && std::abs(way.x()) + std::abs(way.y()) + std::abs(way.z()) <= kFarthest))
    return result;
  result.valid = true;
  result.slack = check.departure + kPoseRounding * kUnitRoundoff;
  // Rows 0 and 1 of a column are computed together, row 2 alone.
  using Pair = double __attribute__((vector_size(16)));
  const Eigen::Matrix3d &A = X_WA.rotation, &B = X_WB.rotation;
  const Pair x = {B(0, 0), B(0, 1)}, y = {B(1, 0), B(1, 1)}, z = {B(2, 0), B(2, 1)};
  for (int j = 0; j < 3; ++j) {
    const double p = A(0, j), q = A(1, j), r = A(2, j);
    const Pair above = x * Pair{p, p} + y * Pair{q, q} + z * Pair{r, r};
    result.X_BA.rotation(0, j) = above[0];
    result.X_BA.rotation(1, j) = above[1];
    result.X_BA.rotation(2, j) = B(0, 2) * p + B(1, 2) * q + B(2, 2) * r;
  }
  result.X_BA.translation = rotatedBack(B, way);
  return result;
}

}  // namespace leeway::collision
