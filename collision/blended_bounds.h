#pragma once

#include "collision/blended_motion.h"
#include "collision/deform_bounds.h"

namespace leeway::collision {

/// Boxes of vertices that are blended from fields. T. Larsson and T. Akenine-Moller, "Efficient
/// collision detection for models deformed by morphing", 2003: a vertex is the sum over the
/// references of weight times place, each place is in its reference's box of the node, so the
/// vertex is in the sum of weights times boxes, a weight below 0 turning its box round.
/// O(references) a node. D. James and D. Pai, "BD-Tree: output-sensitive collision detection for
/// reduced deformation models", 2004, is the same sum with the rest shape's box taken once and a
/// box of displacements for every mode. Boxes alone: they are what every strategy gives its nodes,
/// so that queries know one kind (k-DOPs and spheres of the same sums would be others).
class BlendedBounds final : public NodeBounds {
 public:
  BlendedBounds(const BlendedMotion& motion, const DeformTree& tree);
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const override;

 private:
  std::size_t fields_;
  bool has_base_;
  std::vector<WideBox> boxes_;        // a node: the base's if there is one, then one a field
  std::vector<WideBox> differences_;  // without a base; a node: the mean's, then one a field
  std::vector<std::uint8_t> lanes_;   // one a node: how many children it has
  double base_size_ = 0;
  std::vector<double> field_sizes_;  // largest |coordinate| [m]
};

}  // namespace leeway::collision
