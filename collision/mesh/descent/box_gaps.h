#pragma once

#include "collision/mesh/box_tree.h"

namespace leeway::collision {

/// Lower bounds on the distances of `query` from the boxes of a node, both in the node's frame: at
/// best along the axes of either box (six of the fifteen of the separating axis theorem), and
/// across corners. `gap` gets BoxNode::kWidth numbers; negative where no axis separates: then the
/// larger (deeper) the nearer to the middle. All rounding of single precision, query.center's own
/// included, is taken off. The same bytes on every instruction set. [m]
void boxGaps(const BoxNode& node, const OrientedBox& query, float* gap);

/// A motion of a query's box, or of those of a node, by which sweptBoxGaps() keeps them apart.
struct BoxSweep {
  bool of_node = false;  ///< the node's boxes move; else the query does
  /// How a node's box moves: its centre c stands at `map` c halfway, and moves by `turn` c + `way`
  /// to either side (rows). A query's centre moves by `way` to either side; the rest is not used.
  float map[9], turn[9];
  float way[3];
  float loose = 0;  ///< besides, points of a node's box move by at most this times its radius
  float fixed = 0;  ///< the same for all boxes [m], rounding of the numbers above included
};

/// As boxGaps(), for what the boxes pass over: below 0 where that meets.
void sweptBoxGaps(const BoxNode& node, const OrientedBox& query, const BoxSweep& sweep, float* gap);

}  // namespace leeway::collision
