#pragma once

#include "collision/base/vector.h"

namespace leeway::collision {

/// All t with normal . t >= offset.
struct PlaneHalfSpace {
  Vector normal;  ///< unit
  double offset;
};

/// The point nearest to the origin that lies in all of `count` half-spaces, to within rounding.
/// False when there is none, or planes are too nearly parallel to find it. Tries every one, two and
/// three planes: O(count^4), for up to ten or so.
bool nearestInHalfSpaces(const PlaneHalfSpace* spaces, int count, Vector& point);

}  // namespace leeway::collision
