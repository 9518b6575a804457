#pragma once

// Private to collision/: boxes of nodes from the vertices below them.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Function pointers of one instruction set. Every set yields the same bytes. `vertices` are a
/// snapshot's, or are followed by one more in memory: kernels load four doubles a vertex. Functions
/// that return bool return false when a vertex is NaN or infinite.
struct DeformKernels {
  /// Boxes of the nodes [begin, end), backwards, each from its leaves' vertices and its children,
  /// which must be in the range, too. A node whose parent is in the range also fills its lane
  /// there.
  bool (*refit)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
                std::int32_t end, WideBox* boxes);
  /// Boxes of the branches [begin, end), in their parents' lanes.
  bool (*branches)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::size_t begin,
                   std::size_t end, WideBox* boxes);
  /// Boxes of all branches, reading vertices in the order of memory; `room` has one entry a branch.
  bool (*allBranches)(const DeformTree& tree, const Eigen::Vector3d* vertices, BranchBox* room,
                      WideBox* boxes);
  /// Boxes of the children of one node from the vertices below them; a child with a vertex that is
  /// not finite gets the largest box.
  void (*fromVertices)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t node,
                       WideBox& box);
  /// Boxes of the triangles in slots [begin, end), at most eight.
  void (*triangles)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
                    std::int32_t end, WideBox& box);
  /// The box of all vertices. False, too, when a coordinate is beyond +-limit.
  bool (*bound)(const Eigen::Vector3d* vertices, std::size_t count, double limit,
                Eigen::Vector3d& low, Eigen::Vector3d& high);
};

/// The kernels of the best instruction set of this machine. Costs about 3 ns: once a query.
const DeformKernels& deformKernels();

}  // namespace leeway::collision
