#pragma once

// Private to collision/: hierarchies of deforming meshes, built or restructured.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// How a hierarchy is built (sources: tree_draft.h).
enum class DeformMethod : unsigned char {
  kBinned,  ///< surface area heuristic over bins
  kLinear,  ///< along a Morton curve
};

/// Builds a hierarchy for the triangles at the current positions of their vertices. `split`: limit
/// on the triangles of a branch, > 0 (DeformOptions::hybrid_split). Ties are broken by triangle
/// number. O(n log n); O(n) for kLinear.
std::shared_ptr<const DeformTree> buildDeformTree(
    std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles, DeformMethod method, int split);

/// Copies `old` and rebuilds the subtrees below `roots` (nodes, none below another) with kBinned.
/// O(n + m log m) for the m triangles below the roots.
std::shared_ptr<const DeformTree> restructureDeformTree(
    const DeformTree& old, std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> roots,
    int split);

}  // namespace leeway::collision
