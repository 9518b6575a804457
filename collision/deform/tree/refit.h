#pragma once

// Private to collision/: boxes of nodes from the vertices below them.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Function pointers for one instruction set. Every set yields the same bytes. `vertices` belong to
/// a snapshot, or are followed by one more in memory, because kernels load four doubles for each
/// vertex. Functions that return bool return false if a vertex is NaN or infinite.
struct DeformKernels {
  /// Computes boxes of the nodes [begin, end), backwards, each from its leaves' vertices and its
  /// children, which must also be in the range. A node whose parent is in the range also fills its
  /// lane there.
  bool (*refit)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
                std::int32_t end, WideBox* boxes);
  /// Computes boxes of the branches [begin, end), in their parents' lanes.
  bool (*branches)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::size_t begin,
                   std::size_t end, WideBox* boxes);
  /// Computes boxes of all branches, reading vertices in the order of memory; `room` has one entry
  /// for each branch.
  bool (*allBranches)(const DeformTree& tree, const Eigen::Vector3d* vertices, BranchBox* room,
                      WideBox* boxes);
  /// Computes boxes of the children of one node from the vertices below them; a child with a vertex
  /// that is not finite gets the largest box.
  void (*fromVertices)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t node,
                       WideBox& box);
  /// Computes boxes of the triangles in slots [begin, end), at most eight.
  void (*triangles)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
                    std::int32_t end, WideBox& box);
  /// Computes the box of all vertices. Also returns false if a coordinate is beyond +-limit.
  bool (*bound)(const Eigen::Vector3d* vertices, std::size_t count, double limit,
                Eigen::Vector3d& low, Eigen::Vector3d& high);
};

/// The kernels for the best instruction set of this machine. Takes about 3 ns, so call it once for
/// each query.
const DeformKernels& deformKernels();

}  // namespace leeway::collision
