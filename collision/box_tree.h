#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

/// An oriented box around points x: |axis_k . (x - center)| <= half_k for k = 0, 1, 2, as exact
/// real numbers, whatever the axes' own rounding; their lengths are 1 and their angles right within
/// 2^-21.
struct OrientedBox {
  float center[3];
  float axis[3][3];  ///< axis[k] is a vector
  float half[3];
};

/// Up to kWidth boxes in vector-friendly order, and what is in each.
struct BoxNode {
  static constexpr int kWidth = 8;

  alignas(32) float center[3][kWidth];
  alignas(32) float axis[3][3][kWidth];  ///< axis[k][coordinate][lane]
  alignas(32) float half[3][kWidth];
  alignas(32) float radius[kWidth];  ///< half the diagonal
  std::int32_t child[kWidth];        ///< >= 0: a node; < 0: the triangle in slot ~child
  std::int32_t count;

  OrientedBox box(int lane) const;
};

/// A hierarchy of oriented boxes over the triangles of a mesh, eight to a node (S. Gottschalk, M.
/// C. Lin, D. Manocha, "OBBTree", 1996; I. Wald, C. Benthin, S. Boulos, "Getting rid of packets",
/// 2008, for wide nodes). Every triangle has a box of its own. Single precision, rounded outwards:
/// a filter.
class BoxTree {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// No path from the root is longer.
  static constexpr int kMaxDepth = 48;

  /// `slot_of` numbers the triangles as `child` is to name them. O(n log n).
  BoxTree(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles,
          std::span<const std::int32_t> slot_of, double extent);

  /// False when the coordinates are out of the range of single precision: then there are no nodes.
  bool usable() const { return !nodes_.empty(); }
  /// Node 0 has one box only, that of the whole mesh.
  const BoxNode& node(int i) const { return nodes_[static_cast<std::size_t>(i)]; }
  std::size_t bytes() const { return nodes_.capacity() * sizeof(BoxNode); }

 private:
  struct Input;
  struct Piece;
  std::int32_t build(Input& input, const Piece& whole, int depth);
  void setLane(std::int32_t node, int lane, const Piece& piece, const Input& input);

  std::vector<BoxNode> nodes_;
};

}  // namespace leeway::collision
