#pragma once

#include "collision/box_tree.h"

namespace leeway::collision {

/// Lower bounds on the distances of `query` from the boxes of a node, both in the node's frame: at
/// best along the axes of either box (six of the fifteen of the separating axis theorem), and
/// across corners. `gap` gets BoxNode::kWidth numbers; negative where no axis separates: then the
/// larger (deeper) the nearer to the middle. All rounding of single precision, query.center's own
/// included, is taken off. The same bytes on every instruction set. [m]
void boxGaps(const BoxNode& node, const OrientedBox& query, float* gap);

}  // namespace leeway::collision
