#pragma once

#include "collision/vector.h"

namespace leeway::collision {

class HullSupport;

/// Index of the first of the farthest vertices along a direction, by a scan of the hull's columns
/// (length() > 0). The same on every instruction set.
int scanFarthest(const HullSupport& support, const Vector& direction);

}  // namespace leeway::collision
