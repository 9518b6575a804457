#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// Both ends of the signed separation of two boxes that overlap, of two cores of type kBox. The
/// faces of the difference of two boxes are parallel to faces of either or to an edge of each
/// (Gottschalk, Lin, Manocha 1996), so that the depth is the least of fifteen overlaps: nothing is
/// searched for, and parallel faces are no harder than others. True when they overlap; when they do
/// not, the lower end of the best of these axes is offered and no upper one.
bool offerBoxOverlap(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                     Progress& progress);

}  // namespace leeway::collision
