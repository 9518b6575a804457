#pragma once

// Private to collision/: the hierarchy of a deforming mesh, without its bounds.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

namespace leeway::collision {

/// Children of a node, and lanes of its bounds.
inline constexpr int kWidth = 8;

/// Boxes of the eight children of a node, single precision, rounded outwards. A lane without a
/// child is empty: low = +inf, high = -inf.
struct alignas(64) WideBox {
  float low[3][kWidth];
  float high[3][kWidth];

  void clear();
};

/// One box, single precision, rounded outwards.
struct FloatBox {
  float low[3], high[3];
};

/// A hierarchy of fixed shape over the triangles of a mesh: nodes of up to eight children, leaves
/// of up to kLeafTriangles. Parents stand before their children. Bounds stand apart (WideBox, one a
/// node), because they change while this does not.
///
/// The nodes of every small subtree (a "branch", of up to `split` triangles) stand side by side,
/// behind all nodes above branches, so that the upper levels are a prefix of the array.
class DeformTree {
 public:
  DeformTree() = default;
  DeformTree(const DeformTree&) = delete;
  DeformTree& operator=(const DeformTree&) = delete;
  /// A copy whose arrays stand there.
  DeformTree(const DeformTree& other, std::pmr::memory_resource* memory);

  using Triangle = std::array<std::int32_t, 3>;
  static constexpr int kLeafTriangles = 8;
  static constexpr std::int32_t kNone = -1;
  /// No path from the root to a leaf has more nodes.
  static constexpr int kMaxDepth = 48;

  struct Node {
    /// A node when >= 0, leaf -2 - child when < -1, or kNone. Children come first, then kNone.
    std::int32_t child[kWidth];
  };
  struct Leaf {
    std::int32_t slot_begin, slot_end;      ///< its triangles
    std::int32_t vertex_begin, vertex_end;  ///< in leafVertices(): each of its vertices once
  };
  struct Up {
    std::int32_t parent;  ///< kNone for the root
    std::int32_t lane;
  };
  /// Vertices: four side by side each (some of them repeated), and those with fewer neighbours one
  /// by one.
  struct Runs {
    std::int32_t four_begin, four_end;      ///< in fours()
    std::int32_t single_begin, single_end;  ///< in singles()
  };
  /// Where a refit finds what the leaves of a node hold: counted from the end, so that the last
  /// node, whose turn comes first, stands first.
  struct Refit {
    std::int32_t vertices;  ///< in refitVertices(): before it those of the nodes behind
    std::int32_t corners;   ///< in refitCorners(), likewise
  };
  /// Vertices that stand in refitVertices() behind all others, so that it can be read ahead.
  static constexpr std::int32_t kAhead = 128;
  /// Four or more vertices of a branch that stand side by side.
  struct Row {
    std::int32_t begin, count;  ///< vertices
    std::int32_t branch;
  };
  struct Branch {
    std::int32_t root;
    Runs runs;  ///< in the order of the branches
  };

  std::span<const Node> nodes() const { return nodes_; }
  const Node& node(std::int32_t i) const { return nodes_[static_cast<std::size_t>(i)]; }
  std::int32_t nodeCount() const { return static_cast<std::int32_t>(nodes_.size()); }
  /// Nodes above all branches: 0 .. upperCount() - 1. At least 1 (the root).
  std::int32_t upperCount() const { return upper_count_; }
  const Up& up(std::int32_t node) const { return up_[static_cast<std::size_t>(node)]; }
  std::span<const Branch> branches() const { return branches_; }
  /// What the branches have in fours(), in the order of memory.
  std::span<const Row> rows() const { return rows_; }
  /// The vertices below a node of a branch that is not its root, each once.
  const Runs& runs(std::int32_t node) const {
    return runs_[static_cast<std::size_t>(node - upper_count_)];
  }
  /// The first of four vertices each.
  std::span<const std::int32_t> fours() const { return fours_; }
  std::span<const std::int32_t> singles() const { return singles_; }
  /// How many vertices of the branches stand apart from their neighbours there.
  std::int32_t branchSingles() const {
    return branches_.empty() ? 0 : branches_.back().runs.single_end;
  }

  /// One a node and one more: the node's own begin at refits()[node + 1] and end at refits()[node].
  std::span<const Refit> refits() const { return refits_; }
  /// Of each node, last node first, the vertices of its leaves: each once, but for some of the last
  /// again, so that they are a multiple of four.
  std::span<const std::int32_t> refitVertices() const { return refit_vertices_; }
  /// Of each node that has leaves, how many vertices its largest has, and for each lane as many
  /// places among the node's vertices: those of a leaf with fewer repeat the last one, and lanes
  /// without a leaf hold anything.
  std::span<const std::uint8_t> refitCorners() const { return refit_corners_; }

  static bool isLeaf(std::int32_t child) { return child < kNone; }
  static std::int32_t leafOf(std::int32_t child) { return -2 - child; }
  const Leaf& leaf(std::int32_t i) const { return leaves_[static_cast<std::size_t>(i)]; }
  std::int32_t leafCount() const { return static_cast<std::int32_t>(leaves_.size()); }
  /// Starts to bring the first eight leaves below a node near.
  void fetchLeaves(std::int32_t node) const {
    const Leaf* first =
        &leaves_[static_cast<std::size_t>(leaf_begin_[static_cast<std::size_t>(node)])];
    __builtin_prefetch(first);
    __builtin_prefetch(reinterpret_cast<const char*>(first) + 64);
  }
  std::span<const std::int32_t> leafVertices() const { return leaf_vertices_; }
  /// Starts to bring near the first vertices below a node of a branch; none of its root's.
  void fetchVertices(std::int32_t node, const Eigen::Vector3d* vertices) const {
    constexpr std::int32_t kMost = 16;  // fours
    const Runs& own = runs(node);
    const std::int32_t end = std::min(own.four_end, own.four_begin + kMost);
    for (std::int32_t i = own.four_begin; i < end; ++i) {
      const Eigen::Vector3d* first = vertices + fours_[static_cast<std::size_t>(i)];
      __builtin_prefetch(first);
      __builtin_prefetch(reinterpret_cast<const char*>(first) + 64);
    }
  }

  /// How many triangles are below a node.
  std::int32_t slotsBelow(std::int32_t node) const {
    const auto i = static_cast<std::size_t>(node);
    return leaves_[static_cast<std::size_t>(leaf_end_[i] - 1)].slot_end -
           leaves_[static_cast<std::size_t>(leaf_begin_[i])].slot_begin;
  }

  /// The vertices below a child of a node (some of them repeated); empty for kNone. O(1).
  std::span<const std::int32_t> vertices(std::int32_t node, int lane) const;

  /// Triangles in the order of the leaves stand in slots.
  std::int32_t triangleOf(std::int32_t slot) const {
    return slots_[static_cast<std::size_t>(slot)].triangle;
  }
  std::int32_t slotOf(std::int32_t triangle) const {
    return slot_of_[static_cast<std::size_t>(triangle)];
  }
  /// The three vertices of a slot's triangle.
  const Triangle& corners(std::int32_t slot) const {
    return slots_[static_cast<std::size_t>(slot)].corners;
  }
  std::int32_t triangleCount() const { return static_cast<std::int32_t>(slots_.size()); }
  /// Another number for every hierarchy of this process, > 0: addresses are used again.
  std::uint64_t id() const { return id_; }
  std::size_t bytes() const;

 private:
  friend class DeformBuilder;
  // Together, since whoever finds the nearest triangle by its corners tells which one it is.
  struct alignas(16) Slot {
    Triangle corners;
    std::int32_t triangle;
  };
  static std::uint64_t nextId();

  // Not the default resource: an embedding program may have made that one of a single thread, and
  // who gives a hierarchy up last may be any.
  static std::pmr::memory_resource* plain() { return std::pmr::new_delete_resource(); }

  std::pmr::vector<Node> nodes_{plain()};
  std::pmr::vector<Up> up_{plain()};
  std::pmr::vector<std::int32_t> leaf_begin_{plain()},
      leaf_end_{plain()};  // leaves below each node
  std::pmr::vector<Leaf> leaves_{plain()};
  std::pmr::vector<std::int32_t> leaf_vertices_{plain()};
  std::pmr::vector<Refit> refits_{plain()};
  std::pmr::vector<std::int32_t> refit_vertices_{plain()};
  std::pmr::vector<std::uint8_t> refit_corners_{plain()};
  std::pmr::vector<Branch> branches_{plain()};
  std::pmr::vector<Row> rows_{plain()};
  std::pmr::vector<Runs> runs_{plain()};  // one a node of a branch; empty for the roots
  std::pmr::vector<std::int32_t> fours_{plain()}, singles_{plain()};
  std::pmr::vector<std::int32_t> slot_of_{plain()};
  std::uint64_t id_ = nextId();  // read with what stands beside it
  std::pmr::vector<Slot> slots_{plain()};
  std::int32_t upper_count_ = 0;
};

}  // namespace leeway::collision
