#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/motion/cache_motion.h"
#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Boxes of the nodes of one hierarchy for vertices between two stored frames: the frames' boxes,
/// blended as the vertices are (T. Larsson and T. Akenine-Moller, "Efficient collision detection
/// for models deformed by morphing", 2003). Weights are none below 0, so that a box is hardly
/// larger than that of its vertices. 192 bytes a node and frame: meant for upper nodes.
class CachedBounds {
 public:
  /// Of the nodes 0 .. nodes - 1. O(frames x (vertices + nodes)). The tree's memory is not needed
  /// afterwards.
  CachedBounds(const CachedVertices& motion, const DeformTree& tree, std::int32_t nodes);

  /// As NodeBounds::bound(). O(1).
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const;
  /// Starts to bring near what bound() will read.
  void fetch(std::int32_t node, std::span<const double> parameters) const;
  std::size_t bytes() const {
    return sizeof(*this) + rows_.capacity() * sizeof(AxisRow) + lanes_.capacity();
  }

 private:
  const AxisRow* rowsOf(std::int32_t node, std::span<const double> parameters) const {
    return rows_.data() +
           3 * (static_cast<std::size_t>(node) * frames_ + static_cast<std::size_t>(parameters[0]));
  }

  std::size_t frames_;
  std::vector<AxisRow> rows_;        // node by node, frame by frame: x, y, z
  std::vector<std::uint8_t> lanes_;  // one a node: how many children it has
};

}  // namespace leeway::collision
