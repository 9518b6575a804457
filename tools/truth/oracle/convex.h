#pragma once

#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "tools/truth/oracle/quad.h"

namespace leeway::oracle {

/// A placed convex body in quadruple precision: a core (points, or a smooth body under an affine
/// map) and a radius around it. A point x of the shape lies at R x + T with R and T as given,
/// orthogonal or not.
class ConvexBody {
 public:
  /// Any convex shape but a half-space. `origin` is subtracted from the translation before all
  /// else.
  ConvexBody(const collision::Shape& shape, const collision::Pose& X_WS, const Vector& origin);
  /// The hull of points that are already placed.
  explicit ConvexBody(std::vector<Vector> points_W);

  /// The point of the core that is extreme along d (d need not be a unit vector).
  Vector support(const Vector& d) const;
  Quad radius() const { return radius_; }
  /// How far the true shape may stand out from this one (hulls: ConvexHull::excess).
  Quad excess() const { return excess_; }
  /// A length that no coordinate of the core exceeds.
  Quad extent() const;

 private:
  enum class Core { kPoints, kCylinder, kCone, kEllipsoid };
  Vector place(const Vector& p) const;

  Core core_ = Core::kPoints;
  std::vector<Vector> points_;
  Vector column_[3];
  Vector translation_;
  Quad radius_ = 0, core_radius_ = 0, half_length_ = 0, excess_ = 0;
  Vector axes_;
};

/// Bounds of a number in quadruple precision.
struct Bounds {
  Quad lower, upper;
};

/// Signed separation of two convex bodies: GJK with both bounds when apart, an expanding polytope
/// with both bounds when not. Rounding of the computation is in the bounds.
Bounds separation(const ConvexBody& a, const ConvexBody& b);

}  // namespace leeway::oracle
