#pragma once

#include <memory>
#include <vector>

#include "collision/cover/coarse_shape.h"
#include "collision/cover/point_cover.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// What is of a mesh between some planes: the ball holds it, and so does the hull of `points` grown
/// by their radius; each with whatever is there of the inside of a closed mesh.
struct CoverPart {
  Ball ball;
  PointCover points;
};

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
  /// A mesh that is far from convex, in parts; empty for everything else.
  std::vector<CoverPart> parts;
};

/// At most `count` outer and as many inner balls; no points. Bisects the shape by planes across the
/// two longest axes of its box, always the part with the largest ball. For a closed mesh a part's
/// ball holds what is inside as well: from any point inside, both ways along the third axis, which
/// no plane cuts, lead to the surface within the part, so that the point is between two points of
/// triangles that the ball holds. O(triangles count); one distance query a part.
BallCover coverWithBalls(const Shape& shape, int count);

/// A mesh in at most `count` parts, all of which together hold it: none where its hull does nearly
/// as well (or for other shapes). Planes across no more than two axes bisect it, so that each part
/// holds what is inside as well, see coverWithBalls(): always that one which saves most of the
/// widths of the parts' hulls. O(triangles count), and a hull a part.
std::vector<CoverPart> coverWithParts(const Shape& shape, int count);

/// Balls of each kind that edge certification takes: fewer leave more to exact queries, more cost
/// more than they save.
inline constexpr int kCoverBalls = 8;
/// Points of a cover that edge certification takes: the same holds.
inline constexpr int kCoverPoints = 32;
/// Parts of a concave mesh that edge certification takes at most.
inline constexpr int kCoverParts = 8;
/// coverWithBalls(shape, kCoverBalls), with coverWithPoints(shape, kCoverPoints) and
/// coverWithParts(shape, kCoverParts); a mesh keeps it.
/// Any number of threads may ask.
std::shared_ptr<const BallCover> coverOf(const Shape& shape);

}  // namespace leeway::collision
