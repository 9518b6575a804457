#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

/// A use of an edge by a triangle.
struct EdgeUse {
  std::int32_t low, high;  ///< its corners
  std::int32_t triangle;
  std::int32_t side;  ///< the edge is that from corner `side` to the next
  bool forward;       ///< which is from low to high
};

/// The edges of all triangles but those that name a vertex twice (such a one uses an edge in both
/// directions: its neighbours match without it), by low, high and triangle. O(n + vertices), and
/// O(k log k) for a vertex of k edges.
std::vector<EdgeUse> sortedEdges(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t vertices);

/// The connected parts of a set of triangles.
struct MeshComponents {
  std::vector<std::int32_t> component;  ///< one a triangle
  std::vector<std::uint8_t> closed;     ///< one a component: not 0 for a solid
};

/// Components by edges that share both vertex indices. One whose edges are each shared by exactly
/// two triangles of opposite direction is closed; triangles are turned where that makes a component
/// consistent, so that it encloses positive volume at `vertices`. O(n log n).
MeshComponents findComponents(std::span<const Eigen::Vector3d> vertices,
                              std::vector<std::array<std::int32_t, 3>>& triangles);

}  // namespace leeway::collision
