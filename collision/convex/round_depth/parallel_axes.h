#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// True when both cores are bodies of revolution about z with straight sides: segment, cylinder,
/// cone.
bool haveAxes(const ConvexView& a, const ConvexView& b);

/// Both ends of the signed separation of two overlapping bodies of revolution whose axes are
/// parallel, or nearly: their difference then is a body of revolution itself, so that the depth is
/// that of a point in a convex polygon, the least over the sides' directions. The expanding
/// polytope would need a facet for every width of the tolerance all around the axis. An angle
/// between the axes widens the upper end by what it moves A; where the axes are not nearly
/// parallel, nothing is offered. False then, or when they do not overlap, or when the request is
/// not met.
bool offerParallelAxes(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                       Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
