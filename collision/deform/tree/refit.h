#pragma once

// Private to collision/: the inner loops of deforming meshes, for every instruction set.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// A body whose distance from boxes is asked, in the boxes' frame B and single precision, rounded
/// outwards: intervals along B's axes and along three other orthonormal ones; the body lies within
/// all of them, grown by `radius`. Intervals may be infinite.
struct Probe {
  float low[3], high[3];            ///< along x, y, z of B
  float axis[3][3];                 ///< three unit vectors
  float axis_low[3], axis_high[3];  ///< along them
  bool turned;  ///< the body is smaller along its own axes than B's say: they are worth a look
  float radius;
  float slack;  ///< rounding of everything here [m]
};

/// Lower bounds on the signed separation of the body and each box; infinity for empty lanes of a
/// node.
struct Bounds {
  alignas(64) float lower[kWidth];
  unsigned open;  ///< children that are no farther than the bar, a bit each
  float closed;   ///< no other child is nearer
};

/// The box of the vertices of a branch that have been read so far: x, y, z, x, ... of several.
struct alignas(64) BranchBox {
  double low[12], high[12];
};

/// Function pointers of one instruction set. Every set yields the same bytes. `vertices` are those
/// of a DeformSnapshot, or have one more behind them, too: four doubles are loaded a vertex.
struct DeformKernels {
  /// Boxes of the nodes [begin, end), last first, each from its leaves' vertices and its children
  /// (which must be in the range, too); and the boxes of nodes whose parents are in the range, in
  /// them. Returns false when a vertex is NaN or infinite.
  bool (*refit)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
                std::int32_t end, WideBox* boxes);
  /// Boxes of the branches [begin, end), in their parents' lanes.
  bool (*branches)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::size_t begin,
                   std::size_t end, WideBox* boxes);
  /// Of all branches, reading the vertices in the order of memory; `room` has a box for each.
  bool (*allBranches)(const DeformTree& tree, const Eigen::Vector3d* vertices, BranchBox* room,
                      WideBox* boxes);
  /// Boxes of the children of one node from the vertices below them; infinite ones where a vertex
  /// is not finite.
  void (*fromVertices)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t node,
                       WideBox& box);
  /// Boxes of the triangles begin .. end - 1 of the tree's slots, at most eight.
  void (*triangles)(const DeformTree& tree, const Eigen::Vector3d* vertices, std::int32_t begin,
                    std::int32_t end, WideBox& box);
  /// Lower bounds of the body's separation from each of these triangles themselves: by their boxes,
  /// and along the way from the body to each. Lanes without a triangle hold anything.
  void (*triangleBounds)(const Probe& probe, const DeformTree& tree,
                         const Eigen::Vector3d* vertices, std::int32_t begin, std::int32_t end,
                         Bounds& bounds);
  /// The box of all vertices. False when one is NaN or beyond +-limit.
  bool (*bound)(const Eigen::Vector3d* vertices, std::size_t count, double limit,
                Eigen::Vector3d& low, Eigen::Vector3d& high);
  /// The same of the boxes of the children of some nodes, of each in its turn; and for leaves that
  /// this leaves at `bar` or below, what their vertices prove, too: across the way from the body to
  /// the middle of the box, where a box around a tilted surface is loose.
  void (*childBounds)(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                      std::span<const std::int32_t> nodes, const WideBox* const* boxes, float bar,
                      Bounds* bounds);
  /// The least scalar product of `n` and each of these vertices, of which there is one at least.
  /// False when a vertex is not finite.
  bool (*leastAlong)(const double* n, const Eigen::Vector3d* vertices,
                     std::span<const std::int32_t> of, double& least);
};

/// Those of the best instruction set that this machine has: about 3 ns, so once a query.
const DeformKernels& deformKernels();

}  // namespace leeway::collision
