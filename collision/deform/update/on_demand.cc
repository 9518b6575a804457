#include "collision/base/tolerances.h"
#include "collision/deform/update/strategy.h"

namespace leeway::collision {

// The rest is done by queries: BoxSource::fill() computes a node's boxes when a query opens it
// (kLazy); query/octree_descent.cc works without nodes (kOctree).
bool followOnDemand(UpdateState& state, DeformableSnapshotImpl& next, Demand demand, bool bounded) {
  next.tree = state.tree;
  next.demand = demand;
  state.statistics.vertices_touched = state.mesh->vertexCount();
  return bounded || deformKernels().bound(next.vertices.data(), state.mesh->rest().size(),
                                          kLargestSize, next.low, next.high);
}

}  // namespace leeway::collision
