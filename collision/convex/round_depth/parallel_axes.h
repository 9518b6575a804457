#pragma once

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// True if both cores are bodies of revolution about z with straight sides: segment, cylinder,
/// cone.
bool haveAxes(const ConvexView& a, const ConvexView& b);

/// Finds both ends of the signed separation of two overlapping bodies of revolution whose axes are
/// parallel, or nearly. Their difference is also a body of revolution, so the depth is that of a
/// point in a convex polygon: the least over the normals of its sides. (An expanding polytope would
/// need ever more facets around the axis for smaller tolerances.) An angle between the axes widens
/// the upper end by how far it moves A. False if the request is not met, if the bodies do not
/// overlap, or if the axes are not nearly parallel; nothing is offered in the last case. O(1).
bool offerParallelAxes(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                       Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
