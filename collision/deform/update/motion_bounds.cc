#include "collision/deform/update/snapshot_box.h"
#include "collision/deform/update/strategy.h"

namespace leeway::collision {

bool followByMotion(UpdateState& state, DeformableSnapshotImpl& next) {
  next.tree = state.motion_tree;
  next.bounds = state.bounds;
  next.demand = Demand::kMotion;
  WideBox root;
  state.bounds->bound(0, next.parameters, root);
  setBox(next, root);
  state.statistics.nodes_touched = 1;
  return true;
}

}  // namespace leeway::collision
