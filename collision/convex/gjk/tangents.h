#pragma once

// Newton steps on the unit sphere: a basis of the tangent plane and quadratic forms on it.

#include <cmath>

#include "collision/base/vector.h"

namespace leeway::collision {

/// Two vectors that span a plane; from tangentsAt() they are of unit length and perpendicular.
struct Tangents {
  Vector u, v;
};

/// A basis of the plane across a unit vector.
inline Tangents tangentsAt(const Vector& n) {
  const Vector helper = std::abs(n.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
  Vector u = cross(n, helper);
  u /= u.norm();
  return {u, cross(n, u)};
}

/// A symmetric form on that plane, by its products of u and v.
struct TangentForm {
  double uu, uv, vv;

  double determinant() const { return uu * vv - uv * uv; }

  /// Adds strength (axis . d)^2 for a tangent vector d.
  void add(double strength, const Vector& axis, const Tangents& at) {
    const double along_u = axis.dot(at.u), along_v = axis.dot(at.v);
    uu += strength * along_u * along_u;
    uv += strength * along_u * along_v;
    vv += strength * along_v * along_v;
  }
};

/// -H^-1 g of a nonsingular Hessian H and a gradient g = (gu, gv).
inline Vector newtonStep(const Tangents& at, const TangentForm& hessian, double gu, double gv) {
  const auto [uu, uv, vv] = hessian;
  const double determinant = hessian.determinant();
  return ((uv * gv - vv * gu) / determinant) * at.u + ((uv * gu - uu * gv) / determinant) * at.v;
}

}  // namespace leeway::collision
