#include "collision/mesh/hull_excess.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "collision/base/tolerances.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/point_triangle.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

// A part of a facet.
struct Piece {
  std::array<Vector3d, 3> corner;
  int slot;  // of a triangle near it
};

using Polygon = std::vector<Vector3d>;

class Search {
 public:
  Search(std::span<const Vector3d> vertices, const MeshTree& tree) : tree_(tree) {
    size_ = tree.extent();
    const HullBuilder hull(vertices);
    const auto at = [&](std::int32_t i) { return vertices[static_cast<std::size_t>(i)]; };
    for (const auto& f : hull.facets()) start(at(f[0]), at(f[1]), at(f[2]));
    for (std::size_t i = 2; i < hull.outline().size(); ++i) {
      start(at(hull.outline()[0]), at(hull.outline()[i - 1]), at(hull.outline()[i]));
    }
    if (hull.dimension() == 1)
      start(at(hull.vertices()[0]), at(hull.vertices()[1]), at(hull.vertices()[1]));
  }

  double run() {
    long budget = kExcessPieces + 4 * static_cast<long>(stack_.size());
    while (!stack_.empty()) {
      const Piece piece = stack_.back();
      stack_.pop_back();
      const double bound = boundOf(piece.corner.data(), 3, piece.slot);
      if (accept(bound)) continue;
      if (--budget < 0) {
        accepted_ = std::max(accepted_, bound);
        continue;
      }
      refine(piece);
    }
    return accepted_;
  }

 private:
  void start(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    Piece piece{{a, b, c}, 0};
    piece.slot = nearest((a + b + c) / 3, 0);
    stack_.push_back(piece);
  }

  double distance(const Vector3d& p, int slot) const {
    const Vector3d* v = tree_.corners(slot);
    const double d = (p - closestPointOnTriangle(p, v[0], v[1], v[2])).norm();
    return d * (1 + kRelativeRounding) + size_ * kRelativeRounding;
  }

  // An upper bound on the distance of the polygon's points from the triangle in a slot.
  double boundOf(const Vector3d* corners, std::size_t count, int slot) const {
    double bound = 0;
    for (std::size_t i = 0; i < count; ++i) bound = std::max(bound, distance(corners[i], slot));
    return bound;
  }

  // Whether a part with this bound needs no refinement.
  bool accept(double bound) {
    if (bound > std::max({accepted_, kExcessTolerance * std::min(size_, 1.0), kExcessRatio * met_}))
      return false;
    accepted_ = std::max(accepted_, bound);
    return true;
  }

  // The slot of the triangle nearest to p. This is a heuristic, which affects only the quality of
  // the bound. Records the largest distance.
  int nearest(const Vector3d& p, int slot) {
    double best = distance(p, slot);
    std::array<int, 2 * MeshTree::kMaxDepth> stack;
    std::size_t size = 0;
    stack[size++] = 0;
    const auto boxDistance = [&](const MeshNode& n) {
      return (n.low - p).cwiseMax(p - n.high).cwiseMax(0.0).norm();
    };
    while (size > 0) {
      const int id = stack[--size];
      const MeshNode& node = tree_.node(id);
      if (boxDistance(node) >= best) continue;
      if (node.isLeaf()) {
        for (int s = node.triangle_begin; s < node.triangle_end; ++s) {
          const double d = distance(p, s);
          if (d >= best) continue;
          best = d;
          slot = s;
        }
        continue;
      }
      int near = id + 1, far = node.right;
      if (boxDistance(tree_.node(far)) < boxDistance(tree_.node(near))) std::swap(near, far);
      stack[size++] = far;
      stack[size++] = near;
    }
    met_ = std::max(met_, best);
    return slot;
  }

  void push(const Polygon& polygon, int slot) {
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      stack_.push_back({{polygon[0], polygon[i - 1], polygon[i]}, slot});
    }
  }

  // Where the hull lies (nearly) on the mesh, cuts follow the triangle's edges: the part over the
  // triangle is finished, and the rest of the piece is kept. False if the piece is not near the
  // triangle.
  bool cutOut(const Piece& piece, int slot) {
    const Vector3d* v = tree_.corners(slot);
    const Vector3d normal = (v[1] - v[0]).cross(v[2] - v[0]);
    Polygon inside(piece.corner.begin(), piece.corner.end());
    std::vector<Polygon> outside;
    for (int k = 0; k < 3 && inside.size() >= 3; ++k) {
      Polygon rest;
      cut(inside, v[k], normal.cross(v[(k + 1) % 3] - v[k]), rest);
      if (rest.size() >= 3) outside.push_back(std::move(rest));
    }
    if (inside.size() < 3 || outside.empty()) return false;
    if (!accept(boundOf(inside.data(), inside.size(), slot))) return false;
    for (const Polygon& polygon : outside) push(polygon, slot);
    return true;
  }

  void refine(const Piece& piece) {
    const Vector3d center = (piece.corner[0] + piece.corner[1] + piece.corner[2]) / 3;
    const int slot = nearest(center, piece.slot);
    const double bound = boundOf(piece.corner.data(), 3, slot);
    if (accept(bound)) return;
    std::size_t longest = 0;
    double length = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double l = (piece.corner[(k + 1) % 3] - piece.corner[k]).squaredNorm();
      if (l <= length) continue;
      length = l;
      longest = k;
    }
    // Halving is fast for a piece about as long as the excess, and far too slow for a much longer
    // one.
    if (std::sqrt(length) > 64 * met_ && cutOut(piece, slot)) return;
    const Vector3d &a = piece.corner[longest], &b = piece.corner[(longest + 1) % 3],
                   &c = piece.corner[(longest + 2) % 3];
    const Vector3d middle = 0.5 * (a + b);
    stack_.push_back({{a, middle, c}, slot});
    stack_.push_back({{middle, b, c}, slot});
  }

  // Splits a polygon by the plane through `point`: `polygon` keeps the side that `direction` points
  // to, `rest` gets the other side. New corners are on edges up to rounding, which distance()
  // covers.
  static void cut(Polygon& polygon, const Vector3d& point, const Vector3d& direction,
                  Polygon& rest) {
    Polygon kept;
    bool any_kept = false, any_rest = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double side_p = direction.dot(p - point), side_q = direction.dot(q - point);
      (side_p >= 0 ? kept : rest).push_back(p);
      any_kept = any_kept || side_p > 0;
      any_rest = any_rest || side_p < 0;
      if ((side_p >= 0) == (side_q >= 0)) continue;
      const double t = std::clamp(side_p / (side_p - side_q), 0.0, 1.0);
      const Vector3d middle = p + t * (q - p);
      kept.push_back(middle);
      rest.push_back(middle);
    }
    if (!any_rest) {
      rest.clear();
      return;
    }
    if (!any_kept) {
      rest = polygon;
      kept.clear();
    }
    polygon = std::move(kept);
  }

  const MeshTree& tree_;
  std::vector<Piece> stack_;
  double size_ = 0;
  double accepted_ = 0;  // the largest bound of a finished piece
  double met_ = 0;       // the largest distance so far of a point of the hull from the mesh
};

}  // namespace

double hullExcess(std::span<const Vector3d> vertices, const MeshTree& tree) {
  return Search(vertices, tree).run();
}

}  // namespace leeway::collision
