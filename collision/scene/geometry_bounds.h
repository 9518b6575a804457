#pragma once

#include <vector>

#include "collision/cover/coarse_shape.h"

namespace leeway::collision {

/// Cheap bounds of one geometry, which decide most pairs of a scene before exact queries. They are
/// in the body's frame, or in the world's frame for a fixed body.
struct GeometryBounds {
  Ball outer;  ///< contains the geometry, rounding included; infinite radius for a half-space
  CoarseShape coarse;
  std::vector<Ball> inner;  ///< balls of the geometry itself, if its body moves
};

}  // namespace leeway::collision
