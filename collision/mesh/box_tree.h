#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <span>
#include <vector>

#include "collision/base/large_pages.h"

namespace leeway::collision {

/// An oriented box: the points x with |axis_k . (x - center)| <= half_k for k = 0, 1, 2, in exact
/// arithmetic with the axes as stored. The axes are orthonormal to within 2^-21.
struct OrientedBox {
  float center[3];
  float axis[3][3];  ///< axis[k] is a vector
  float half[3];
};

/// Up to kWidth boxes, as columns for vector registers, and their contents.
struct BoxNode {
  static constexpr int kWidth = 8;

  alignas(32) float center[3][kWidth];
  alignas(32) float axis[3][3][kWidth];  ///< axis[k][coordinate][column]
  alignas(32) float half[3][kWidth];
  alignas(32) float radius[kWidth];  ///< half the diagonal
  /// >= 0: a node; < 0: the triangle in slot ~child or, from BoxTree::firstPiece() on, a convex
  /// piece
  std::int32_t child[kWidth];
  std::int32_t count;

  OrientedBox box(int column) const;
};

/// A hierarchy of oriented boxes over the triangles of a mesh, with eight boxes in each node (S.
/// Gottschalk, M. C. Lin, D. Manocha, "OBBTree", 1996; I. Wald, C. Benthin, S. Boulos, "Getting rid
/// of packets", 2008, for wide nodes). Every triangle and every convex piece has a box. Above them
/// is a hierarchy of pieces and loose triangles; below each piece is a hierarchy of its triangles.
/// The tree is in single precision, rounded outwards, and serves as a filter. Its coordinates are
/// relative to a point near the mesh, because those of a mesh far from its origin would lose as
/// many digits as the distance has.
class BoxTree {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// Limit on the length of a path from the root.
  static constexpr int kMaxDepth = 48;

  /// Coordinates of boxes are relative to `origin`. `slot_of` has the number of each triangle in
  /// `child`, and `piece_of` its convex piece, 0 to `pieces` - 1 (each of at least two triangles),
  /// or -1. O(n log n).
  BoxTree(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3d& origin,
          std::span<const Triangle> triangles, std::span<const std::int32_t> slot_of, double extent,
          std::span<const std::int32_t> piece_of, int pieces);

  /// Makes the tree from the nodes in a file, as nodes() returned them. Null if they are not a tree
  /// over `triangles` triangles and `pieces` pieces: each must occur once, nodes must be in
  /// preorder, depth is limited and boxes must be finite. It does not check that the boxes contain
  /// their contents. O(n).
  static std::unique_ptr<const BoxTree> fromNodes(std::pmr::vector<BoxNode> nodes,
                                                  std::size_t triangles, int pieces);

  std::span<const BoxNode> nodes() const { return nodes_; }
  /// False if coordinates are out of the range of single precision; there are no nodes in that
  /// case.
  bool usable() const { return !nodes_.empty(); }
  /// Node 0 has one box, the box of the whole mesh.
  const BoxNode& node(int i) const { return nodes_[static_cast<std::size_t>(i)]; }
  /// ~child of piece 0; the numbers of the other pieces follow.
  std::int32_t firstPiece() const { return first_piece_; }
  /// The node of a piece's triangles.
  std::int32_t pieceNode(int piece) const { return piece_node_[static_cast<std::size_t>(piece)]; }
  /// Upper bound on the distance of the boxes' centres from the origin of their coordinates [m].
  double reach() const { return reach_; }
  std::size_t bytes() const {
    return nodes_.capacity() * sizeof(BoxNode) + piece_node_.capacity() * sizeof(std::int32_t);
  }

 private:
  struct Input;
  struct Cluster;
  struct Builder;
  struct Check;
  BoxTree() = default;
  void setReach();
  static void setColumn(BoxNode& node, int column, const Cluster& cluster, const Input& input);

  std::pmr::vector<BoxNode> nodes_{largeArrays()};
  std::vector<std::int32_t> piece_node_;
  std::int32_t first_piece_ = 0;
  double reach_ = 0;
};

}  // namespace leeway::collision
