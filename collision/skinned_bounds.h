#pragma once

#include "collision/deform_bounds.h"
#include "collision/skinned_motion.h"

namespace leeway::collision {

/// Boxes of vertices that are blended from bones. L. Kavan and J. Zara, "Fast collision detection
/// for skeletally deformable models", 2005: a vertex is a convex combination of its images under
/// the bones, so the bones' images of the node's own rest volume, and not those of all that a bone
/// carries, bound it. Where they refine a sphere by the range of the weights, this refines a box
/// (derivation in the source). O(bones of the node's vertices) a node.
class SkinnedBounds final : public NodeBounds {
 public:
  SkinnedBounds(const SkinnedVertices& motion, const DeformTree& tree);
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const override;

 private:
  struct Lanes {
    double center[3][kWidth], half[3][kWidth];  ///< of the rest boxes
  };
  /// A bone's part in the vertices of each lane: every weight is within `range` of `mean`, and
  /// within `residue` of mean + gradient . (rest position - center); the means of a lane add up to
  /// what the weights do. No range: no part.
  struct Part {
    std::int32_t bone;
    double mean[kWidth], range[kWidth], residue[kWidth], gradient[3][kWidth];
  };
  void addParts(const SkinnedVertices& motion, const DeformTree& tree, std::int32_t node);
  void fitGradients(const SkinnedVertices& motion, std::span<const std::int32_t> vertices, int lane,
                    std::span<Part> parts) const;

  std::vector<Lanes> rest_;               // one a node
  std::vector<std::int32_t> first_part_;  // one a node, and one more
  std::vector<Part> parts_;
  std::vector<std::uint8_t> lanes_;  // one a node: how many children it has
  double rest_size_ = 0;             // largest |coordinate| [m]
  double terms_ = 0;                 // most weights of a vertex, or parts of a node
};

}  // namespace leeway::collision
