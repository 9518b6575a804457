#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace leeway::collision {

/// An edge of a triangle.
struct EdgeUse {
  std::int32_t low, high;  ///< its corners
  std::int32_t triangle;
  std::int32_t side;  ///< it runs from corner `side` to the next
  bool forward;       ///< from low to high
};

/// Returns the edges of all triangles, sorted by low, high and triangle. Triangles that name a
/// vertex twice are left out: such a triangle uses an edge in both directions, and its neighbours
/// match without it. O(n + vertices), and O(k log k) for a vertex of k edges.
std::vector<EdgeUse> sortedEdges(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t vertices);

/// The connected parts of a set of triangles, and which of them are solids.
struct MeshComponents {
  std::vector<std::int32_t> component;  ///< of each triangle
  std::vector<std::uint8_t> closed;     ///< of each component: not 0 for a solid
  /// For each triangle: how often a crossing of it counts in the winding number of its component,
  /// modulo kCyclePrime (cycles.h). Empty: 1 for all.
  std::vector<std::uint64_t> weight;
  /// How many edges end the surface of what is in no solid, where it has an area; where none does,
  /// those where other than two of its triangles meet, and at least 1. 0 where all that is in no
  /// solid is in one plane: a flat sheet, not a solid.
  std::size_t open_edges = 0;
  /// The edges (low, high) between two vertices where a surface ends, whether it ends along them or
  /// not: where it could be closed, see crackFillers().
  std::vector<std::pair<std::int32_t, std::int32_t>> seams;

  /// Makes all of them surfaces that are meant so.
  void leaveOpen() {
    closed.assign(closed.size(), 0);
    open_edges = 0;
  }
};

/// Finds the solids of a set of triangles, however their facets are turned, repeated and shared.
///
///  1. Of triangles with the same three corners, one counts.
///  2. Triangles are joined across edges that exactly two of them share: to patches, whose
///  triangles
///     are turned the same way. A patch that cannot be (a Moebius strip) is a surface.
///  3. A combination of patches is closed when along every edge their borders cancel. All such
///     combinations together are a cycle (cycles.h). What a patch of it borders on is one
///     component, and closed: its inside is where the winding number is not 0. All other patches
///     are surfaces.
///
/// So a box is a solid that shares an edge or a facet with another one, or has a fin or a wall.
/// Triangles of a solid are turned outwards; where several solids share patches, each patch away
/// from their middle. For `open_edges`, triangles of at most this height [m] have no area. O(n log
/// n), and the elimination of largestCycle().
MeshComponents findComponents(std::span<const Eigen::Vector3d> vertices,
                              std::vector<std::array<std::int32_t, 3>>& triangles,
                              double thickness = 0);

}  // namespace leeway::collision
