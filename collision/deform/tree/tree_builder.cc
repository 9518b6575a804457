#include "collision/deform/tree/tree_builder.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace leeway::collision {

using Eigen::Vector3d;
using Triangle = DeformTree::Triangle;

namespace {

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr int kBins = 16;
// Up to this many triangles nodes are halved so that they come out full: the shape of so small a
// piece changes with the mesh anyway, and half-empty nodes cost every update.
constexpr std::int32_t kBalanced = 512;
// From this depth on, too, so that DeformTree::kMaxDepth holds for any mesh.
constexpr int kFreeDepth = 32;

struct Box {
  float low[3] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                  std::numeric_limits<float>::infinity()};
  float high[3] = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                   -std::numeric_limits<float>::infinity()};

  void add(const Box& other) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
  }
  // Twice the centre.
  float middle(int axis) const { return low[axis] + high[axis]; }
  // Half the surface; scaled products of floats up to 1e15 stay in range.
  float area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
};

struct Range {
  std::int32_t begin, end;
  std::int32_t count() const { return end - begin; }
};

// The most triangles below a child of a node that has `count` below it, when all nodes are full.
std::int32_t childCapacity(std::int32_t count) {
  std::int64_t capacity = DeformTree::kLeafTriangles;
  while (capacity * kWidth < count) capacity *= kWidth;
  return static_cast<std::int32_t>(capacity);
}

}  // namespace

// Makes the nodes first (in the order of their making), then puts them in the order of
// DeformTree.
class DeformBuilder {
 public:
  DeformBuilder(std::span<const Vector3d> vertices, std::span<const Triangle> triangles)
      : vertices_(vertices), triangles_(triangles), tree_(std::make_shared<DeformTree>()) {
    boxes_.resize(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      Box& box = boxes_[i];
      for (const std::int32_t v : triangles[i]) {
        for (int k = 0; k < 3; ++k) {
          const auto x = static_cast<float>(vertices[index(v)][k]);
          box.low[k] = std::min(box.low[k], x);
          box.high[k] = std::max(box.high[k], x);
        }
      }
    }
  }

  std::shared_ptr<const DeformTree> build(DeformMethod method, int split) {
    order_.resize(triangles_.size());
    std::iota(order_.begin(), order_.end(), 0);
    const Range all{0, static_cast<std::int32_t>(order_.size())};
    if (method == DeformMethod::kLinear) {
      sortByCurve();
      linearNode(all);
    } else {
      binnedNode(all, 0);
    }
    finish(split);
    return tree_;
  }

  std::shared_ptr<const DeformTree> restructure(const DeformTree& old,
                                                std::span<const std::int32_t> roots, int split) {
    order_.resize(old.slots_.size());
    for (std::size_t slot = 0; slot < order_.size(); ++slot)
      order_[slot] = old.slots_[slot].triangle;
    std::vector<char> anew(old.nodes_.size(), 0);
    for (const std::int32_t r : roots) anew[index(r)] = 1;
    copyNode(old, 0, anew, 0);
    finish(split);
    return tree_;
  }

 private:
  struct Temporary {
    std::array<std::int32_t, kWidth> child;  // as DeformTree::Node, in the order of making
    Range leaves;
    std::int32_t triangles;
  };

  std::int32_t newNode() {
    Temporary node{};
    node.child.fill(DeformTree::kNone);
    node.leaves = {static_cast<std::int32_t>(tree_->leaves_.size()), 0};
    made_.push_back(node);
    return static_cast<std::int32_t>(made_.size()) - 1;
  }

  void endNode(std::int32_t id, std::int32_t triangles) {
    made_[index(id)].leaves.end = static_cast<std::int32_t>(tree_->leaves_.size());
    made_[index(id)].triangles = triangles;
  }

  std::int32_t newLeaf(Range range) {
    // Slots in ascending order of triangles: nearer in memory.
    std::sort(order_.begin() + range.begin, order_.begin() + range.end);
    tree_->leaves_.push_back({range.begin, range.end, 0, 0});
    return -2 - (static_cast<std::int32_t>(tree_->leaves_.size()) - 1);
  }

  Box bound(Range range) const {
    Box box;
    for (std::int32_t i = range.begin; i < range.end; ++i) box.add(boxes_[index(order_[index(i)])]);
    return box;
  }

  // Binned.

  std::int32_t binnedNode(Range range, int depth) {
    const std::int32_t id = newNode();
    std::array<Range, kWidth> parts;
    const std::size_t count = depth < kFreeDepth && range.count() > kBalanced
                                  ? byArea(range, parts)
                                  : balanced(range, childCapacity(range.count()), parts);
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t child = parts[i].count() <= DeformTree::kLeafTriangles
                                     ? newLeaf(parts[i])
                                     : binnedNode(parts[i], depth + 1);
      made_[index(id)].child[i] = child;
    }
    endNode(id, range.count());
    return id;
  }

  // Up to eight parts, the largest box being cut again and again.
  std::size_t byArea(Range range, std::array<Range, kWidth>& parts) {
    std::array<float, kWidth> area{};
    std::size_t count = 1;
    parts[0] = range;
    area[0] = bound(range).area();
    while (count < kWidth) {
      std::size_t widest = kWidth;
      for (std::size_t i = 0; i < count; ++i) {
        if (parts[i].count() > kBalanced && (widest == kWidth || area[i] > area[widest]))
          widest = i;
      }
      if (widest == kWidth) break;
      const Range whole = parts[widest];
      const std::int32_t middle = cutByArea(whole);
      // Parts stay in the order of their triangles.
      for (std::size_t i = count; i > widest + 1; --i) {
        parts[i] = parts[i - 1];
        area[i] = area[i - 1];
      }
      parts[widest] = {whole.begin, middle};
      parts[widest + 1] = {middle, whole.end};
      area[widest] = bound(parts[widest]).area();
      area[widest + 1] = bound(parts[widest + 1]).area();
      ++count;
    }
    return count;
  }

  // The bin border with the least sum of area times number on both sides, over three axes.
  std::int32_t cutByArea(Range range) {
    float from[3], to[3];
    centers(range, from, to);
    int best_axis = -1, best_bin = 0;
    float best = std::numeric_limits<float>::infinity(), best_scale = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float width = to[axis] - from[axis];
      if (!(width > 0)) continue;
      const float scale = (kBins * (1 - 1e-5F)) / width;
      if (!std::isfinite(scale)) continue;
      std::array<Box, kBins> bins;
      std::array<std::int32_t, kBins> number{};
      for (std::int32_t i = range.begin; i < range.end; ++i) {
        const Box& box = boxes_[index(order_[index(i)])];
        const std::size_t bin = binOf(box, axis, from[axis], scale);
        bins[bin].add(box);
        ++number[bin];
      }
      std::array<float, kBins> right_cost{};
      Box right;
      std::int32_t right_number = 0;
      for (std::size_t i = kBins - 1; i > 0; --i) {
        right.add(bins[i]);
        right_number += number[i];
        right_cost[i] = right_number > 0 ? right.area() * static_cast<float>(right_number) : -1;
      }
      Box left;
      std::int32_t left_number = 0;
      for (std::size_t i = 1; i < kBins; ++i) {
        left.add(bins[i - 1]);
        left_number += number[i - 1];
        if (left_number == 0 || right_cost[i] < 0) continue;
        const float cost = left.area() * static_cast<float>(left_number) + right_cost[i];
        if (!(cost < best)) continue;
        best = cost;
        best_axis = axis;
        best_bin = static_cast<int>(i);
        best_scale = scale;
      }
    }
    if (best_axis < 0) return range.begin + range.count() / 2;
    const auto first = order_.begin() + range.begin, last = order_.begin() + range.end;
    const auto middle = std::partition(first, last, [&](std::int32_t t) {
      return binOf(boxes_[index(t)], best_axis, from[best_axis], best_scale) <
             static_cast<std::size_t>(best_bin);
    });
    const auto cut = static_cast<std::int32_t>(middle - order_.begin());
    return cut > range.begin && cut < range.end ? cut : range.begin + range.count() / 2;
  }

  static std::size_t binOf(const Box& box, int axis, float from, float scale) {
    const float f = (box.middle(axis) - from) * scale;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(f), 0, kBins - 1));
  }

  void centers(Range range, float* from, float* to) const {
    for (int k = 0; k < 3; ++k) {
      from[k] = std::numeric_limits<float>::infinity();
      to[k] = -from[k];
    }
    for (std::int32_t i = range.begin; i < range.end; ++i) {
      const Box& box = boxes_[index(order_[index(i)])];
      for (int k = 0; k < 3; ++k) {
        from[k] = std::min(from[k], box.middle(k));
        to[k] = std::max(to[k], box.middle(k));
      }
    }
  }

  // Parts of `capacity` triangles, the last one less: the longest part is halved again and again.
  std::size_t balanced(Range range, std::int32_t capacity, std::array<Range, kWidth>& parts) {
    std::size_t count = 1;
    parts[0] = range;
    for (;;) {
      std::size_t longest = 0;
      for (std::size_t i = 1; i < count; ++i) {
        if (parts[i].count() > parts[longest].count()) longest = i;
      }
      const Range whole = parts[longest];
      if (whole.count() <= capacity) return count;
      const std::int32_t pieces = (whole.count() + capacity - 1) / capacity;
      const std::int32_t cut = whole.begin + (pieces / 2) * capacity;
      halve(whole, cut);
      for (std::size_t i = count; i > longest + 1; --i) parts[i] = parts[i - 1];
      parts[longest] = {whole.begin, cut};
      parts[longest + 1] = {cut, whole.end};
      ++count;
    }
  }

  // The lower centres along the longest axis come before `cut`.
  void halve(Range range, std::int32_t cut) {
    float from[3], to[3];
    centers(range, from, to);
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
      if (to[k] - from[k] > to[axis] - from[axis]) axis = k;
    }
    std::nth_element(order_.begin() + range.begin, order_.begin() + cut, order_.begin() + range.end,
                     [&](std::int32_t l, std::int32_t r) {
                       const float cl = boxes_[index(l)].middle(axis),
                                   cr = boxes_[index(r)].middle(axis);
                       return cl != cr ? cl < cr : l < r;
                     });
  }

  // Linear.

  // 3 x 21 bits, interleaved.
  static std::uint64_t spread(std::uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffULL;
    x = (x | x << 16) & 0x1f0000ff0000ffULL;
    x = (x | x << 8) & 0x100f00f00f00f00fULL;
    x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
    x = (x | x << 2) & 0x1249249249249249ULL;
    return x;
  }

  void sortByCurve() {
    const Range all{0, static_cast<std::int32_t>(order_.size())};
    float from[3], to[3];
    centers(all, from, to);
    float width = 0;
    for (int k = 0; k < 3; ++k) width = std::max(width, to[k] - from[k]);
    const float scale = width > 0 ? 0x1p20F / width : 0.0F;
    std::vector<std::pair<std::uint64_t, std::int32_t>> keys(order_.size()), other(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) {
      std::uint64_t code = 0;
      for (int k = 0; k < 3; ++k) {
        const float f = (boxes_[i].middle(k) - from[k]) * scale;
        // Written so that what is no number becomes 0.
        const std::uint64_t cell = f > 0 && f < 0x1p21F ? static_cast<std::uint64_t>(f) : 0;
        code |= spread(cell) << k;
      }
      keys[i] = {code, static_cast<std::int32_t>(i)};
    }
    radixSort(keys, other);
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = keys[i].second;
  }

  // Stable, 11 bits a pass.
  static void radixSort(std::vector<std::pair<std::uint64_t, std::int32_t>>& keys,
                        std::vector<std::pair<std::uint64_t, std::int32_t>>& other) {
    for (int shift = 0; shift < 66; shift += 11) {
      std::array<std::size_t, 2049> begin{};
      for (const auto& key : keys) ++begin[((key.first >> shift) & 2047) + 1];
      for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
      for (const auto& key : keys) other[begin[(key.first >> shift) & 2047]++] = key;
      keys.swap(other);
    }
  }

  // Runs of the curve, all of the same length.
  std::int32_t linearNode(Range range) {
    const std::int32_t id = newNode();
    const std::int32_t capacity = childCapacity(range.count());
    std::size_t lane = 0;
    for (std::int32_t begin = range.begin; begin < range.end; begin += capacity) {
      const Range part{begin, std::min(begin + capacity, range.end)};
      const std::int32_t child =
          part.count() <= DeformTree::kLeafTriangles ? newLeaf(part) : linearNode(part);
      made_[index(id)].child[lane++] = child;
    }
    endNode(id, range.count());
    return id;
  }

  // Restructuring.

  Range slotsOf(const DeformTree& old, std::int32_t node) const {
    return {old.leaves_[index(old.leaf_begin_[index(node)])].slot_begin,
            old.leaves_[index(old.leaf_end_[index(node)] - 1)].slot_end};
  }

  std::int32_t copyNode(const DeformTree& old, std::int32_t node, const std::vector<char>& anew,
                        int depth) {
    if (anew[index(node)] != 0) return binnedNode(slotsOf(old, node), depth);
    const std::int32_t id = newNode();
    for (std::size_t lane = 0; lane < kWidth; ++lane) {
      const std::int32_t child = old.node(node).child[lane];
      if (child == DeformTree::kNone) break;
      std::int32_t copy = 0;
      if (DeformTree::isLeaf(child)) {
        const DeformTree::Leaf& leaf = old.leaf(DeformTree::leafOf(child));
        copy = newLeaf({leaf.slot_begin, leaf.slot_end});
      } else {
        copy = copyNode(old, child, anew, depth + 1);
      }
      made_[index(id)].child[lane] = copy;
    }
    const Range slots = slotsOf(old, node);
    endNode(id, slots.count());
    return id;
  }

  // Order.

  void finish(int split) {
    number(split);
    const std::size_t count = made_.size();
    tree_->nodes_.resize(count);
    tree_->up_.resize(count);
    tree_->leaf_begin_.resize(count);
    tree_->leaf_end_.resize(count);
    for (std::size_t old = 0; old < count; ++old) {
      const std::int32_t id = number_[old];
      DeformTree::Node& node = tree_->nodes_[index(id)];
      if (id == 0) tree_->up_[0] = {DeformTree::kNone, 0};
      for (std::size_t lane = 0; lane < kWidth; ++lane) {
        std::int32_t child = made_[old].child[lane];
        if (child >= 0) {
          child = number_[index(child)];
          tree_->up_[index(child)] = {id, static_cast<std::int32_t>(lane)};
        }
        node.child[lane] = child;
      }
      tree_->leaf_begin_[index(id)] = made_[old].leaves.begin;
      tree_->leaf_end_[index(id)] = made_[old].leaves.end;
    }
    tree_->slot_of_.resize(triangles_.size());
    tree_->slots_.resize(triangles_.size());
    for (std::size_t slot = 0; slot < triangles_.size(); ++slot) {
      const std::int32_t t = order_[slot];
      tree_->slot_of_[index(t)] = static_cast<std::int32_t>(slot);
      tree_->slots_[slot] = {triangles_[index(t)], t};
    }
    collectVertices();
  }

  // Upper nodes level by level, then branch by branch, parents first.
  void number(int split) {
    number_.assign(made_.size(), DeformTree::kNone);
    std::int32_t next = 0;
    std::vector<std::int32_t> branches, none;
    // The root is an upper node however small the mesh.
    numberFrom(0, split, next, branches);
    tree_->upper_count_ = next;
    for (const std::int32_t branch : branches) {
      tree_->branches_.push_back({next, {}});
      numberFrom(branch, 0, next, none);
    }
  }

  // The node and those below it that have more than `most` triangles, level by level; what hangs
  // below these is put into `roots`.
  void numberFrom(std::int32_t node, int most, std::int32_t& next,
                  std::vector<std::int32_t>& roots) {
    std::vector<std::int32_t> queue{node};
    for (std::size_t i = 0; i < queue.size(); ++i) {
      number_[index(queue[i])] = next++;
      for (const std::int32_t child : made_[index(queue[i])].child) {
        if (child >= 0) (made_[index(child)].triangles > most ? queue : roots).push_back(child);
      }
    }
  }

  void collectVertices() {
    std::vector<std::int32_t> stamp(vertices_.size(), -1), collected;
    std::int32_t round = 0;
    for (DeformTree::Leaf& leaf : tree_->leaves_) {
      collected.clear();
      for (std::int32_t slot = leaf.slot_begin; slot < leaf.slot_end; ++slot)
        collect(tree_->corners(slot), round, stamp, collected);
      ++round;
      std::sort(collected.begin(), collected.end());
      leaf.vertex_begin = static_cast<std::int32_t>(tree_->leaf_vertices_.size());
      tree_->leaf_vertices_.insert(tree_->leaf_vertices_.end(), collected.begin(), collected.end());
      leaf.vertex_end = static_cast<std::int32_t>(tree_->leaf_vertices_.size());
    }
    collectForRefits(round, stamp, collected);
    for (DeformTree::Branch& branch : tree_->branches_) {
      branch.runs = runsBelow(branch.root, round++, stamp, collected);
      addRows(collected, static_cast<std::int32_t>(&branch - tree_->branches_.data()));
    }
    // Rows of a branch share no vertex, but those of two may.
    std::sort(tree_->rows_.begin(), tree_->rows_.end(),
              [](const DeformTree::Row& l, const DeformTree::Row& r) {
                return l.begin != r.begin ? l.begin < r.begin : l.branch < r.branch;
              });
    // Nodes of a branch come behind its root.
    tree_->runs_.resize(tree_->nodes_.size() - index(tree_->upper_count_));
    std::size_t next_branch = 0;
    for (std::int32_t node = tree_->upper_count_; node < tree_->nodeCount(); ++node) {
      if (next_branch < tree_->branches_.size() && tree_->branches_[next_branch].root == node) {
        ++next_branch;
        continue;
      }
      tree_->runs_[index(node - tree_->upper_count_)] = runsBelow(node, round++, stamp, collected);
    }
  }

  void collectForRefits(std::int32_t& round, std::vector<std::int32_t>& stamp,
                        std::vector<std::int32_t>& collected) {
    static_assert(3 * DeformTree::kLeafTriangles * kWidth <= 256, "places in a node are bytes");
    std::vector<std::uint8_t> place(vertices_.size());  // of those of this round
    std::pmr::vector<std::int32_t>& all = tree_->refit_vertices_;
    std::pmr::vector<std::uint8_t>& corners = tree_->refit_corners_;
    tree_->refits_.assign(tree_->nodes_.size() + 1, {0, 0});
    for (std::int32_t id = tree_->nodeCount() - 1; id >= 0; --id, ++round) {
      collected.clear();
      std::size_t most = 0;
      for (const std::int32_t child : tree_->node(id).child) {
        const std::span<const std::int32_t> own = verticesOf(child);
        most = std::max(most, own.size());
        for (const std::int32_t v : own) collectOne(v, round, stamp, collected);
      }
      if (most > 0) {
        std::sort(collected.begin(), collected.end());
        for (std::size_t i = 0; i < collected.size(); ++i)
          place[index(collected[i])] = static_cast<std::uint8_t>(i);
        while (collected.size() % 4 != 0) collected.push_back(collected.back());
        all.insert(all.end(), collected.begin(), collected.end());
        corners.push_back(static_cast<std::uint8_t>(most));
        for (const std::int32_t child : tree_->node(id).child) {
          const std::span<const std::int32_t> own = verticesOf(child);
          for (const std::int32_t v : own) corners.push_back(place[index(v)]);
          corners.insert(corners.end(), most - own.size(), own.empty() ? 0 : corners.back());
        }
      }
      tree_->refits_[index(id)] = {static_cast<std::int32_t>(all.size()),
                                   static_cast<std::int32_t>(corners.size())};
    }
    all.insert(all.end(), index(DeformTree::kAhead), 0);
  }

  // None of what is no leaf.
  std::span<const std::int32_t> verticesOf(std::int32_t child) const {
    if (!DeformTree::isLeaf(child)) return {};
    const DeformTree::Leaf& l = tree_->leaf(DeformTree::leafOf(child));
    return tree_->leafVertices().subspan(index(l.vertex_begin),
                                         index(l.vertex_end - l.vertex_begin));
  }

  DeformTree::Runs runsBelow(std::int32_t node, std::int32_t round,
                             std::vector<std::int32_t>& stamp,
                             std::vector<std::int32_t>& collected) {
    collected.clear();
    const std::int32_t begin = tree_->leaves_[index(tree_->leaf_begin_[index(node)])].slot_begin;
    const std::int32_t end = tree_->leaves_[index(tree_->leaf_end_[index(node)] - 1)].slot_end;
    for (std::int32_t slot = begin; slot < end; ++slot)
      collect(tree_->corners(slot), round, stamp, collected);
    std::sort(collected.begin(), collected.end());
    DeformTree::Runs runs{};
    runs.four_begin = static_cast<std::int32_t>(tree_->fours_.size());
    runs.single_begin = static_cast<std::int32_t>(tree_->singles_.size());
    forEachRow(collected,
               [this](std::int32_t first, std::int32_t count) { inFours(first, count); });
    runs.four_end = static_cast<std::int32_t>(tree_->fours_.size());
    runs.single_end = static_cast<std::int32_t>(tree_->singles_.size());
    return runs;
  }

  // Calls f(begin, count) for vertices that stand side by side, ascending.
  template <class F>
  static void forEachRow(const std::vector<std::int32_t>& collected, F f) {
    for (auto first = collected.begin(); first != collected.end();) {
      auto last = first + 1;
      while (last != collected.end() && *last == *(last - 1) + 1) ++last;
      f(*first, static_cast<std::int32_t>(last - first));
      first = last;
    }
  }

  void addRows(const std::vector<std::int32_t>& collected, std::int32_t branch) {
    forEachRow(collected, [&](std::int32_t begin, std::int32_t count) {
      if (count >= 4) tree_->rows_.push_back({begin, count, branch});
    });
  }

  // The vertices begin .. begin + count - 1; the last four may begin among the ones before them.
  void inFours(std::int32_t begin, std::int32_t count) {
    if (count < 4) {
      for (std::int32_t i = 0; i < count; ++i) tree_->singles_.push_back(begin + i);
      return;
    }
    for (std::int32_t i = 0; i + 4 <= count; i += 4) tree_->fours_.push_back(begin + i);
    if (count % 4 != 0) tree_->fours_.push_back(begin + count - 4);
  }

  static void collect(const Triangle& corners, std::int32_t round, std::vector<std::int32_t>& stamp,
                      std::vector<std::int32_t>& collected) {
    for (const std::int32_t v : corners) collectOne(v, round, stamp, collected);
  }

  static void collectOne(std::int32_t v, std::int32_t round, std::vector<std::int32_t>& stamp,
                         std::vector<std::int32_t>& collected) {
    if (stamp[index(v)] == round) return;
    stamp[index(v)] = round;
    collected.push_back(v);
  }

  std::span<const Vector3d> vertices_;
  std::span<const Triangle> triangles_;
  std::vector<Box> boxes_;            // of the triangles, to nearest
  std::vector<std::int32_t> order_;   // triangles, permuted as the tree grows
  std::vector<Temporary> made_;       // a parent before its children
  std::vector<std::int32_t> number_;  // of a made node in the tree
  std::shared_ptr<DeformTree> tree_;
};

void WideBox::clear() {
  for (auto& axis : low) std::fill(axis, axis + kWidth, std::numeric_limits<float>::infinity());
  for (auto& axis : high) std::fill(axis, axis + kWidth, -std::numeric_limits<float>::infinity());
}

DeformTree::DeformTree(const DeformTree& other, std::pmr::memory_resource* memory)
    : nodes_(other.nodes_, memory),
      up_(other.up_, memory),
      leaf_begin_(other.leaf_begin_, memory),
      leaf_end_(other.leaf_end_, memory),
      leaves_(other.leaves_, memory),
      leaf_vertices_(other.leaf_vertices_, memory),
      refits_(other.refits_, memory),
      refit_vertices_(other.refit_vertices_, memory),
      refit_corners_(other.refit_corners_, memory),
      branches_(other.branches_, memory),
      rows_(other.rows_, memory),
      runs_(other.runs_, memory),
      fours_(other.fours_, memory),
      singles_(other.singles_, memory),
      slot_of_(other.slot_of_, memory),
      slots_(other.slots_, memory),
      upper_count_(other.upper_count_) {}

std::span<const std::int32_t> DeformTree::vertices(std::int32_t node, int lane) const {
  const std::int32_t child = nodes_[index(node)].child[lane];
  if (child == kNone) return {};
  std::int32_t first = 0, last = 0;
  if (isLeaf(child)) {
    first = leafOf(child);
    last = first + 1;
  } else {
    first = leaf_begin_[index(child)];
    last = leaf_end_[index(child)];
  }
  const auto begin = index(leaves_[index(first)].vertex_begin);
  const auto end = index(leaves_[index(last - 1)].vertex_end);
  return std::span<const std::int32_t>(leaf_vertices_).subspan(begin, end - begin);
}

std::uint64_t DeformTree::nextId() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

std::size_t DeformTree::bytes() const {
  return sizeof(*this) + nodes_.capacity() * sizeof(Node) + up_.capacity() * sizeof(Up) +
         (fours_.capacity() + singles_.capacity() + leaf_begin_.capacity() + leaf_end_.capacity() +
          leaf_vertices_.capacity() + slot_of_.capacity()) *
             sizeof(std::int32_t) +
         leaves_.capacity() * sizeof(Leaf) + branches_.capacity() * sizeof(Branch) +
         rows_.capacity() * sizeof(Row) + runs_.capacity() * sizeof(Runs) +
         refits_.capacity() * sizeof(Refit) + refit_vertices_.capacity() * sizeof(std::int32_t) +
         refit_corners_.capacity() + slots_.capacity() * sizeof(Slot);
}

std::shared_ptr<const DeformTree> buildDeformTree(std::span<const Vector3d> vertices,
                                                  std::span<const Triangle> triangles,
                                                  DeformMethod method, int split) {
  return DeformBuilder(vertices, triangles).build(method, split);
}

std::shared_ptr<const DeformTree> restructureDeformTree(const DeformTree& old,
                                                        std::span<const Vector3d> vertices,
                                                        std::span<const Triangle> triangles,
                                                        std::span<const std::int32_t> roots,
                                                        int split) {
  return DeformBuilder(vertices, triangles).restructure(old, roots, split);
}

}  // namespace leeway::collision
