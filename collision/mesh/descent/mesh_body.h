#pragma once

// Private to collision/: one interface to meshes and convex shapes for descents over oriented
// boxes.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/mesh/box_tree.h"
#include "collision/mesh/descent/mesh_descent.h"

namespace leeway::collision {

/// The content of a box of MeshBody: a node, a triangle (by its slot), a convex piece, or a convex
/// body as a whole.
struct Part {
  enum class Kind : unsigned char { kNode, kTriangle, kPiece, kBody };
  Kind kind;
  std::int32_t number;  ///< of the node, slot or piece
};

inline bool operator==(const Part& l, const Part& r) {
  return l.kind == r.kind && l.number == r.number;
}

/// One of two bodies: a mesh with its boxes and pieces, or a convex shape. Boxes are numbered by
/// node and column, node * kWidth + column; -1 is the box of a convex body. Coordinates of boxes
/// are relative to origin().
class MeshBody {
  using Kind = Part::Kind;

 public:
  explicit MeshBody(const DescentSide& side) : tree_(side.tree), view_(side.view) {
    if (tree_ != nullptr) {
      extent_ = tree_->extent();
      origin_ = tree_->middle();
      reach_ = tree_->boxes().reach();
      return;
    }
    extent_ = side.extent;
    origin_ = 0.5 * side.low + 0.5 * side.high;
    box_ = {};
    for (int k = 0; k < 3; ++k) {
      box_.axis[k][k] = 1;
      box_.half[k] =
          roundedUpToFloat(std::max(side.high[k] - origin_[k], origin_[k] - side.low[k]) +
                           kRelativeRounding * extent_);
    }
    const auto square = [&](int k) {
      return static_cast<double>(box_.half[k]) * static_cast<double>(box_.half[k]);
    };
    radius_ = roundedUpToFloat(std::sqrt(square(0) + square(1) + square(2)));
  }

  bool isMesh() const { return tree_ != nullptr; }
  const MeshTree& tree() const { return *tree_; }
  double extent() const { return extent_; }
  const Vector& origin() const { return origin_; }
  /// Upper bound on the distance of the boxes' centres from origin() [m].
  double reach() const { return reach_; }
  std::int32_t root() const { return isMesh() ? 0 : -1; }
  bool consistsOfPieces() const { return !isMesh() || tree_->pieceCount() > 0; }

  /// The content of a box; with `open` a convex piece is replaced by the node of its triangles.
  Part part(std::int32_t box, bool open) const {
    if (!isMesh()) return {Kind::kBody, 0};
    const std::int32_t child = node(box).child[box % BoxNode::kWidth];
    if (child >= 0) return {Kind::kNode, child};
    const std::int32_t first = tree_->boxes().firstPiece();
    if (~child < first) return {Kind::kTriangle, ~child};
    const std::int32_t piece = ~child - first;
    if (open) return {Kind::kNode, tree_->boxes().pieceNode(piece)};
    return {Kind::kPiece, piece};
  }
  const BoxNode& node(std::int32_t box) const { return tree_->boxes().node(box / BoxNode::kWidth); }
  /// Upper bound on the distance of the points of a box from its centre [m].
  float radius(std::int32_t box) const {
    return isMesh() ? node(box).radius[box % BoxNode::kWidth] : radius_;
  }
  Vector center(std::int32_t box) const {
    const auto vector = [](float x, float y, float z) {
      return Vector(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
    };
    if (!isMesh()) return vector(box_.center[0], box_.center[1], box_.center[2]);
    const BoxNode& n = node(box);
    const std::int32_t column = box % BoxNode::kWidth;
    return vector(n.center[0][column], n.center[1][column], n.center[2][column]);
  }
  OrientedBox box(std::int32_t box) const {
    return isMesh() ? node(box).box(box % BoxNode::kWidth) : box_;
  }
  ConvexView view(const Part& part) const {
    return part.kind == Kind::kTriangle ? tree_->triangleView(part.number)
           : part.kind == Kind::kPiece  ? tree_->pieceView(part.number)
                                        : view_;
  }
  double excess(const Part& part) const {
    return part.kind == Kind::kPiece ? tree_->pieceExcess(part.number) : 0;
  }
  ConvexView hull() const { return isMesh() ? tree_->hullView() : view_; }
  int triangleOf(const Part& part) const {
    return part.kind == Kind::kTriangle ? tree_->triangleOf(part.number) : -1;
  }
  /// Triangles and pieces in one numbering, for a cache. partOf() is false for other numbers.
  int numberOf(const Part& part) const {
    return part.kind == Kind::kPiece ? tree_->triangleCount() + part.number : triangleOf(part);
  }
  bool partOf(int number, Part& part) const {
    if (!isMesh()) {
      part = {Kind::kBody, 0};
      return true;
    }
    const int triangles = tree_->triangleCount();
    if (number < 0 || number >= triangles + tree_->pieceCount()) return false;
    part = number < triangles ? Part{Kind::kTriangle, tree_->slotOf(number)}
                              : Part{Kind::kPiece, number - triangles};
    return true;
  }

 private:
  const MeshTree* tree_;
  ConvexView view_;  // of a convex body
  OrientedBox box_;  // around it
  float radius_ = 0;
  double extent_ = 0, reach_ = 0;
  Vector origin_;
};

/// A placement of A's points in B as one of A's boxes in the coordinates of B's: `X` may be any
/// linear map. Rounding moves points by less than boxRounding().
inline Pose boxPlacement(const Pose& X, const MeshBody& a, const MeshBody& b) {
  return {X.rotation, placed(X, a.origin()) - b.origin()};
}
/// How far rounding of boxPlacement(), and of what it places, moves points [m]. `distance`: between
/// the bodies' frames.
inline double boxRounding(const MeshBody& a, const MeshBody& b, double distance) {
  return kRelativeRounding * (a.extent() + b.extent() + distance);
}

/// The box in another frame, rounded; boxGaps() accounts for that rounding.
inline OrientedBox placedBox(const OrientedBox& box, const Pose& X) {
  OrientedBox result;
  const Vector center =
      placed(X, Vector(static_cast<double>(box.center[0]), static_cast<double>(box.center[1]),
                       static_cast<double>(box.center[2])));
  float R[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) R[i][k] = static_cast<float>(X.rotation(i, k));
  }
  for (int i = 0; i < 3; ++i) {
    result.center[i] = static_cast<float>(center[i]);
    result.half[i] = box.half[i];
    for (int k = 0; k < 3; ++k) {
      result.axis[k][i] =
          R[i][0] * box.axis[k][0] + R[i][1] * box.axis[k][1] + R[i][2] * box.axis[k][2];
    }
  }
  return result;
}

/// Whether a body has a box: it is neither a half-space nor a point.
inline bool isBounded(const DescentSide& side) {
  return side.tree != nullptr || (side.extent > 0 && std::isfinite(side.extent));
}

/// Whether it is a mesh with convex pieces.
inline bool hasPieces(const DescentSide& side) {
  return side.tree != nullptr && side.tree->boxes().usable() && side.tree->pieceCount() > 0;
}

}  // namespace leeway::collision
