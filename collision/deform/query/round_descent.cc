#include "collision/deform/query/descent_state.h"
#include "collision/deform/query/float_box.h"
#include "collision/deform/query/nearest_triangle.h"
#include "collision/deform/query/round_body.h"

namespace leeway::collision {

bool isRound(const DescentState& state) {
  if (!isRigid(state.a) || state.a.rigid.tree != nullptr || state.placement.swept) return false;
  const ConvexView& view = state.a.rigid.view;
  const bool is_segment = view.core == Core::kSegment;
  return (is_segment || view.core == Core::kPoint) &&
         hasNearest(is_segment, view.size.z(), *state.b.snapshot);
}

bool descendRound(DescentState& state) {
  const ConvexView& view = state.a.rigid.view;
  const DeformableSnapshotImpl& mesh = *state.b.snapshot;
  const DeformTree& tree = *mesh.tree;
  const RoundBody body = roundBody(view.radius, view.size.z(), state.placement.X_BA0);
  NearestSearch search = nearestSearch(body, mesh, state.placement.slack, state.request);
  double root = boxLower(body, mesh, search);
  if (!(root > 0)) {
    // boxLower() gives no depths; boxes do.
    const FloatBox box = floatBox(state.b.low, state.b.high);
    root = lowerBound(state.rigidProbe(), box.low, box.high);
  }
  DescentResult& result = state.result;
  result.hull_lower = root;
  if (state.isPruned(root)) {
    state.settle(root);
    return true;
  }
  search.limit = state.limit();
  const int warm = state.cache.triangle_b;
  if (warm >= 0 && warm < tree.triangleCount()) search.first = tree.slotOf(warm);
  const NearestFound found = findNearest(search, mesh, state.boxes_b);
  result.visited += found.visited;
  if (found.slot >= 0) {
    DistanceResult nearest;
    if (answerNearest(body, found, tree, state.request, nearest)) {
      state.visit();
      ++result.iterations;
      state.settle(nearest.distance.lower);
      state.offer(nearest, nearest.distance.upper, nearest.triangle_a, nearest.triangle_b);
    } else {
      state.comparePieces(kWholeBody, found.slot);
    }
  }
  const double lower = found.lower - view.radius;
  if (state.isDone() || state.isPruned(lower) || state.isSpent()) {
    state.settle(std::max(state.isDone() ? root : lower, root));
    return true;
  }
  if (found.slot >= 0) {
    state.rememberWarm(kWholeBody, found.slot);
    state.rememberPlane(result.witness);
  }
  result.lower = std::numeric_limits<double>::infinity();
  return false;
}

}  // namespace leeway::collision
