#pragma once

#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/containment.h"

namespace leeway::collision {

/// contains() for bodies whose surfaces are proven to be at least `gap` apart [m]; 0 if that is
/// unknown.
Containment containsAt(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                       double gap, Scratch& scratch);

}  // namespace leeway::collision
