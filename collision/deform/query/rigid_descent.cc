#include <array>
#include <bit>

#include "collision/base/rounding.h"
#include "collision/deform/query/descent_state.h"

namespace leeway::collision {

namespace {

// Number of nodes that are opened together.
constexpr std::size_t kTogether = 8;

// A node or a leaf that has not been opened.
struct OpenNode {
  float lower;  // proven for everything below
  std::int32_t ref;
};

void compareLeaf(DescentState& state, const OpenNode& open) {
  const DeformTree& tree = *state.b.snapshot->tree;
  const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(open.ref));
  if (state.isBeyondPlane(tree.leafVertices().subspan(
          static_cast<std::size_t>(leaf.vertex_begin),
          static_cast<std::size_t>(leaf.vertex_end - leaf.vertex_begin))))
    return;
  LaneBounds bounds;
  state.kernels.triangleBounds(state.rigid_probe, tree, state.b.snapshot->vertices.data(),
                               leaf.slot_begin, leaf.slot_end, bounds);
  state.compareWithLeaf(kWholeBody, leaf.slot_begin, leaf.slot_end, static_cast<double>(open.lower),
                        bounds);
}

// Appends the children of the nodes that need a closer look: those of the first node last, and for
// each node the nearest last. Returns their number.
std::size_t openChildren(DescentState& state, std::span<const OpenNode> parents, OpenNode* open) {
  const DeformTree& tree = *state.b.snapshot->tree;
  std::array<WideBox, kTogether> room;
  std::array<const WideBox*, kTogether> boxes;
  std::array<std::int32_t, kTogether> nodes;
  std::array<LaneBounds, kTogether> bounds;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    nodes[i] = parents[i].ref;
    boxes[i] = &state.boxes_b.boxes(nodes[i], room[i]);
  }
  state.kernels.childBounds(state.rigid_probe, tree, state.b.snapshot->vertices.data(),
                            {nodes.data(), parents.size()}, boxes.data(),
                            roundedUpToFloat(state.bar()), bounds.data());
  std::size_t count = 0;
  for (std::size_t i = parents.size(); i-- > 0;) {
    state.tighten(nodes[i], state.rigid_probe, bounds[i]);
    state.settle(static_cast<double>(bounds[i].closed));
    const DeformTree::Node& node = tree.node(nodes[i]);
    const std::size_t first = count;
    for (unsigned left = bounds[i].open; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      const float lower = std::max(parents[i].lower, bounds[i].lower[lane]);
      std::size_t at = count++;
      for (; at > first && open[at - 1].lower < lower; --at) open[at] = open[at - 1];
      open[at] = {lower, node.child[lane]};
      state.boxes_b.fetch(node.child[lane]);
    }
  }
  return count;
}

}  // namespace

// Opens several nodes on top of the stack together, so that their cache misses overlap. Until there
// is an upper bound it opens one at a time, because the nearest leads to one. Not inlined, because
// most queries with a threshold end before it and its stack would touch another page.
__attribute__((noinline)) void descendRigid(DescentState& state, double root) {
  // The children of nodes that are opened together are pushed on top of the stack, above all
  // shallower nodes, so each level of the hierarchy has at most the children of one such batch
  // there.
  std::array<OpenNode, (DeformTree::kMaxDepth + 1) * kWidth * kTogether> open;
  std::size_t size = 0;
  open[size++] = {roundedDown(root), 0};
  bool over = state.done(), within = true;  // within the limit
  while (size > 0 && !over && within) {
    const std::size_t most =
        state.result.upper < std::numeric_limits<double>::infinity() ? kTogether : 1;
    std::array<OpenNode, kTogether> taken;
    std::size_t count = 0;
    while (size > 0 && count < most) {
      const OpenNode top = open[size - 1];
      const auto lower = static_cast<double>(top.lower);
      if (state.needless(lower)) {
        state.settle(lower);
        --size;
        continue;
      }
      const bool leaf = DeformTree::isLeaf(top.ref);
      if (leaf && count > 0) break;
      within = state.visited < state.limit();
      if (!within) break;
      ++state.visited;
      --size;
      if (!leaf) {
        taken[count++] = top;
        continue;
      }
      compareLeaf(state, top);
      over = state.done();
      if (over) state.settle(lower);  // some of its triangles may not have been compared
      break;
    }
    if (count > 0) size += openChildren(state, {taken.data(), count}, &open[size]);
    // Bounds of nodes can only end a sweep.
    over = over || (state.placement.swept && state.done());
  }
  while (size > 0) state.settle(static_cast<double>(open[--size].lower));
}

}  // namespace leeway::collision
