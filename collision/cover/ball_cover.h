#pragma once

#include <memory>
#include <vector>

#include "collision/cover/coarse_shape.h"
#include "collision/cover/point_cover.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The part of a mesh between some planes, with the inside of a closed mesh there: the ball holds
/// it, and so does the hull of `points`, grown by their radius.
struct CoverPart {
  Ball ball;
  PointCover points;
};

/// Balls and points that bound a shape, in its own frame.
struct BallCover {
  /// Their union holds the shape, with the inside of a closed mesh, rounding included. Empty for
  /// half-spaces.
  std::vector<Ball> outer;
  /// Balls inside the shape, each as large as fits at its centre. May be empty: open or thin
  /// meshes.
  std::vector<Ball> inner;
  /// The shape by the hull of a few points.
  PointCover points;
  /// Parts of a mesh that is far from convex; empty for everything else.
  std::vector<CoverPart> parts;
};

/// At most `count` outer and as many inner balls; no points. Bisects the shape by planes across the
/// two longest axes of its box, always the part with the largest ball. O(triangles count); one
/// distance query a part.
///
/// A part's ball holds the inside of a closed mesh, too: no plane cuts the third axis, so from a
/// point inside both ways along it meet the surface within the part, and the point is between two
/// points of triangles that the ball holds.
BallCover coverWithBalls(const Shape& shape, int count);

/// A mesh in at most `count` parts whose union holds it; none where its hull does nearly as well,
/// and for other shapes. Bisects by planes across at most two axes, so that each part holds the
/// inside, too (see coverWithBalls()); always by the plane that saves most of the widths of the
/// parts' hulls. O(triangles count), and a hull a part.
std::vector<CoverPart> coverWithParts(const Shape& shape, int count);

/// Balls of each kind, points, and parts of a concave mesh that edge certification takes at most
/// [count]. Fewer leave more to exact queries, more cost more than they save.
inline constexpr int kCoverBalls = 8;
inline constexpr int kCoverPoints = 32;
inline constexpr int kCoverParts = 8;

/// coverOf() in two steps, where the shape is a mesh in the making: the first needs its triangles,
/// hierarchy and hullExcess(), the second asks queries.
BallCover coverWithoutInnerBalls(const Shape& shape);
void addInnerBalls(const Shape& shape, BallCover& cover);

/// coverWithBalls(), coverWithPoints() and coverWithParts() with these counts. A mesh computes it
/// once and keeps it. Thread-safe.
std::shared_ptr<const BallCover> coverOf(const Shape& shape);

}  // namespace leeway::collision
