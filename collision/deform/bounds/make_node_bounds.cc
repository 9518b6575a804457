#include "collision/deform/bounds/make_node_bounds.h"

#include "collision/deform/bounds/blended_bounds.h"
#include "collision/deform/bounds/skinned_bounds.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {

std::unique_ptr<const NodeBounds> makeNodeBounds(const VertexMotion& motion, const DeformTree& tree,
                                                 DeformVolume volume, std::int32_t nodes) {
  // Selects by class, not by kind(), because an embedding program's motion is always kOwn.
  if (const auto* blended = dynamic_cast<const BlendedMotion*>(&motion))
    return std::make_unique<BlendedBounds>(*blended, tree, volume, nodes);
  if (const auto* skinned = dynamic_cast<const SkinnedVertices*>(&motion))
    return std::make_unique<SkinnedBounds>(*skinned, tree, nodes);
  return nullptr;
}

}  // namespace leeway::collision
