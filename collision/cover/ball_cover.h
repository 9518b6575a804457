#pragma once

#include <memory>
#include <vector>

#include "collision/cover/coarse_shape.h"
#include "collision/cover/point_cover.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The part of a mesh between some planes, including the inside of a closed mesh there. The ball
/// contains it, and so does the hull of `points`, grown by their radius.
struct CoverPart {
  Ball ball;
  PointCover points;
};

/// Balls and points that bound a shape, in its own frame.
struct BallCover {
  /// Their union contains the shape, including the inside of a closed mesh and rounding. Empty for
  /// half-spaces.
  std::vector<Ball> outer;
  /// Balls inside the shape, each as large as fits at its centre. May be empty for open or thin
  /// meshes.
  std::vector<Ball> inner;
  /// The shape, as the hull of a few points.
  PointCover points;
  /// Parts of a mesh that is far from convex; empty for all other shapes.
  std::vector<CoverPart> parts;
};

/// Makes at most `count` outer and `count` inner balls, but no points. Bisects the shape by planes
/// across the two longest axes of its box, always the part with the largest ball. O(triangles
/// count); one distance query for each part.
///
/// A part's ball also contains the inside of a closed mesh. No plane cuts the third axis, so from a
/// point inside, both directions along that axis meet the surface within the part. The point is
/// therefore between two points of triangles that the ball contains.
BallCover coverWithBalls(const Shape& shape, int count);

/// Splits a mesh into at most `count` parts whose union contains it. Returns none if the mesh's
/// hull is nearly as good, and for other shapes. Bisects by planes across at most two axes, so that
/// each part also contains the inside (see coverWithBalls()); always by the plane that saves most
/// of the widths of the parts' hulls. O(triangles count), and one hull for each part.
std::vector<CoverPart> coverWithParts(const Shape& shape, int count);

/// Limits for edge certification: balls of each kind, points, and parts of a concave mesh [count].
/// Fewer leave more to exact queries; more cost more than they save.
inline constexpr int kCoverBalls = 8;
inline constexpr int kCoverPoints = 32;
inline constexpr int kCoverParts = 8;

/// coverOf() in two steps, for a mesh that is still being made: the first needs its triangles,
/// hierarchy and hullExcess(); the second makes queries.
BallCover coverWithoutInnerBalls(const Shape& shape);
void addInnerBalls(const Shape& shape, BallCover& cover);

/// coverWithBalls(), coverWithPoints() and coverWithParts() with these counts. A mesh computes its
/// cover once and keeps it. Thread-safe.
std::shared_ptr<const BallCover> coverOf(const Shape& shape);

}  // namespace leeway::collision
