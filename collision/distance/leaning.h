#pragma once

#include <cmath>

#include "collision/base/sine_cosine.h"
#include "collision/base/vector.h"

namespace leeway::collision {

/// The k-th of `count` unit vectors that lean away from the unit vector d to all sides: the tangent
/// of their angle with d is `tangent`. The same bits everywhere.
inline Vector leaning(const Vector& d, double tangent, int k, int count) {
  const Vector u = cross(d, std::abs(d.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY()).normalized();
  double sine = 0, cosine = 0;
  sineCosine(kTwoPi * k / count, sine, cosine);
  return (d + tangent * (cosine * u + sine * cross(d, u))).normalized();
}

}  // namespace leeway::collision
