#pragma once

// Private to collision/: a hierarchy under construction.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// The box of one or more triangles, in single precision, rounded to nearest: it is used for
/// choosing cuts, not for bounds.
struct DraftBox {
  float low[3] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                  std::numeric_limits<float>::infinity()};
  float high[3] = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                   -std::numeric_limits<float>::infinity()};

  void add(const DraftBox& other) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
  }
  /// Twice the centre.
  float middle(int axis) const { return low[axis] + high[axis]; }
  /// Half the surface area; products of coordinates stay within single precision.
  float area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
};

/// Places begin .. end - 1 in TreeDraft::order or, for leaves, in TreeDraft::leaves.
struct DraftRange {
  std::int32_t begin, end;
  std::int32_t count() const { return end - begin; }
};

/// The output of the builders (binned_builder.cc, morton_builder.cc), which tree_layout.cc turns
/// into a DeformTree: nodes in the order of creation, parents before their children.
class TreeDraft {
 public:
  struct Node {
    std::array<std::int32_t, kWidth> child;  ///< as DeformTree::Node, by place in nodes()
    DraftRange leaves;                       ///< below it
    std::int32_t triangles;                  ///< below it [count]
  };

  TreeDraft(std::span<const Eigen::Vector3d> vertices,
            std::span<const DeformTree::Triangle> triangles);

  std::int32_t newNode();
  void setChild(std::int32_t node, std::size_t lane, std::int32_t child) {
    nodes_[static_cast<std::size_t>(node)].child[lane] = child;
  }
  /// Must be called after everything below the node has been made.
  void endNode(std::int32_t node, std::int32_t triangles);
  /// Returns the leaf as a child, see DeformTree::Node. Sorts its triangles by number, which brings
  /// them closer together in memory.
  std::int32_t newLeaf(DraftRange range);

  /// All triangles.
  DraftRange all() const { return {0, static_cast<std::int32_t>(order.size())}; }
  const DraftBox& box(std::int32_t triangle) const {
    return boxes_[static_cast<std::size_t>(triangle)];
  }
  const DraftBox& boxAt(std::int32_t place) const {
    return box(order[static_cast<std::size_t>(place)]);
  }
  /// The box of a range of triangles.
  DraftBox bound(DraftRange range) const;
  /// Least and largest middle() of a range of triangles along each axis.
  void middles(DraftRange range, float* least, float* largest) const;

  std::span<const Node> nodes() const { return nodes_; }
  std::span<const DraftRange> leaves() const { return leaves_; }

  std::vector<std::int32_t> order;  ///< triangles, permuted by the builders; their places: slots

 private:
  std::vector<DraftBox> boxes_;  // one for each triangle
  std::vector<Node> nodes_;
  std::vector<DraftRange> leaves_;
};

/// The limit on the triangles below a child of a node with `count` triangles, if all nodes are
/// full.
std::int32_t childCapacity(std::int32_t count);

/// Surface area heuristic over bins (I. Wald, "On fast construction of SAH-based bounding volume
/// hierarchies", 2007), down to pieces of a few hundred triangles, which are halved at the median.
/// `depth`: nodes above. Returns the node. O(n log n).
std::int32_t buildBinned(TreeDraft& draft, DraftRange range, int depth);

/// Along a Morton curve (C. Lauterbach et al., "Fast BVH construction on GPUs", 2009). O(n).
std::int32_t buildMorton(TreeDraft& draft);

/// The finished hierarchy: nodes in the order of DeformTree, and all data that updates and queries
/// read.
std::shared_ptr<const DeformTree> layOut(const TreeDraft& draft, std::size_t vertex_count,
                                         std::span<const DeformTree::Triangle> triangles,
                                         int split);

}  // namespace leeway::collision
