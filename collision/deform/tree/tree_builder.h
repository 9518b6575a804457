#pragma once

// Private to collision/: how hierarchies of deforming meshes are made.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

enum class DeformMethod : unsigned char {
  kBinned,  ///< surface area heuristic over bins (I. Wald, "On fast construction of SAH-based
            ///< bounding volume hierarchies", 2007)
  kLinear,  ///< along a Morton curve (C. Lauterbach et al., "Fast BVH construction on GPUs", 2009)
};

/// A hierarchy for the triangles where their vertices are now; `split` as
/// DeformOptions::hybrid_split, > 0. Triangles with the same place stand in the order of their
/// numbers. O(n log n); O(n) for kLinear.
std::shared_ptr<const DeformTree> buildDeformTree(
    std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles, DeformMethod method, int split);

/// The same hierarchy with the subtrees below `roots` (nodes, none below another) built anew by
/// kBinned. O(n) and O(m log m) for the m triangles below the roots.
std::shared_ptr<const DeformTree> restructureDeformTree(
    const DeformTree& old, std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> roots,
    int split);

}  // namespace leeway::collision
