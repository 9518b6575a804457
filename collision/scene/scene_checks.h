#pragma once

// What SceneBuilder and SceneChange ask of their input.

#include <cmath>
#include <stdexcept>
#include <string>

#include "collision/base/pose_check.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

inline void requireMargin(double margin) {
  if (!std::isfinite(margin))
    throw std::invalid_argument("scene: a margin must be a finite number of metres");
}

inline void requirePoses(const Body& body) {
  const auto require = [&body](const Pose& X) {
    if (!isPose(X))
      throw std::invalid_argument("scene: the pose of '" + body.name +
                                  "' must be finite, its rotation orthogonal");
  };
  require(body.X_WB);
  for (const Geometry& g : body.geometries) require(g.X_BG);
}

inline bool isHalfSpace(const Geometry& g) { return g.shape.type() == ShapeType::kHalfSpace; }

[[noreturn]] inline void refuseHalfSpaces(const Body& a, const Body& b) {
  throw std::invalid_argument("half-space of '" + a.name + "' with half-space of '" + b.name +
                              "': two of them have no distance; a pair that may touch, or "
                              "another shape for one of them is expected");
}

/// Where pairs cannot be numbered by an int, with room for pairs of what moves.
void requireNumbers(std::size_t runs, std::size_t places);

}  // namespace leeway::collision
