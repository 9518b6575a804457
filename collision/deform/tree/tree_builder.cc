#include "collision/deform/tree/tree_builder.h"

#include <numeric>

#include "collision/base/numbers.h"
#include "collision/deform/tree/tree_draft.h"

namespace leeway::collision {

using Eigen::Vector3d;
using Triangle = DeformTree::Triangle;

namespace {

// Copies the nodes from `node` down, and rebuilds the marked ones.
std::int32_t copyNode(TreeDraft& draft, const DeformTree& old, std::int32_t node,
                      const std::vector<char>& anew, int depth) {
  const std::int32_t begin = old.slotBegin(node), count = old.slotsBelow(node);
  if (anew[at(node)] != 0) return buildBinned(draft, {begin, begin + count}, depth);
  const std::int32_t id = draft.newNode();
  for (std::size_t column = 0; column < kWidth; ++column) {
    const std::int32_t child = old.node(node).child[column];
    if (child == DeformTree::kNone) break;
    if (DeformTree::isLeaf(child)) {
      const DeformTree::Leaf& leaf = old.leaf(DeformTree::leafOf(child));
      draft.setChild(id, column, draft.newLeaf({leaf.slot_begin, leaf.slot_end}));
    } else {
      draft.setChild(id, column, copyNode(draft, old, child, anew, depth + 1));
    }
  }
  draft.endNode(id, count);
  return id;
}

}  // namespace

TreeDraft::TreeDraft(std::span<const Vector3d> vertices, std::span<const Triangle> triangles)
    : order(triangles.size()), boxes_(triangles.size()) {
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    DraftBox& box = boxes_[i];
    for (const std::int32_t v : triangles[i]) {
      for (int k = 0; k < 3; ++k) {
        const auto x = static_cast<float>(vertices[at(v)][k]);
        box.low[k] = std::min(box.low[k], x);
        box.high[k] = std::max(box.high[k], x);
      }
    }
  }
}

std::int32_t TreeDraft::newNode() {
  Node node{};
  node.child.fill(DeformTree::kNone);
  node.leaves = {static_cast<std::int32_t>(leaves_.size()), 0};
  nodes_.push_back(node);
  return static_cast<std::int32_t>(nodes_.size()) - 1;
}

void TreeDraft::endNode(std::int32_t node, std::int32_t triangles) {
  nodes_[at(node)].leaves.end = static_cast<std::int32_t>(leaves_.size());
  nodes_[at(node)].triangles = triangles;
}

std::int32_t TreeDraft::newLeaf(DraftRange range) {
  std::sort(order.begin() + range.begin, order.begin() + range.end);
  leaves_.push_back(range);
  return -2 - (static_cast<std::int32_t>(leaves_.size()) - 1);
}

DraftBox TreeDraft::bound(DraftRange range) const {
  DraftBox box;
  for (std::int32_t i = range.begin; i < range.end; ++i) box.add(boxAt(i));
  return box;
}

void TreeDraft::middles(DraftRange range, float* least, float* largest) const {
  for (int k = 0; k < 3; ++k) {
    least[k] = std::numeric_limits<float>::infinity();
    largest[k] = -least[k];
  }
  for (std::int32_t i = range.begin; i < range.end; ++i) {
    const DraftBox& box = boxAt(i);
    for (int k = 0; k < 3; ++k) {
      least[k] = std::min(least[k], box.middle(k));
      largest[k] = std::max(largest[k], box.middle(k));
    }
  }
}

std::int32_t childCapacity(std::int32_t count) {
  std::int64_t capacity = DeformTree::kLeafTriangles;
  while (capacity * kWidth < count) capacity *= kWidth;
  return static_cast<std::int32_t>(capacity);
}

std::shared_ptr<const DeformTree> buildDeformTree(std::span<const Vector3d> vertices,
                                                  std::span<const Triangle> triangles,
                                                  DeformMethod method, int split) {
  TreeDraft draft(vertices, triangles);
  if (method == DeformMethod::kLinear)
    buildMorton(draft);
  else
    buildBinned(draft, draft.all(), 0);
  return layOut(draft, vertices.size(), triangles, split);
}

std::shared_ptr<const DeformTree> restructureDeformTree(const DeformTree& old,
                                                        std::span<const Vector3d> vertices,
                                                        std::span<const Triangle> triangles,
                                                        std::span<const std::int32_t> roots,
                                                        int split) {
  TreeDraft draft(vertices, triangles);
  for (std::size_t slot = 0; slot < draft.order.size(); ++slot)
    draft.order[slot] = old.triangleOf(static_cast<std::int32_t>(slot));
  std::vector<char> anew(old.nodes().size(), 0);
  for (const std::int32_t root : roots) anew[at(root)] = 1;
  copyNode(draft, old, 0, anew, 0);
  return layOut(draft, vertices.size(), triangles, split);
}

}  // namespace leeway::collision
