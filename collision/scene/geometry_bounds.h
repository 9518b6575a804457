#pragma once

#include <vector>

#include "collision/cover/coarse_shape.h"

namespace leeway::collision {

/// Cheap bounds of one geometry, which decide most pairs of a scene before exact queries. In its
/// body's frame; of a body that stands still, in the world's.
struct GeometryBounds {
  Ball outer;  ///< holds the geometry, rounding included; infinite radius for a half-space
  CoarseShape coarse;
  std::vector<Ball> inner;  ///< balls of the geometry itself, where its body moves
};

}  // namespace leeway::collision
