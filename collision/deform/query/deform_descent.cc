#include "collision/deform/query/deform_descent.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/deform/query/descent_state.h"
#include "collision/deform/query/float_box.h"
#include "collision/mesh/descent/touching_triangles.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

bool isHalfSpace(const DeformSide& side) {
  return isRigid(side) && side.rigid.tree == nullptr && side.rigid.view.core == Core::kHalfSpace;
}

bool hasNoTree(const DeformSide& side) {
  return side.snapshot != nullptr && side.snapshot->demand == Demand::kNoTree;
}

// A lower bound by the boxes of both bodies.
double rootBound(const DescentState& state) {
  const FloatBox box_b = floatBox(state.b.low, state.b.high);
  if (isRigid(state.a)) return lowerBound(state.rigid_probe, box_b.low, box_b.high);
  const FloatBox box_a = floatBox(state.a.low, state.a.high);
  const Probe probe = state.probeOf(lowOf(box_a), highOf(box_a), state.placement.growth);
  return lowerBound(probe, box_b.low, box_b.high);
}

void descendAll(DescentState& state) {
  if (isRound(state)) {
    if (descendRound(state)) return;
    state.rigid_probe = state.rigidProbe();
  }
  const double root = rootBound(state);
  state.result.hull_lower = root;
  if (state.isPruned(root)) {
    state.settle(root);
    return;
  }
  // descendRound() may have found an upper bound already.
  if (!state.hasUpper()) state.warmStart();
  if (hasNoTree(state.a) || hasNoTree(state.b))
    descendOctree(state, root);
  else if (isRigid(state.a))
    descendRigid(state, root);
  else
    descendPairs(state, root);
}

// A lower bound by the ball around a rigid A, which settles most queries with a threshold; 0 or
// less if it proves nothing.
double ballBound(const DeformSide& a, const DeformSide& b, const DescentPlacement& placement) {
  if (a.snapshot != nullptr || !(a.rigid.radius < kInfinity) || !(b.extent < kInfinity)) return 0;
  Vector3d p = placement.X_BA0 * a.rigid.center;
  double radius = a.rigid.radius + placement.growth, moved = 0;
  if (placement.swept) {
    const Vector3d end = placement.X_BA1 * a.rigid.center;
    moved = placement.X_BA1.translation.norm();
    radius += 0.5 * (end - p).norm();
    p = 0.5 * (p + end);
  }
  const double outside = (b.low - p).cwiseMax(p - b.high).cwiseMax(0.0).norm();
  const double rounding = kRelativeRounding * (a.extent + b.extent + moved + radius +
                                               placement.X_BA0.translation.norm()) +
                          placement.slack;
  return outside - radius - rounding;
}

}  // namespace

DescentState::DescentState(const DeformSide& side_a, const DeformSide& side_b,
                           const DescentPlacement& where, const DistanceRequest& asked,
                           Scratch& own_scratch, PairCache& own_cache)
    : DescentBounds(asked, own_scratch,
                    {.swept = where.swept,
                     .depth = asked.depth,
                     .limits_depth = !isHalfSpace(side_a) && !isHalfSpace(side_b),
                     .near = where.swept ? 0 : own_scratch.impl().touching.near()}),
      a(side_a),
      b(side_b),
      placement(where),
      scratch(own_scratch),
      cache(own_cache),
      kernels(probeKernels()) {
  if (a.snapshot != nullptr) boxes_a = BoxSource(*a.snapshot, scratch.impl().deform);
  if (b.snapshot != nullptr) boxes_b = BoxSource(*b.snapshot, scratch.impl().deform);
  half_space = isHalfSpace(a) || isHalfSpace(b);
  has_volumes =
      b.snapshot != nullptr && b.snapshot->bounds != nullptr && b.snapshot->bounds->hasVolumes();
  extent_b = magnitude(b.low) + magnitude(b.high);
  if (isRigid(a) && !isRound(*this)) rigid_probe = rigidProbe();
}

Probe DescentState::rigidProbe() const {
  const bool has_core = !half_space && a.rigid.tree == nullptr;
  const double radius = has_core ? a.rigid.view.radius : 0;
  return probeOf(a.low.array() + radius, a.high.array() - radius, placement.growth + radius);
}

void DescentState::tightenByVolumes(std::int32_t node, const Probe& probe,
                                    WideBounds& bounds) const {
  b.snapshot->bounds->tighten(node, b.snapshot->parameters, probe, bounds);
  for (unsigned left = bounds.open; left != 0; left &= left - 1) {
    const int column = std::countr_zero(left);
    if (!isPruned(static_cast<double>(bounds.lower[column]))) continue;
    bounds.open &= ~(1U << column);
    bounds.closed = std::min(bounds.closed, bounds.lower[column]);
  }
}

DescentResult deformDescend(const DeformSide& a, const DeformSide& b,
                            const DescentPlacement& placement, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache) {
  if (request.threshold == request.threshold) {
    const double lower = ballBound(a, b, placement);
    if (lower > std::max(request.threshold, 0.0)) {
      DescentResult result;
      result.lower = result.hull_lower = lower;
      result.upper = kInfinity;
      return result;
    }
  }
  DescentState state(a, b, placement, request, scratch, *cache);
  descendAll(state);
  return state.result;
}

}  // namespace leeway::collision
