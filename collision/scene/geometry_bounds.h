#pragma once

// Private to the library: what decides most pairs of a scene before exact queries are asked.

#include <vector>

#include "collision/cover/coarse_shape.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

/// Cheap bounds of one geometry, in its body's frame; in the world's for a body that does not move.
struct GeometryBounds {
  Ball outer;  ///< holds the geometry, rounding included; infinite radius for a half-space
  CoarseShape coarse;
  std::vector<Ball> inner;  ///< balls of the geometry itself
};

inline const GeometryBounds& Scene::bounds(int geometry_index) const {
  return bounds_[static_cast<std::size_t>(geometry_index)];
}

}  // namespace leeway::collision
