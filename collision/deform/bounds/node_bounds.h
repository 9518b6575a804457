#pragma once

// Private to collision/: bounds of nodes from the structure of a motion.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "collision/deform/tree/deform_tree.h"
#include "collision/deform/tree/refit.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {

class VertexMotion;  // vertex_motion.h

/// Bounds are asked for in the order of the nodes: what they are made from is fetched that many
/// nodes early. Any value is right.
inline constexpr std::int32_t kNodesAhead = 3;

/// Boxes of the nodes of one hierarchy, as functions of a motion's parameters
/// (VertexMotion::parameters()): at a cost that does not depend on how many vertices are below a
/// node. Constant; many threads ask it.
class NodeBounds {
 public:
  virtual ~NodeBounds() = default;
  /// The boxes of the node's children: each holds every vertex of tree.vertices(node, lane) as
  /// VertexMotion::vertices() gives it for these parameters, rounding included; lanes without a
  /// child are empty. Never throws or allocates.
  virtual void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const = 0;

  /// Boxes of how far the vertices below each child of the node come from where they are for the
  /// parameters `from` to where they are for `to`, as VertexMotion::vertices() gives both, rounding
  /// included; lanes without a child hold anything. `rounding` is what displacementRounding() says
  /// of the two, which need not be worked out for each node. Not of volumes of kind kBall. Never
  /// throws or allocates.
  virtual void displacement(std::int32_t node, std::span<const double> from,
                            std::span<const double> to, double rounding, WideBox& box) const = 0;
  virtual double displacementRounding(std::span<const double> from,
                                      std::span<const double> to) const = 0;

  /// Whether there are volumes that say more than the boxes around them.
  virtual bool hasVolumes() const { return false; }
  /// Raises the lower bounds on the separation of a body and each child of the node to what the
  /// volumes prove. Never throws or allocates.
  virtual void tighten(std::int32_t /*node*/, std::span<const double> /*parameters*/,
                       const Probe& /*probe*/, Bounds& /*bounds*/) const {}

  virtual std::size_t bytes() const = 0;  ///< of memory
};

/// The bounds that the kind of motion allows (kMorph, kSkinned, kReduced); null for other kinds.
/// `volume` is for kMorph and kReduced. Of the nodes 0 .. nodes - 1 alone. The tree's memory is not
/// needed afterwards. O(nodes x vertices below them).
std::unique_ptr<const NodeBounds> makeNodeBounds(const VertexMotion& motion, const DeformTree& tree,
                                                 DeformVolume volume, std::int32_t nodes);

}  // namespace leeway::collision
