#pragma once

#include "collision/base/vector.h"

namespace leeway::collision {

/// All t with normal . t >= offset.
struct HalfSpaceOf {
  Vector normal;  ///< unit
  double offset;
};

/// The point nearest to the origin that lies in all of `count` half-spaces, to within rounding.
/// False when there is none (or the planes are too nearly parallel to tell). By trying every one,
/// two and three planes: O(count^4), meant for up to ten or so.
bool nearestInHalfSpaces(const HalfSpaceOf* spaces, int count, Vector& point);

}  // namespace leeway::collision
