#include <array>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/deform/query/descent_state.h"
#include "collision/deform/query/float_box.h"
#include "collision/deform/query/overlap_octree.h"

namespace leeway::collision {

using Eigen::Vector3d;

namespace {

int pieceCount(const DeformSide& side) {
  return isRigid(side) ? 1 : side.snapshot->tree->triangleCount();
}

// Piece i of a body.
int slotOf(const DeformSide& side, int i) { return isRigid(side) ? kWholeBody : i; }

// The box of a piece of A in B's frame, grown by the growth of a sweep and by all rounding.
FloatBox boxOfA(const DescentState& state, int slot) {
  FloatBox own = floatBox(state.a.low, state.a.high);
  Vector3d corners[3];
  if (!isRigid(state.a)) {
    const Vector3d* c = pieceOf(state.a, slot, corners).points;
    own = floatBox(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]));
  }
  const Probe probe = isRigid(state.a)
                          ? state.rigid_probe
                          : state.probeOf(lowOf(own), highOf(own), state.placement.growth);
  FloatBox box;
  for (int k = 0; k < 3; ++k) {
    const float grown = probe.radius + probe.slack;
    box.low[k] = probe.low[k] - grown;
    box.high[k] = probe.high[k] + grown;
  }
  return box;
}

// The box of a piece of B.
FloatBox boxOfB(const DescentState& state, int slot) {
  if (isRigid(state.b)) return floatBox(state.b.low, state.b.high);
  Vector3d corners[3];
  const Vector3d* c = pieceOf(state.b, slot, corners).points;
  return floatBox(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]));
}

// Compares the pairs within the current bar, and settles all others with it. False if the limit
// ended it.
bool compareNear(DescentState& state, std::span<const FloatBox> a, int begin_a,
                 std::span<const FloatBox> b, int begin_b, std::span<std::int32_t> lists) {
  const double reach = std::max(state.bar(), 0.0);
  // Growing the boxes by the reach is itself rounded.
  const double grown = reach + kSingleRounding * (reach + state.extent_b + magnitude(state.a.low) +
                                                  magnitude(state.a.high) +
                                                  state.placement.X_BA0.translation.lpNorm<1>());
  OctreePairs octree(
      a, b, std::nextafter(static_cast<float>(grown), std::numeric_limits<float>::infinity()),
      lists);
  bool within = true;
  const bool all = octree.run([&](int i, int j, float distance) {
    const double lower = distance > 0 ? static_cast<double>(distance) : -kInfinity;
    if (state.isPruned(lower)) {
      state.settle(lower);
      return true;
    }
    state.visit();
    within = !state.isSpent();
    if (!within) return false;
    state.comparePieces(slotOf(state.a, begin_a + i), slotOf(state.b, begin_b + j));
    return !state.isDone();
  });
  if (all) state.settle(std::nextafter(reach, kInfinity));
  return within;
}

}  // namespace

// Processes as many pieces at a time as there is room for.
void descendOctree(DescentState& state, double root) {
  DeformScratch& scratch = state.scratch.impl().deform;
  std::array<FloatBox, 64> few_a, few_b;
  std::array<std::int32_t, 512> few_lists;
  const bool room = !scratch.boxes_b.empty();
  const std::span<FloatBox> boxes_a = room ? std::span<FloatBox>(scratch.boxes_a)
                                           : std::span<FloatBox>(few_a),
                            boxes_b = room ? std::span<FloatBox>(scratch.boxes_b)
                                           : std::span<FloatBox>(few_b);
  const std::span<std::int32_t> lists =
      room ? std::span<std::int32_t>(scratch.lists) : std::span<std::int32_t>(few_lists);
  const int count_a = pieceCount(state.a), count_b = pieceCount(state.b);
  const int chunk_a = std::min(count_a, static_cast<int>(boxes_a.size())),
            chunk_b = std::min(count_b, static_cast<int>(boxes_b.size()));
  bool complete = true;
  for (int begin_a = 0; begin_a < count_a && !state.isDone(); begin_a += chunk_a) {
    const int end_a = std::min(begin_a + chunk_a, count_a);
    for (int i = begin_a; i < end_a; ++i)
      boxes_a[static_cast<std::size_t>(i - begin_a)] = boxOfA(state, i);
    for (int begin_b = 0; begin_b < count_b && !state.isDone(); begin_b += chunk_b) {
      const int end_b = std::min(begin_b + chunk_b, count_b);
      for (int i = begin_b; i < end_b; ++i)
        boxes_b[static_cast<std::size_t>(i - begin_b)] = boxOfB(state, i);
      if (!(state.bar() < kInfinity)) {
        // The octree needs a reach; any pair gives one.
        state.compareFirst(
            [&] { state.comparePieces(slotOf(state.a, begin_a), slotOf(state.b, begin_b)); });
      }
      complete &=
          compareNear(state, boxes_a.first(static_cast<std::size_t>(end_a - begin_a)), begin_a,
                      boxes_b.first(static_cast<std::size_t>(end_b - begin_b)), begin_b, lists);
    }
  }
  // For pieces that were not compared, the boxes of the bodies are the bound.
  if (state.isDone() || !complete) state.settle(root);
}

}  // namespace leeway::collision
