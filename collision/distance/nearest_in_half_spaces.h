#pragma once

#include "collision/base/vector.h"

namespace leeway::collision {

/// All t with normal . t >= offset.
struct PlaneHalfSpace {
  Vector normal;  ///< unit
  double offset;
};

/// Computes the point nearest to the origin that lies in all of `count` half-spaces, up to
/// rounding. False if there is none, or if planes are too nearly parallel to find it. Tries all
/// choices of one, two and three planes: O(count^4), for up to about ten.
bool nearestInHalfSpaces(const PlaneHalfSpace* spaces, int count, Vector& point);

}  // namespace leeway::collision
