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

/// Returns the edges of all triangles, sorted by low, high and triangle. Triangles that use a
/// vertex twice are omitted, because such a triangle uses an edge in both directions and its
/// neighbours match without it. O(n + vertices), and O(k log k) for a vertex of k edges.
std::vector<EdgeUse> sortedEdges(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t vertices);

/// The connected parts of a set of triangles, and which of them are solids.
struct MeshComponents {
  std::vector<std::int32_t> component;  ///< of each triangle
  std::vector<std::uint8_t> closed;     ///< for each component: not 0 for a solid
  /// For each triangle: how often a crossing of it counts in the winding number of its component,
  /// modulo kCyclePrime (cycles.h). Empty: 1 for all.
  std::vector<std::uint64_t> weight;
  /// The number of edges where the surface of parts that are in no solid ends, if it has an area.
  /// If it ends nowhere, the number of edges where the count of its triangles is not two, and at
  /// least 1. 0 if all parts that are in no solid lie in one plane: a flat sheet, not a solid.
  std::size_t open_edges = 0;
  /// The edges (low, high) between two vertices where a surface ends, even if it does not end along
  /// these edges. There it could be closed, see crackFillers().
  std::vector<std::pair<std::int32_t, std::int32_t>> seams;

  /// Whether a triangle counts for the inside of a solid.
  bool closes(std::size_t triangle) const {
    return closed[static_cast<std::size_t>(component[triangle])] != 0 &&
           (weight.empty() || weight[triangle] != 0);
  }
  /// Makes all components surfaces, for meshes that are meant as surfaces.
  void leaveOpen() {
    closed.assign(closed.size(), 0);
    open_edges = 0;
  }
};

/// Finds the solids of a set of triangles. Facets may have any orientation, and may be repeated or
/// shared.
///
/// 1. Of triangles with the same three corners, one counts.
/// 2. Triangles are joined across edges that exactly two of them share. They form patches, whose
///    triangles have the same orientation. A patch that cannot be oriented (a Moebius strip) is a
///    surface.
/// 3. A combination of patches is closed if their borders cancel along every edge. All such
///    combinations together are a cycle (cycles.h). Patches of the cycle that border on each other
///    form one component, which is closed: its inside is where the winding number is not 0. All
///    other patches are surfaces.
///
/// A box is therefore also a solid if it shares an edge or a facet with another one, or has a fin
/// or a wall. Triangles of a solid are turned outwards; if several solids share patches, each patch
/// is turned away from their middle. For `open_edges`, triangles of at most this height [m] have no
/// area. O(n log n), and the elimination of largestCycle().
MeshComponents findComponents(std::span<const Eigen::Vector3d> vertices,
                              std::vector<std::array<std::int32_t, 3>>& triangles,
                              double thickness = 0);

}  // namespace leeway::collision
