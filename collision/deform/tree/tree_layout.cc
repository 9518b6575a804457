#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/deform/tree/tree_draft.h"

namespace leeway::collision {
namespace {

using Triangle = DeformTree::Triangle;

// Collects vertices, each once in each round.
class VertexSet {
 public:
  explicit VertexSet(std::size_t vertex_count) : stamp_(vertex_count, -1) {}

  void clear() {
    ++round_;
    vertices.clear();
  }
  void add(std::int32_t v) {
    if (stamp_[at(v)] == round_) return;
    stamp_[at(v)] = round_;
    vertices.push_back(v);
  }
  void add(const Triangle& corners) {
    for (const std::int32_t v : corners) add(v);
  }
  std::size_t vertexCount() const { return stamp_.size(); }
  void sort() { std::sort(vertices.begin(), vertices.end()); }

  std::vector<std::int32_t> vertices;

 private:
  std::vector<std::int32_t> stamp_;  // for each vertex, the round in which it was last added
  std::int32_t round_ = 0;
};

// Calls f(begin, count) for runs of consecutive vertices, ascending.
template <class F>
void forEachRun(const std::vector<std::int32_t>& sorted, F f) {
  for (auto first = sorted.begin(); first != sorted.end();) {
    auto last = first + 1;
    while (last != sorted.end() && *last == *(last - 1) + 1) ++last;
    f(*first, static_cast<std::int32_t>(last - first));
    first = last;
  }
}

}  // namespace

class TreeLayout {
 public:
  TreeLayout(const TreeDraft& draft, std::size_t vertex_count, std::span<const Triangle> triangles)
      : draft_(draft),
        triangles_(triangles),
        set_(vertex_count),
        tree_(std::make_shared<DeformTree>()) {}

  std::shared_ptr<const DeformTree> run(int split) {
    numberNodes(split);
    placeNodes();
    placeTriangles();
    listLeafVertices();
    listRefitVertices();
    listBranchVertices();
    listNodeVertices();
    return tree_;
  }

 private:
  // Numbers upper nodes level by level, then branch by branch, parents first.
  void numberNodes(int split) {
    number_.assign(draft_.nodes().size(), DeformTree::kNone);
    std::int32_t next = 0;
    std::vector<std::int32_t> branches, none;
    // The root is always an upper node, even for a small mesh.
    numberFrom(0, split, next, branches);
    tree_->upper_count_ = next;
    for (const std::int32_t branch : branches) {
      tree_->branches_.push_back({next, {}});
      numberFrom(branch, 0, next, none);
    }
  }

  // Numbers the node and those below it with more than `most` triangles, level by level; appends
  // the nodes directly below these to `roots`.
  void numberFrom(std::int32_t node, int most, std::int32_t& next,
                  std::vector<std::int32_t>& roots) {
    std::vector<std::int32_t> queue{node};
    for (std::size_t i = 0; i < queue.size(); ++i) {
      number_[at(queue[i])] = next++;
      for (const std::int32_t child : draft_.nodes()[at(queue[i])].child) {
        if (child >= 0)
          (draft_.nodes()[at(child)].triangles > most ? queue : roots).push_back(child);
      }
    }
  }

  void placeNodes() {
    const std::size_t count = draft_.nodes().size();
    tree_->nodes_.resize(count);
    tree_->up_.resize(count);
    tree_->leaf_begin_.resize(count);
    tree_->leaf_end_.resize(count);
    tree_->up_[0] = {DeformTree::kNone, 0};
    for (std::size_t made = 0; made < count; ++made) {
      const TreeDraft::Node& from = draft_.nodes()[made];
      const std::int32_t id = number_[made];
      DeformTree::Node& node = tree_->nodes_[at(id)];
      for (std::size_t column = 0; column < kWidth; ++column) {
        std::int32_t child = from.child[column];
        if (child >= 0) {
          child = number_[at(child)];
          tree_->up_[at(child)] = {id, static_cast<std::int32_t>(column)};
        }
        node.child[column] = child;
      }
      tree_->leaf_begin_[at(id)] = from.leaves.begin;
      tree_->leaf_end_[at(id)] = from.leaves.end;
    }
  }

  void placeTriangles() {
    tree_->slot_of_.resize(triangles_.size());
    tree_->slots_.resize(triangles_.size());
    for (std::size_t slot = 0; slot < triangles_.size(); ++slot) {
      const std::int32_t t = draft_.order[slot];
      tree_->slot_of_[at(t)] = static_cast<std::int32_t>(slot);
      tree_->slots_[slot] = {triangles_[at(t)], t};
    }
  }

  void listLeafVertices() {
    std::pmr::vector<std::int32_t>& all = tree_->leaf_vertices_;
    tree_->leaves_.reserve(draft_.leaves().size());
    for (const DraftRange slots : draft_.leaves()) {
      collectSlots(slots.begin, slots.end);
      const auto begin = static_cast<std::int32_t>(all.size());
      all.insert(all.end(), set_.vertices.begin(), set_.vertices.end());
      tree_->leaves_.push_back(
          {slots.begin, slots.end, begin, static_cast<std::int32_t>(all.size())});
    }
  }

  void listRefitVertices() {
    static_assert(3 * DeformTree::kLeafTriangles * kWidth <= 256, "places in a node are bytes");
    std::vector<std::uint8_t> place(set_.vertexCount());  // place in the node of each of its
                                                          // vertices
    std::pmr::vector<std::int32_t>& all = tree_->refit_vertices_;
    std::pmr::vector<std::uint8_t>& corners = tree_->refit_corners_;
    tree_->refit_offsets_.assign(tree_->nodes_.size() + 1, {0, 0});
    for (std::int32_t id = tree_->nodeCount() - 1; id >= 0; --id) {
      set_.clear();
      std::size_t most = 0;
      for (const std::int32_t child : tree_->node(id).child) {
        const std::span<const std::int32_t> own = verticesOfLeaf(child);
        most = std::max(most, own.size());
        for (const std::int32_t v : own) set_.add(v);
      }
      if (most > 0) {
        set_.sort();
        std::vector<std::int32_t>& vertices = set_.vertices;
        for (std::size_t i = 0; i < vertices.size(); ++i)
          place[at(vertices[i])] = static_cast<std::uint8_t>(i);
        while (vertices.size() % 4 != 0) vertices.push_back(vertices.back());
        all.insert(all.end(), vertices.begin(), vertices.end());
        corners.push_back(static_cast<std::uint8_t>(most));
        for (const std::int32_t child : tree_->node(id).child) {
          const std::span<const std::int32_t> own = verticesOfLeaf(child);
          for (const std::int32_t v : own) corners.push_back(place[at(v)]);
          corners.insert(corners.end(), most - own.size(), own.empty() ? 0 : corners.back());
        }
      }
      tree_->refit_offsets_[at(id)] = {static_cast<std::int32_t>(all.size()),
                                       static_cast<std::int32_t>(corners.size())};
    }
    all.insert(all.end(), at(DeformTree::kAhead), 0);
  }

  // Empty if the child is not a leaf.
  std::span<const std::int32_t> verticesOfLeaf(std::int32_t child) const {
    if (!DeformTree::isLeaf(child)) return {};
    const DeformTree::Leaf& l = tree_->leaf(DeformTree::leafOf(child));
    return tree_->leafVertices().subspan(at(l.vertex_begin), at(l.vertex_end - l.vertex_begin));
  }

  // The branches' own fours and singles precede all others.
  void listBranchVertices() {
    for (std::size_t b = 0; b < tree_->branches_.size(); ++b) {
      DeformTree::Branch& branch = tree_->branches_[b];
      branch.runs = runsBelow(branch.root);
      forEachRun(set_.vertices, [&](std::int32_t begin, std::int32_t count) {
        if (count >= 4) tree_->rows_.push_back({begin, count, static_cast<std::int32_t>(b)});
      });
    }
    // Rows of one branch have no vertex in common, but rows of two branches may.
    std::sort(tree_->rows_.begin(), tree_->rows_.end(),
              [](const DeformTree::Row& l, const DeformTree::Row& r) {
                return l.begin != r.begin ? l.begin < r.begin : l.branch < r.branch;
              });
  }

  // The nodes of a branch follow its root.
  void listNodeVertices() {
    tree_->runs_.resize(tree_->nodes_.size() - at(tree_->upper_count_));
    std::size_t next_branch = 0;
    for (std::int32_t node = tree_->upper_count_; node < tree_->nodeCount(); ++node) {
      if (next_branch < tree_->branches_.size() && tree_->branches_[next_branch].root == node) {
        ++next_branch;
        continue;
      }
      tree_->runs_[at(node - tree_->upper_count_)] = runsBelow(node);
    }
  }

  // Puts the vertices into set_.
  DeformTree::Runs runsBelow(std::int32_t node) {
    const std::int32_t begin = tree_->slotBegin(node);
    collectSlots(begin, begin + tree_->slotsBelow(node));
    DeformTree::Runs runs{};
    runs.four_begin = static_cast<std::int32_t>(tree_->fours_.size());
    runs.single_begin = static_cast<std::int32_t>(tree_->singles_.size());
    forEachRun(set_.vertices,
               [this](std::int32_t first, std::int32_t count) { addRun(first, count); });
    runs.four_end = static_cast<std::int32_t>(tree_->fours_.size());
    runs.single_end = static_cast<std::int32_t>(tree_->singles_.size());
    return runs;
  }

  // The last four of a run may start among the vertices before them.
  void addRun(std::int32_t begin, std::int32_t count) {
    if (count < 4) {
      for (std::int32_t i = 0; i < count; ++i) tree_->singles_.push_back(begin + i);
      return;
    }
    for (std::int32_t i = 0; i + 4 <= count; i += 4) tree_->fours_.push_back(begin + i);
    if (count % 4 != 0) tree_->fours_.push_back(begin + count - 4);
  }

  // Puts the vertices of the triangles in these slots, ascending, into set_.
  void collectSlots(std::int32_t begin, std::int32_t end) {
    set_.clear();
    for (std::int32_t slot = begin; slot < end; ++slot) set_.add(tree_->corners(slot));
    set_.sort();
  }

  const TreeDraft& draft_;
  std::span<const Triangle> triangles_;
  VertexSet set_;
  std::vector<std::int32_t> number_;  // of a node of the draft, in the tree
  std::shared_ptr<DeformTree> tree_;
};

std::shared_ptr<const DeformTree> layOut(const TreeDraft& draft, std::size_t vertex_count,
                                         std::span<const Triangle> triangles, int split) {
  return TreeLayout(draft, vertex_count, triangles).run(split);
}

}  // namespace leeway::collision
