#pragma once

#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "tools/truth/oracle/quad.h"

namespace leeway::oracle {

/// A placed convex body in quadruple precision: a core (points, or a smooth body under an affine
/// map) and a radius around it. A point x of the shape is at R x + T; R is taken as given,
/// orthogonal or not.
class ConvexBody {
 public:
  /// Any convex shape except a half-space. `origin` is subtracted from the translation before
  /// anything else.
  ConvexBody(const collision::Shape& shape, const collision::Pose& X_WS, const Vector& origin);
  /// The hull of points in the world frame.
  explicit ConvexBody(std::vector<Vector> points_W);

  /// The core's support point along d, of any length.
  Vector support(const Vector& d) const;
  Quad radius() const { return radius_; }
  /// Bound on the core's coordinates.
  Quad extent() const;

 private:
  enum class Core { kPoints, kCylinder, kCone, kEllipsoid };
  Vector place(const Vector& p) const;

  Core core_ = Core::kPoints;
  std::vector<Vector> points_;
  Vector column_[3];
  Vector translation_;
  Quad radius_ = 0, core_radius_ = 0, half_length_ = 0;
  Vector axes_;
};

/// Bounds of a number in quadruple precision.
struct Bounds {
  Quad lower, upper;
  bool within(const Bounds& other) const { return lower >= other.lower && upper <= other.upper; }
};

/// Only exact bounds are within these, so a search for them continues to its last digit.
inline constexpr Bounds toTheLastDigit() { return {infinity(), -infinity()}; }

/// Signed separation of two convex bodies: GJK if they are apart, otherwise EPA, each with both
/// bounds. The bounds include the computation's rounding. The search ends when they are within
/// `enough`.
Bounds separation(const ConvexBody& a, const ConvexBody& b,
                  const Bounds& enough = toTheLastDigit());

}  // namespace leeway::oracle
