#pragma once

#include <Eigen/Core>
#include <vector>

#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A few points whose hull, grown by `radius`, contains a shape, including the inside of a closed
/// mesh and rounding; in the shape's own frame. There are no points for half-spaces and deforming
/// shapes.
struct PointCover {
  std::vector<Eigen::Vector3d> points;
  double radius = 0;  ///< [m]
  /// More points with a smaller radius: all vertices of a hull or of a mesh's hull. Empty if they
  /// would be no more than `points`, or more than kMostHullPoints.
  std::vector<Eigen::Vector3d> fine;
  double fine_radius = 0;  ///< [m]
  /// Ends of clusters in `fine`, and for each of `points` the nearest of `fine`; see clusterFine().
  std::vector<int> clusters, nearest;
  /// Whether all points belong to the shape (those of `fine` to within fine_radius).
  bool own = true;
};

/// Limit on the vertices in `fine` [count]: beyond it, exact queries are cheaper.
inline constexpr int kMostHullPoints = 320;

/// Orders the fine points into clusters of neighbours, by halving the longest side of the box
/// around them, and sets `clusters` and `nearest`. A search for the least point along a direction
/// then skips most clusters. O(n log n), and O(n) for each of `points`.
void clusterFine(PointCover& cover);

/// Limits on the points of a cluster and on the clusters [count]. If both are not enough, clusters
/// have more points.
inline constexpr int kClusterPoints = 16, kMostClusters = 32;

/// Makes at most `count` (>= 24) points for a convex hull, and at most 32 for other shapes; for a
/// mesh, those of its hierarchy's root. For a hull it takes the extreme vertices along the axes,
/// then always the vertex farthest from the hull of those chosen, until all are within 0.2 mm.
/// (This is greedy, like core-sets for directional widths: P. K. Agarwal, S. Har-Peled, K. R.
/// Varadarajan, "Geometric approximation via coresets", 2005.) O(vertices) distance queries of a
/// point, and a few for each chosen point.
PointCover coverWithPoints(const Shape& shape, int count);

}  // namespace leeway::collision
