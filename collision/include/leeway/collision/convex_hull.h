#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace leeway::collision {

class HullSupport;  // private to the library

/// The extreme points of a point set, with neighbour lists for hill climbing where there are enough
/// of them. A set that is flat, straight or a point has no facets and no neighbour lists.
class ConvexHull {
 public:
  ~ConvexHull();
  /// Computes the hull of the given points [m]: Quickhull (Barber, Dobkin, Huhdanpaa 1996) with
  /// exact predicates, so that every given point lies in the hull of vertices() grown by excess()
  /// and facets() are convex without any tolerance. O(n log n) as a rule. Throws InvalidShape for
  /// no points or a coordinate that is not finite or exceeds 1e60 in magnitude.
  static std::shared_ptr<const ConvexHull> compute(std::span<const Eigen::Vector3d> points);

  std::span<const Eigen::Vector3d> vertices() const { return vertices_; }
  /// Outward counter-clockwise triangles over vertices(); empty for a flat set.
  std::span<const std::array<std::int32_t, 3>> facets() const { return facets_; }
  /// The vertices at the other ends of i's edges; empty when there are no lists. In exact
  /// arithmetic a vertex without a better neighbour is the farthest of all; rounding can end a
  /// climb on a vertex that is nearly flat, so that a bound needs one look at all vertices.
  std::span<const std::int32_t> neighbours(std::int32_t i) const {
    if (neighbour_begin_.empty()) return {};
    const std::int32_t* begin = neighbour_begin_.data() + i;
    return {neighbours_.data() + begin[0], neighbours_.data() + begin[1]};
  }
  /// True for solids with many vertices: scanning few is cheaper than climbing.
  bool hasNeighbours() const { return !neighbour_begin_.empty(); }
  /// How far a given point may lie outside the hull of vertices() [m]: 0 but for coordinates below
  /// 1e-70.
  double excess() const { return excess_; }
  /// For the engine's own use.
  const HullSupport& support() const { return *support_; }

 private:
  ConvexHull();
  void makeNeighbours(const std::vector<std::array<std::int32_t, 2>>& edges, std::size_t count);

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<std::int32_t> neighbour_begin_;  // vertices + 1 entries into neighbours_
  std::vector<std::int32_t> neighbours_;
  double excess_ = 0;
  std::unique_ptr<const HullSupport> support_;
};

}  // namespace leeway::collision
