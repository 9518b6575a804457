#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace leeway::collision {

/// The extreme points of a point set, with neighbour lists for hill climbing where there are enough of
/// them. A set that is flat, straight or a point has no facets and no neighbour lists.
class ConvexHull {
 public:
  /// Computes the hull of the given points [m]. Every given point lies in the hull of vertices() grown by
  /// excess(): rounding, and merging of nearly coplanar facets, are counted there. O(n log n).
  /// Throws InvalidShape for no points or a coordinate that is not finite.
  static std::shared_ptr<const ConvexHull> compute(std::span<const Eigen::Vector3d> points);

  std::span<const Eigen::Vector3d> vertices() const { return vertices_; }
  /// Outward counter-clockwise triangles over vertices(); empty for a flat set.
  std::span<const std::array<std::int32_t, 3>> facets() const { return facets_; }
  /// Neighbours of vertex i; empty when there are no lists.
  std::span<const std::int32_t> neighbours(std::int32_t i) const;
  bool hasNeighbours() const { return !neighbour_begin_.empty(); }
  /// How far a given point may lie outside the hull of vertices() [m], 0 where they are all vertices.
  double excess() const { return excess_; }

 private:
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<std::int32_t> neighbour_begin_;  // vertices + 1 entries into neighbours_
  std::vector<std::int32_t> neighbours_;
  double excess_ = 0;
};

}  // namespace leeway::collision
