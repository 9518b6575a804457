#pragma once

#include <array>

#include "collision/base/vector.h"
#include "collision/mesh/box_tree.h"

namespace leeway::collision {

/// A unit vector in the node's frame, or zero for none.
using BoxDirection = std::array<float, 3>;

inline BoxDirection boxDirection(const Vector& unit) {
  return {static_cast<float>(unit.x()), static_cast<float>(unit.y()), static_cast<float>(unit.z())};
}

/// Computes lower bounds on the distances of `query` from the boxes of a node, both in the node's
/// frame [m]. Each is the best bound along the axes of either box (six of the fifteen axes of the
/// separating axis theorem), across corners, along the line of the centres, and along a direction
/// that has separated others, which often separates neighbours, too. `gap` receives BoxNode::kWidth
/// numbers. If no axis separates the boxes, the number is negative: the least overlap, which only
/// orders visits. All rounding of single precision, including that of query.center, is subtracted.
/// The same bytes on every instruction set.
void boxGaps(const BoxNode& node, const OrientedBox& query, const BoxDirection& direction,
             float* gap);

/// The motion of the query's box, or of a node's boxes, during sweptBoxGaps().
struct BoxSweep {
  bool of_node = false;  ///< true: the node's boxes move; false: the query moves
  /// For a node's box: its centre c is at `map` c halfway, and moves by `turn` c + `way` to either
  /// side (matrices by rows). For a query: its centre moves by `way` to either side; map and turn
  /// are not used.
  float map[9], turn[9];
  float way[3];
  float loose = 0;  ///< additional motion of points of a node's box: at most this times its radius
                    ///< ...
  float fixed = 0;  ///< ... plus this [m], including the rounding of the numbers above
};

/// boxGaps() for the regions that the boxes sweep over; negative if those intersect.
void sweptBoxGaps(const BoxNode& node, const OrientedBox& query, const BoxSweep& sweep,
                  const BoxDirection& direction, float* gap);

}  // namespace leeway::collision
