#pragma once

#include <array>

#include "collision/base/vector.h"
#include "collision/mesh/box_tree.h"

namespace leeway::collision {

/// A unit vector, or zero for none, in the node's frame.
using BoxDirection = std::array<float, 3>;

inline BoxDirection boxDirection(const Vector& unit) {
  return {static_cast<float>(unit.x()), static_cast<float>(unit.y()), static_cast<float>(unit.z())};
}

/// Lower bounds on the distances of `query` from the boxes of a node, both in the node's frame [m]:
/// the best along the axes of either box (six of the fifteen of the separating axis theorem),
/// across corners, along the line of the centres, and along a direction that has parted others,
/// which often parts neighbours, too. `gap` gets BoxNode::kWidth numbers. Where no
/// axis separates they are negative: the least overlap, which only orders visits. All rounding of
/// single precision, query.center's own included, is subtracted. The same bytes on every
/// instruction set.
void boxGaps(const BoxNode& node, const OrientedBox& query, const BoxDirection& direction,
             float* gap);

/// The motion of the query's box, or of a node's boxes, during sweptBoxGaps().
struct BoxSweep {
  bool of_node = false;  ///< the node's boxes move; else the query does
  /// A node's box: its centre c is at `map` c halfway, and moves by `turn` c + `way` to either side
  /// (matrices by rows). A query's centre moves by `way` to either side; map and turn are not used.
  float map[9], turn[9];
  float way[3];
  float loose = 0;  ///< points of a node's box move besides by at most this times its radius ...
  float fixed = 0;  ///< ... and this [m], rounding of the numbers above included
};

/// boxGaps() of the regions that the boxes sweep over: below 0 where those meet.
void sweptBoxGaps(const BoxNode& node, const OrientedBox& query, const BoxSweep& sweep,
                  const BoxDirection& direction, float* gap);

}  // namespace leeway::collision
