
#include "collision/deform/update/snapshot_box.h"
#include "collision/deform/update/strategy.h"

namespace leeway::collision {

// The loop itself is in tree/refit_simd.cc.
bool followByRefit(UpdateState& state, DeformableSnapshotImpl& next) {
  const DeformTree& tree = *state.tree;
  next.tree = state.tree;
  next.demand = Demand::kNothing;
  reserveBoxes(next, tree.nodeCount());
  state.statistics.nodes_touched += tree.nodeCount();
  state.statistics.vertices_touched +=
      static_cast<std::int64_t>(tree.refitVertices().size()) - DeformTree::kAhead;
  if (!deformKernels().refit(tree, next.vertices.data(), 0, tree.nodeCount(), next.boxes.data()))
    return false;
  setBox(next, next.boxes[0]);
  return true;
}

}  // namespace leeway::collision
