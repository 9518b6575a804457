#pragma once

#include <memory>
#include <vector>

#include "leeway/collision/coarse_shape.h"
#include "leeway/collision/point_cover.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Balls, and a few points, that stand for a shape, in its own frame.
struct BallCover {
  /// Every point of the shape is in one of these, rounding included, and so is every point inside a
  /// closed mesh. Empty for half-spaces.
  std::vector<Ball> outer;
  /// Balls of the shape itself, each as large as its surface lets it be at its centre. May be
  /// empty: open or thin meshes.
  std::vector<Ball> inner;
  /// The shape by a few points.
  PointCover points;
};

/// At most `count` outer and as many inner balls; no points. Bisects the shape by planes across the
/// two longest axes of its box, always the part with the largest ball. For a closed mesh a part's
/// ball holds what is inside as well: from any point inside, both ways along the third axis, which
/// no plane cuts, lead to the surface within the part, so that the point is between two points of
/// triangles that the ball holds. O(triangles count); one distance query a part.
BallCover coverWithBalls(const Shape& shape, int count);

/// Balls of each kind that edge certification takes: fewer leave more to exact queries, more cost
/// more than they save.
inline constexpr int kCoverBalls = 8;
/// Points of a cover that edge certification takes: the same holds.
inline constexpr int kCoverPoints = 32;
/// coverWithBalls(shape, kCoverBalls), with coverWithPoints(shape, kCoverPoints); a mesh keeps it.
/// Any number of threads may ask.
std::shared_ptr<const BallCover> coverOf(const Shape& shape);

}  // namespace leeway::collision
