#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// Finds both ends of the signed separation of two cores of type kBox that overlap. The faces of
/// the difference of two boxes are parallel to faces of either or to an edge of each (Gottschalk,
/// Lin, Manocha 1996), so the depth is the least of fifteen overlaps. This needs no search, and
/// parallel faces are not a special case. Returns true if the boxes overlap. If they do not, it
/// offers the lower end of the best of these axes and no upper one.
bool offerBoxOverlap(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                     Progress& progress);

}  // namespace leeway::collision
