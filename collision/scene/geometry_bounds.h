#pragma once

#include <optional>
#include <vector>

#include "collision/cover/coarse_shape.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

/// Cheap bounds of one geometry, which decide most pairs of a scene before exact queries. They are
/// in the body's frame, or in the world's frame for a fixed body.
struct GeometryBounds {
  Ball outer;  ///< contains the geometry, rounding included; infinite radius for a half-space
  CoarseShape coarse;
  std::vector<Ball> inner;  ///< balls of the geometry itself, if its body moves
};

GeometryBounds boundsOf(const Body& body, const Geometry& geometry);

/// GeometryBounds::outer and coarse of a ball of a fixed body, which has no others.
struct BallBounds {
  BallBounds(const Body& body, const Ball& ball);
  Ball outer;
  CoarseShape coarse;
};

/// A geometry of a scene with its bounds. The scene stores both, except for a ball, whose are in
/// this object.
class SceneGeometry {
 public:
  SceneGeometry() = default;
  /// Refers to both.
  SceneGeometry(const Geometry& geometry, const GeometryBounds& bounds)
      : geometry_(&geometry), bounds_(&bounds) {}
  /// Makes both for a ball: a number from body.geometries.size() on.
  SceneGeometry(const Body& body, std::size_t number) {
    const BallBounds bounds(body, (*body.balls)[number - body.geometries.size()]);
    ball_.emplace(OfBall{body.geometry(number), {bounds.outer, bounds.coarse, {}}});
  }
  const Geometry& geometry() const { return ball_ ? ball_->geometry : *geometry_; }
  const GeometryBounds& bounds() const { return ball_ ? ball_->bounds : *bounds_; }

 private:
  struct OfBall {
    Geometry geometry;
    GeometryBounds bounds;
  };
  const Geometry* geometry_ = nullptr;
  const GeometryBounds* bounds_ = nullptr;
  std::optional<OfBall> ball_;
};

}  // namespace leeway::collision
