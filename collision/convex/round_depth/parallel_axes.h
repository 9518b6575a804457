#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// True when both cores are bodies of revolution about z with straight sides: segment, cylinder,
/// cone.
bool haveAxes(const ConvexView& a, const ConvexView& b);

/// Both ends of the signed separation of two overlapping bodies of revolution whose axes are
/// parallel, or nearly. Their difference is a body of revolution, too, so that the depth is that of
/// a point in a convex polygon: the least over the normals of its sides. (An expanding polytope
/// would need a facet for every width of the tolerance all around the axis.) An angle between the
/// axes widens the upper end by how far it moves A. False when the request is not met, the bodies
/// do not overlap, or the axes are not nearly parallel, where nothing is offered. O(1).
bool offerParallelAxes(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                       Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
