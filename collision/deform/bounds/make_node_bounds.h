#pragma once

#include "collision/deform/bounds/node_bounds.h"

namespace leeway::collision {

class VertexMotion;  // vertex_motion.h

/// Bounds of the nodes 0 .. nodes - 1 from a motion of kind kMorph, kSkinned, kReduced or kWaves;
/// null for other kinds. `volume` applies to blended vertices, not to skinned ones. Stores no
/// reference to the tree. O(nodes x vertices below them).
std::unique_ptr<const NodeBounds> makeNodeBounds(const VertexMotion& motion, const DeformTree& tree,
                                                 DeformVolume volume, std::int32_t nodes);

}  // namespace leeway::collision
