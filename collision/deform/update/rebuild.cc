#include "collision/base/tolerances.h"
#include "collision/deform/tree/tree_fit.h"
#include "collision/deform/update/strategy.h"

namespace leeway::collision {

bool followByRebuild(UpdateState& state, DeformableSnapshotImpl& next, DeformMethod method,
                     bool bounded) {
  // The builder needs finite numbers.
  if (!bounded && !deformKernels().bound(next.vertices.data(), state.mesh->rest().size(),
                                         kLargestSize, next.low, next.high))
    return false;
  state.tree = buildDeformTree(state.vertices(next), state.mesh->triangles(), method, state.split);
  state.statistics.triangles_rebuilt = state.mesh->triangleCount();
  if (!followByRefit(state, next)) return false;
  measureBuilt(state, next);
  state.excess = 0;
  state.statistics.decay = 1;
  return true;
}

void measureBuilt(UpdateState& state, const DeformableSnapshotImpl& snapshot) {
  const DeformTree& tree = *state.tree;
  const std::span<const WideBox> boxes(snapshot.boxes.data(), tree.nodes().size());
  state.built_cost = surfaceCost(boxes, tree.nodeCount());
  state.built_upper_cost = surfaceCost(boxes, tree.upperCount());
  state.round = {};
  addToRound(state, snapshot, tree.branches().size());
  state.built_looseness = looseness(state, snapshot, state.round.area);
  if (state.options.strategy == DeformStrategy::kRestructure)
    measureFit(tree, boxes, state.built_fit);
}

}  // namespace leeway::collision
