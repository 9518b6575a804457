#pragma once

#include "collision/base/vector.h"

namespace leeway::collision {

class HullSupport;

/// Index of the first of the farthest vertices along a direction, by a scan of the hull's columns
/// or of its table's cell. The same on every instruction set. -1 if the cell lists too many; `hint`
/// is then a good start for a climb.
int scanFarthest(const HullSupport& support, const Vector& direction, int& hint);

}  // namespace leeway::collision
