#pragma once

#include <cmath>

#include "collision/base/sine_cosine.h"
#include "collision/base/vector.h"

namespace leeway::collision {

/// The k-th of `count` unit vectors spaced evenly on the cone around the unit vector `axis`;
/// `tangent` is the tangent of the cone's half angle. Same bits on every machine.
inline Vector coneDirection(const Vector& axis, double tangent, int k, int count) {
  const Vector u =
      cross(axis, std::abs(axis.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY()).normalized();
  double sine = 0, cosine = 0;
  sineCosine(kTwoPi * k / count, sine, cosine);
  return (axis + tangent * (cosine * u + sine * cross(axis, u))).normalized();
}

}  // namespace leeway::collision
