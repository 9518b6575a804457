#pragma once

#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/bounds/node_bounds.h"
#include "collision/deform/motion/skinned_motion.h"

namespace leeway::collision {

/// Boxes of vertices that are blended from bones. L. Kavan and J. Zara, "Fast collision detection
/// for skeletally deformable models", 2005: a vertex is a convex combination of its images under
/// the bones, so it is bounded by the bones' images of the node's own rest volume, whatever other
/// vertices a bone carries. They refine spheres by the range of the weights; this class refines
/// boxes (derivation in skinned_bounds.cc). O(bones of the node's vertices) for each node.
class SkinnedBounds final : public NodeBounds {
 public:
  SkinnedBounds(const SkinnedVertices& motion, const DeformTree& tree, std::int32_t nodes);
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const override;
  /// bound() with the differences of the bones' matrices.
  void displacement(std::int32_t node, std::span<const double> from, std::span<const double> to,
                    double rounding, WideBox& box) const override;
  double displacementRounding(std::span<const double> from,
                              std::span<const double> to) const override;
  std::size_t bytes() const override {
    return sizeof(*this) + rest_.capacity() * sizeof(SkinRest) +
           first_part_.capacity() * sizeof(std::int32_t) + parts_.capacity() * sizeof(SkinPart) +
           children_.capacity();
  }

 private:
  /// Boxes for the matrices `to`, or for to - from if `from` is not empty.
  void boundBy(std::int32_t node, std::span<const double> to, std::span<const double> from,
               WideBox& box) const;
  /// Prefetches the data of the node's boxes.
  void fetch(std::int32_t node) const;
  void addParts(const SkinnedVertices& motion, const DeformTree& tree, std::int32_t node);
  void fitGradients(const SkinnedVertices& motion, std::span<const std::int32_t> vertices,
                    int column, std::span<SkinPart> parts) const;

  std::vector<SkinRest> rest_;            // one for each node
  std::vector<std::int32_t> first_part_;  // one for each node, and one more
  std::vector<SkinPart> parts_;
  std::vector<std::uint8_t> children_;  // children of each node
  double rest_size_ = 0;                // largest |coordinate| [m]
  double terms_ = 0;                    // most weights of a vertex, or parts of a node
};

}  // namespace leeway::collision
