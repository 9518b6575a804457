#include "collision/convex/round_depth/common_axis.h"

#include <cmath>

#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

// The symmetry of a core's revolution.
struct Revolution {
  enum Kind { kNone, kAxis, kPoint } kind = kNone;
  int axis = 2;       // of the core's frame
  double uneven = 0;  // departure from revolution [m]
};

Revolution ofEllipsoid(const Vector& semi_axes, double wide) {
  const double spread = semi_axes.maxCoeff() - semi_axes.minCoeff();
  if (spread <= wide) return {Revolution::kPoint, 2, spread};
  Revolution result{Revolution::kAxis, 0, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < 3; ++i) {
    const double uneven = std::abs(semi_axes[(i + 1) % 3] - semi_axes[(i + 2) % 3]);
    if (uneven < result.uneven) result.uneven = uneven, result.axis = i;
  }
  return result;
}

Revolution revolutionOf(const ConvexView& view, double wide) {
  switch (view.core) {
    case Core::kPoint:
      return {Revolution::kPoint};
    case Core::kSegment:
    case Core::kCylinder:
    case Core::kCone:
      return {Revolution::kAxis};
    case Core::kEllipsoid:
      return ofEllipsoid(view.size, wide);
    default:
      return {};
  }
}

}  // namespace

// Let A' be the body next to A whose axis is parallel to B's. The frame's origin lies in every
// core, so supports are at least 0, and those of A and A' differ by no more than the turn's sine
// times extent A (here with a little room) plus the departure from a rotation times extent A. (That
// would not hold if the origin were outside a core.) Uneven semi-axes count once each. A direction
// is moved to the half plane with A' in place of A, so all of this counts twice. Axis and halved
// corners of the half plane err by about 20 units of roundoff of the sizes.
CommonAxis commonAxis(const ConvexView& a, const Pose& X_BA, const ConvexView& b, double roundoff,
                      double wide) {
  CommonAxis result;
  const Revolution of_a = revolutionOf(a, wide), of_b = revolutionOf(b, wide);
  if (of_a.kind == Revolution::kNone || of_b.kind == Revolution::kNone) return result;
  const Vector& t = X_BA.translation;
  const Vector axis_a = X_BA.rotation.col(of_a.axis), axis_b = Vector::Unit(of_b.axis);
  const bool has_a = of_a.kind == Revolution::kAxis, has_b = of_b.kind == Revolution::kAxis;
  const double apart = t.norm();
  result.along = has_b       ? axis_b
                 : has_a     ? Vector(axis_a / axis_a.norm())
                 : apart > 0 ? Vector(t / apart)
                             : Vector::UnitX();
  const double sine = has_a && has_b ? cross(axis_a, axis_b).norm() : 0;
  const Vector across = t - t.dot(result.along) * result.along;
  const double length = across.norm();
  // (A shorter vector is rounding, and any direction will do.)
  const Vector beside = std::abs(result.along.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
  result.across = length > kAcrossRounding * roundoff ? Vector(across / length)
                                                      : cross(result.along, beside).normalized();
  const double turned = (1.01 * sine + departureOf(X_BA.rotation)) * a.extent;
  result.excess = 2 * (turned + of_a.uneven + of_b.uneven) + kHalfPlaneRounding * roundoff;
  return result;
}

}  // namespace leeway::collision
