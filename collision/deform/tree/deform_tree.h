#pragma once

// Private to collision/: the hierarchy of a deforming mesh, without its bounds.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory_resource>
#include <span>
#include <vector>

namespace leeway::collision {

/// Number of children of a node, each with one column of the node's bounds.
inline constexpr int kWidth = 8;

/// Boxes of the eight children of a node, single precision, rounded outwards. A column without a
/// child is empty: low = +inf, high = -inf.
struct alignas(64) WideBox {
  float low[3][kWidth];
  float high[3][kWidth];

  /// Empties the columns from `first` on.
  void clear(int first = 0) {
    for (int k = 0; k < 3; ++k) {
      std::fill(low[k] + first, low[k] + kWidth, std::numeric_limits<float>::infinity());
      std::fill(high[k] + first, high[k] + kWidth, -std::numeric_limits<float>::infinity());
    }
  }
};

/// One box in single precision, rounded outwards.
struct FloatBox {
  float low[3], high[3];
};

/// A hierarchy of fixed shape over the triangles of a mesh: nodes of up to eight children, leaves
/// of up to kLeafTriangles. Bounds are stored separately (one WideBox for each node), because they
/// change with every update and the tree does not.
///
/// Order of the nodes: parents before their children, so that a refit is one backward loop. A
/// branch is a maximal subtree of up to `split` triangles. The nodes of a branch are consecutive,
/// and all branches follow all nodes above them, so the upper levels are a prefix of the array.
///
/// Slots are the triangles in the order of the leaves.
class DeformTree {
 public:
  DeformTree() = default;
  DeformTree(const DeformTree&) = delete;
  DeformTree& operator=(const DeformTree&) = delete;
  /// A copy with its arrays in `memory`.
  DeformTree(const DeformTree& other, std::pmr::memory_resource* memory);

  using Triangle = std::array<std::int32_t, 3>;
  static constexpr int kLeafTriangles = 8;
  static constexpr std::int32_t kNone = -1;
  /// Limit on the nodes of a path from the root to a leaf.
  static constexpr int kMaxDepth = 48;

  struct Node {
    /// >= 0: a node; < -1: leaf -2 - child; kNone: no child. Columns without a child are last.
    std::int32_t child[kWidth];
  };
  struct Leaf {
    std::int32_t slot_begin, slot_end;      ///< its triangles
    std::int32_t vertex_begin, vertex_end;  ///< in leafVertices(): each of its vertices once
  };
  /// The column of its parent that holds a node's box.
  struct Up {
    std::int32_t parent;  ///< kNone for the root
    std::int32_t column;
  };
  /// Vertices below a node. Runs of four or more consecutive vertices are listed as fours, the last
  /// of which may overlap the previous one; shorter runs are listed vertex by vertex.
  struct Runs {
    std::int32_t four_begin, four_end;      ///< in fours()
    std::int32_t single_begin, single_end;  ///< in singles()
  };
  /// Positions of the leaf vertices of a node for a refit. The last node is first, as in the refit.
  struct RefitOffsets {
    std::int32_t vertices;  ///< in refitVertices()
    std::int32_t corners;   ///< in refitCorners()
  };
  /// Padding after the end of refitVertices(), so that prefetching may read ahead [count].
  static constexpr std::int32_t kAhead = 128;
  /// Four or more consecutive vertices of a branch.
  struct Row {
    std::int32_t begin, count;  ///< vertices
    std::int32_t branch;
  };
  struct Branch {
    std::int32_t root;
    Runs runs;  ///< fours and singles are consecutive, in the order of the branches
  };

  std::span<const Node> nodes() const { return nodes_; }
  const Node& node(std::int32_t i) const { return nodes_[static_cast<std::size_t>(i)]; }
  std::int32_t nodeCount() const { return static_cast<std::int32_t>(nodes_.size()); }
  /// Nodes above all branches: 0 .. upperCount() - 1. At least 1 (the root).
  std::int32_t upperCount() const { return upper_count_; }
  const Up& up(std::int32_t node) const { return up_[static_cast<std::size_t>(node)]; }
  std::span<const Branch> branches() const { return branches_; }
  /// The runs of all branches that fours() holds, in the order of memory.
  std::span<const Row> rows() const { return rows_; }
  /// The vertices below a node of a branch (not its root), each once.
  const Runs& runs(std::int32_t node) const {
    return runs_[static_cast<std::size_t>(node - upper_count_)];
  }
  /// The first vertex of each four consecutive ones.
  std::span<const std::int32_t> fours() const { return fours_; }
  std::span<const std::int32_t> singles() const { return singles_; }
  /// Vertices of branches that are read one by one: a measure of how scattered memory is [count].
  std::int32_t branchSingles() const {
    return branches_.empty() ? 0 : branches_.back().runs.single_end;
  }

  /// nodeCount() + 1 entries: node i's range begins at [i + 1] and ends at [i].
  std::span<const RefitOffsets> refitOffsets() const { return refit_offsets_; }
  /// The leaf vertices of each node, last node first: each once, with the last one repeated up to a
  /// multiple of four.
  std::span<const std::int32_t> refitVertices() const { return refit_vertices_; }
  /// For each node with leaves: the vertex count of its largest leaf, then that many places for
  /// each column, counted within the node's refitVertices(). Smaller leaves repeat their last
  /// place; columns without a leaf have arbitrary places.
  std::span<const std::uint8_t> refitCorners() const { return refit_corners_; }

  static bool isLeaf(std::int32_t child) { return child < kNone; }
  static std::int32_t leafOf(std::int32_t child) { return -2 - child; }
  const Leaf& leaf(std::int32_t i) const { return leaves_[static_cast<std::size_t>(i)]; }
  std::int32_t leafCount() const { return static_cast<std::int32_t>(leaves_.size()); }
  /// Prefetches the first eight leaves below a node.
  void fetchLeaves(std::int32_t node) const {
    const Leaf* first =
        &leaves_[static_cast<std::size_t>(leaf_begin_[static_cast<std::size_t>(node)])];
    __builtin_prefetch(first);
    __builtin_prefetch(reinterpret_cast<const char*>(first) + 64);
  }
  std::span<const std::int32_t> leafVertices() const { return leaf_vertices_; }
  /// Prefetches the first vertices below a node of a branch; does nothing for the branch's root.
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

  /// The slots below a node are slotBegin(node) .. slotBegin(node) + slotsBelow(node) - 1.
  std::int32_t slotBegin(std::int32_t node) const {
    return leaves_[static_cast<std::size_t>(leaf_begin_[static_cast<std::size_t>(node)])]
        .slot_begin;
  }
  std::int32_t slotsBelow(std::int32_t node) const {
    return leaves_[static_cast<std::size_t>(leaf_end_[static_cast<std::size_t>(node)] - 1)]
               .slot_end -
           slotBegin(node);
  }

  /// The vertices below a child of a node (some of them repeated); empty for kNone. O(1).
  std::span<const std::int32_t> vertices(std::int32_t node, int column) const;

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
  /// Unique in this process, > 0. Addresses are not unique, because memory is reused.
  std::uint64_t id() const { return id_; }
  std::size_t bytes() const;

 private:
  friend class TreeLayout;
  // One cache line for both, because a query that reads the corners of the nearest triangle reports
  // its number next.
  struct alignas(16) Slot {
    Triangle corners;
    std::int32_t triangle;
  };
  static std::uint64_t nextId();

  // Not the default resource, because an embedding program may have set one that belongs to one
  // thread, and any thread may release the tree.
  static std::pmr::memory_resource* plain() { return std::pmr::new_delete_resource(); }

  std::pmr::vector<Node> nodes_{plain()};
  std::pmr::vector<Up> up_{plain()};
  std::pmr::vector<std::int32_t> leaf_begin_{plain()},
      leaf_end_{plain()};  // leaves below each node
  std::pmr::vector<Leaf> leaves_{plain()};
  std::pmr::vector<std::int32_t> leaf_vertices_{plain()};
  std::pmr::vector<RefitOffsets> refit_offsets_{plain()};
  std::pmr::vector<std::int32_t> refit_vertices_{plain()};
  std::pmr::vector<std::uint8_t> refit_corners_{plain()};
  std::pmr::vector<Branch> branches_{plain()};
  std::pmr::vector<Row> rows_{plain()};
  std::pmr::vector<Runs> runs_{plain()};  // one for each node of a branch; empty for the roots
  std::pmr::vector<std::int32_t> fours_{plain()}, singles_{plain()};
  std::pmr::vector<std::int32_t> slot_of_{plain()};
  std::uint64_t id_ = nextId();  // next to the slots, with which it is read
  std::pmr::vector<Slot> slots_{plain()};
  std::int32_t upper_count_ = 0;
};

/// The box of those vertices of a branch that have been read so far: x, y, z, x, ... of several
/// vertices.
struct alignas(64) BranchBox {
  double low[12], high[12];
};

}  // namespace leeway::collision
