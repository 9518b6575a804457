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

/// Adds triangles without area that tie an edge to shorter edges along it, where both leave one
/// vertex in exactly the same direction. An edge that two triangles share may belong to two solids,
/// if other triangles of theirs use its parts: without such a triangle they would be taken for one
/// surface, whose winding number about the inside of both is 0. O(k log k) for k edges if few edges
/// of a vertex have nearly the same direction; throws InvalidShape if very many have.
void addOverlapFillers(std::span<const Eigen::Vector3d> vertices,
                       std::vector<std::array<std::int32_t, 3>>& triangles);

}  // namespace leeway::collision
