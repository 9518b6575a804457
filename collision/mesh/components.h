#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

/// An edge of a triangle.
struct EdgeUse {
  std::int32_t low, high;  ///< its corners
  std::int32_t triangle;
  std::int32_t side;  ///< it runs from corner `side` to the next
  bool forward;       ///< from low to high
};

/// The edges of all triangles, sorted by low, high and triangle; but for triangles that name a
/// vertex twice: such a triangle uses an edge in both directions, and its neighbours match without
/// it. O(n + vertices), and O(k log k) for a vertex of k edges.
std::vector<EdgeUse> sortedEdges(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t vertices);

/// The connected parts of a set of triangles.
struct MeshComponents {
  std::vector<std::int32_t> component;  ///< of each triangle
  std::vector<std::uint8_t> closed;     ///< of each component: not 0 for a solid
};

/// Components are connected by edges with the same two vertices. A component is closed when each of
/// its edges is shared by exactly two triangles of opposite direction; triangles are flipped where
/// that makes a component consistent, and so that it encloses positive volume. O(n log n).
MeshComponents findComponents(std::span<const Eigen::Vector3d> vertices,
                              std::vector<std::array<std::int32_t, 3>>& triangles);

}  // namespace leeway::collision
