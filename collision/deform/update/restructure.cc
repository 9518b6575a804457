#include "collision/deform/tree/tree_fit.h"
#include "collision/deform/update/strategy.h"

namespace leeway::collision {

// T. Larsson, T. Akenine-Moller, "A dynamic bounding volume hierarchy for generalized collision
// detection", 2006; S. Yoon, S. Curtis, D. Manocha, "Ray tracing dynamic scenes using selective
// restructuring", 2007. tree_fit.h explains how fit is measured, and why subtrees are rebuilt
// instead of rotated.
bool followByRestructure(UpdateState& state, DeformableSnapshotImpl& next) {
  if (!followByRefit(state, next)) return false;
  const double factor = state.options.restructure_factor;
  std::span<const WideBox> boxes(next.boxes.data(), state.tree->nodes().size());
  measureFit(*state.tree, boxes, state.fit);
  findDecayed(*state.tree, state.fit, state.built_fit, factor, state.decayed);
  const double cost = surfaceCost(boxes, state.tree->nodeCount());
  state.statistics.decay = state.built_cost > 0 ? cost / state.built_cost : 1;
  // A restructured subtree is compared with its new state. findDecayed() therefore misses slow
  // decay in all subtrees, but the cost of the whole tree shows it.
  if (state.statistics.decay > factor * factor) state.decayed.assign(1, 0);
  if (state.decayed.empty()) return true;
  if (state.decayed[0] == 0) return followByRebuild(state, next, DeformMethod::kBinned, true);

  for (const std::int32_t root : state.decayed)
    state.statistics.triangles_rebuilt += state.tree->slotsBelow(root);
  state.tree = restructureDeformTree(*state.tree, state.vertices(next), state.mesh->triangles(),
                                     state.decayed, state.split);
  if (!followByRefit(state, next)) return false;
  boxes = {next.boxes.data(), state.tree->nodes().size()};
  measureFit(*state.tree, boxes, state.built_fit);
  return true;
}

}  // namespace leeway::collision
