#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/motion/cache_motion.h"
#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Boxes of the nodes of one hierarchy for vertices between two stored frames: the boxes of the two
/// frames, blended like the vertices (T. Larsson and T. Akenine-Moller, "Efficient collision
/// detection for models deformed by morphing", 2003). No weight is negative, which keeps the boxes
/// almost as tight as those of the vertices. 192 bytes for each node and frame: meant for upper
/// nodes.
class CachedBounds {
 public:
  /// For the nodes 0 .. nodes - 1. Stores no reference to the tree. O(frames x (vertices + nodes)).
  CachedBounds(const CachedVertices& motion, const DeformTree& tree, std::int32_t nodes);

  /// The boxes of the node's children, see NodeBounds::bound(). O(1).
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const;
  /// Prefetches the data that bound() reads.
  void fetch(std::int32_t node, std::span<const double> parameters) const;
  std::size_t bytes() const {
    return sizeof(*this) + rows_.capacity() * sizeof(AxisRow) + children_.capacity();
  }

 private:
  const AxisRow* rowsOf(std::int32_t node, std::span<const double> parameters) const {
    return rows_.data() +
           3 * (static_cast<std::size_t>(node) * frames_ + static_cast<std::size_t>(parameters[0]));
  }

  std::size_t frames_;
  std::vector<AxisRow> rows_;           // node by node, frame by frame: x, y, z
  std::vector<std::uint8_t> children_;  // children of each node
};

}  // namespace leeway::collision
