#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace leeway::collision {

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
