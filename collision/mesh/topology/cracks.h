#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace leeway::collision {

/// Returns triangles that close the cracks along `seams` (MeshComponents): at vertices that lie on
/// an edge within `distance` [m], and between vertices within that distance of each other. With
/// distance 0 these are vertices exactly on edges, and the triangles have no area: the mesh gains
/// no point. No point of the triangles is farther than twice the distance from the mesh. The
/// corners are vertices of the mesh; no vertex moves. O(k log k) for k edges if few of them are
/// near each other; if very many are, some cracks stay open.
std::vector<std::array<std::int32_t, 3>> crackFillers(
    std::span<const Eigen::Vector3d> vertices,
    std::span<const std::pair<std::int32_t, std::int32_t>> seams, double distance);

/// Returns the edges (low, high) that run over a shorter edge from one of their ends. Two chains of
/// edges along one line have such an edge where they part, so that triangles on a chain whose edges
/// two solids share would be taken for one surface. Exact; O(k log k) for k edges if few edges of a
/// vertex have nearly the same direction.
std::vector<std::pair<std::int32_t, std::int32_t>> overlappingEdges(
    std::span<const Eigen::Vector3d> vertices,
    std::span<const std::array<std::int32_t, 3>> triangles);

}  // namespace leeway::collision
