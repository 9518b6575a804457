#pragma once

// Private to collision/: bounds of nodes from the structure of a motion.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "collision/deform/bounds/probe_bounds.h"
#include "collision/deform/tree/deform_tree.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {

/// Boxes are computed in the order of the nodes; their data is prefetched this many nodes ahead.
/// Any value is correct.
inline constexpr std::int32_t kNodesAhead = 3;

/// Boxes of the nodes of one hierarchy as functions of a motion's parameters
/// (VertexMotion::parameters()). The cost does not depend on the number of vertices below a node.
/// Immutable; safe to use from many threads.
class NodeBounds {
 public:
  virtual ~NodeBounds() = default;
  /// The boxes of the node's children. Each contains every vertex of tree.vertices(node, column) as
  /// VertexMotion::vertices() computes it for these parameters, rounding included; columns without
  /// a child are empty. Never throws or allocates.
  virtual void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const = 0;

  /// Boxes of the displacements, from the parameters `from` to `to`, of the vertices below each
  /// child of the node. They include the rounding of VertexMotion::vertices() for both; columns
  /// without a child are undefined. `rounding`: displacementRounding(from, to), which is the same
  /// for all nodes. Not for DeformVolume::kBall. Never throws or allocates.
  virtual void displacement(std::int32_t node, std::span<const double> from,
                            std::span<const double> to, double rounding, WideBox& box) const = 0;
  virtual double displacementRounding(std::span<const double> from,
                                      std::span<const double> to) const = 0;

  /// Whether tighten() can improve the boxes' bounds.
  virtual bool hasVolumes() const { return false; }
  /// Raises the lower bounds on the separation of a body and each child of the node to the bounds
  /// that volumes other than boxes prove. Never throws or allocates.
  virtual void tighten(std::int32_t /*node*/, std::span<const double> /*parameters*/,
                       const Probe& /*probe*/, WideBounds& /*bounds*/) const {}

  virtual std::size_t bytes() const = 0;  ///< of memory
};

}  // namespace leeway::collision
