#pragma once

// The input checks of SceneBuilder and SceneChange.

#include <cmath>
#include <cstddef>
#include <limits>
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

/// Rejects balls that no query could answer for. O(balls).
inline void requireBalls(const Body& body) {
  if (!body.balls || body.balls->empty()) return;
  const auto refuse = [&body](std::size_t i, const std::string& what) {
    throw std::invalid_argument("scene: ball " + std::to_string(i) + " of '" + body.name + "' " +
                                what);
  };
  if (body.moving) refuse(0, "moves; balls of a fixed body are expected");
  double known = -1;  // most balls of a cloud have one radius
  for (std::size_t i = 0; i < body.balls->size(); ++i) {
    const Ball& ball = (*body.balls)[i];
    if (!ball.center.allFinite()) refuse(i, "has a centre that is not finite");
    if (ball.radius == known) continue;
    try {
      known = Shape::sphere(ball.radius).radius();
    } catch (const InvalidShape& error) {
      refuse(i, std::string("is refused: ") + error.what());
    }
  }
}

inline bool isHalfSpace(const Geometry& g) { return g.shape.type() == ShapeType::kHalfSpace; }
/// The same for a number below Body::size().
inline bool isHalfSpace(const Body& body, std::size_t geometry) {
  return geometry < body.geometries.size() && isHalfSpace(body.geometries[geometry]);
}

[[noreturn]] inline void refuseHalfSpaces(const Body& a, const Body& b) {
  throw std::invalid_argument("half-space of '" + a.name + "' with half-space of '" + b.name +
                              "': two of them have no distance; a pair that may touch, or "
                              "another shape for one of them is expected");
}

/// Rejects a table with more pairs than an int can number; half of its range is reserved for pairs
/// of moving bodies.
inline void requireNumbers(std::size_t rows, std::size_t places) {
  constexpr std::size_t most = std::numeric_limits<int>::max() / 2;
  if (rows == 0 || places <= most / rows) return;
  throw std::invalid_argument(
      "scene: " + std::to_string(rows) + " moving geometries times " + std::to_string(places) +
      " that stand still are more pairs than can be numbered, which are " + std::to_string(most));
}

}  // namespace leeway::collision
