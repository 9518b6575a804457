#pragma once

#include <Eigen/Core>
#include <vector>

#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A few points that stand for a shape from outside, in its own frame: every point of the shape,
/// and of the inside of a closed mesh, is within `radius` of their hull, rounding included. No
/// points: half-spaces and shapes that deform.
struct PointCover {
  std::vector<Eigen::Vector3d> points;
  double radius = 0;  ///< [m]
  /// More points, for a smaller radius, where that gains something: all vertices of a hull or of a
  /// mesh's hull, unless there are more than kMostHullPoints.
  std::vector<Eigen::Vector3d> fine;
  double fine_radius = 0;  ///< [m]
  /// Where parts of `fine` end that stand together, and of each of `points` which of `fine` is next
  /// to it; see clusterFine().
  std::vector<int> clusters, nearest;
  /// All points are the shape's own, those of `fine` to within fine_radius.
  bool own = true;
};

/// Vertices beyond which a hull is not looked at as a whole: exact queries are cheaper then.
inline constexpr int kMostHullPoints = 320;

/// Puts the finer points into an order in which clusters of a few stand side by side, by halving
/// the longest side of the box around them, and tells these: of those that are least along a
/// direction most clusters need not be asked one by one. O(n log n), and O(n) for each of `points`.
void clusterFine(PointCover& cover);

/// Points that a cluster has at most, and clusters that there are at most: where that is too few
/// for all points, they have more [count].
inline constexpr int kClusterPoints = 16, kMostClusters = 32;

/// At most `count` (>= 24) points for a convex hull, at most 32 for the others: a mesh gives those
/// of its hierarchy's root. Hulls: extreme vertices, the one farthest from the hull of those before
/// it next (greedy, as core-sets for directional widths are chosen: Agarwal, Har-Peled,
/// Varadarajan, "Geometric approximation via coresets", 2005), until all others are within 0.2 mm.
/// O(vertices) distance queries of a point, and some more a point.
PointCover coverWithPoints(const Shape& shape, int count);

}  // namespace leeway::collision
