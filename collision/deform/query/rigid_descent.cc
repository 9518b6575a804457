#include <array>
#include <bit>

#include "collision/base/rounding.h"
#include "collision/deform/query/descent_state.h"
#include "collision/mesh/descent/branch_and_bound.h"

namespace leeway::collision {

namespace {

// Number of nodes that are opened together.
constexpr std::size_t kTogether = 8;

// A node or a leaf that has not been opened.
struct OpenNode {
  float lower;  // proven for everything below
  std::int32_t ref;

  bool isLeaf() const { return DeformTree::isLeaf(ref); }
};

// The children of nodes that are opened together are pushed on top of the stack, above all
// shallower nodes, so each level of the hierarchy has at most the children of one such batch there.
using OpenNodes = BranchAndBound<OpenNode, (DeformTree::kMaxDepth + 1) * kWidth * kTogether>;

void compareLeaf(DescentState& state, const OpenNode& open) {
  const DeformTree& tree = *state.b.snapshot->tree;
  const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(open.ref));
  if (state.isBeyondPlane(tree.leafVertices().subspan(
          static_cast<std::size_t>(leaf.vertex_begin),
          static_cast<std::size_t>(leaf.vertex_end - leaf.vertex_begin))))
    return;
  WideBounds bounds;
  state.kernels.triangleBounds(state.rigid_probe, tree, state.b.snapshot->vertices.data(),
                               leaf.slot_begin, leaf.slot_end, bounds);
  state.compareWithLeaf(kWholeBody, leaf.slot_begin, leaf.slot_end, static_cast<double>(open.lower),
                        bounds);
}

// Pushes the children of the nodes that need a closer look: those of the first node last.
void openChildren(DescentState& state, std::span<const OpenNode> parents, OpenNodes& open) {
  const DeformTree& tree = *state.b.snapshot->tree;
  std::array<WideBox, kTogether> room;
  std::array<const WideBox*, kTogether> boxes;
  std::array<std::int32_t, kTogether> nodes;
  std::array<WideBounds, kTogether> bounds;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    nodes[i] = parents[i].ref;
    boxes[i] = &state.boxes_b.boxes(nodes[i], room[i]);
  }
  state.kernels.childBounds(state.rigid_probe, tree, state.b.snapshot->vertices.data(),
                            {nodes.data(), parents.size()}, boxes.data(),
                            roundedUpToFloat(state.bar()), bounds.data());
  for (std::size_t i = parents.size(); i-- > 0;) {
    state.tighten(nodes[i], state.rigid_probe, bounds[i]);
    state.settle(static_cast<double>(bounds[i].closed));
    const DeformTree::Node& node = tree.node(nodes[i]);
    const std::size_t first = open.size();
    for (unsigned left = bounds[i].open; left != 0; left &= left - 1) {
      const int column = std::countr_zero(left);
      open.pushSibling(first,
                       {std::max(parents[i].lower, bounds[i].lower[column]), node.child[column]});
      state.boxes_b.fetch(node.child[column]);
    }
  }
}

}  // namespace

// Opens several nodes on top of the stack together. Not inlined, because most queries with a
// threshold end before it and its stack would touch another page.
__attribute__((noinline)) void descendRigid(DescentState& state, double root) {
  OpenNodes open;
  open.push({roundedDown(root), 0});
  std::array<OpenNode, kTogether> room;
  for (std::span<const OpenNode> taken; open.next(state, room, taken);) {
    if (!taken.front().isLeaf()) {
      openChildren(state, taken, open);
      continue;
    }
    compareLeaf(state, taken.front());
    // Some of its triangles may not have been compared.
    if (state.isDone()) state.settle(taken.front());
  }
  open.settleRest(state);
}

}  // namespace leeway::collision
