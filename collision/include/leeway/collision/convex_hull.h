#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace leeway::collision {

class HullSupport;  // private to the library

/// The extreme points of a point set. Large hulls also have neighbour lists for hill climbing. A
/// hull that is flat, straight or a single point has no facets and no neighbour lists.
class ConvexHull {
 public:
  ~ConvexHull();
  /// Returns the hull of the given points [m], computed by Quickhull (Barber, Dobkin, Huhdanpaa
  /// 1996) with exact predicates: facets() are exactly convex, and every given point lies in the
  /// hull of vertices(). Coordinates below 1e-70 in magnitude count as 0. Usually O(n log n).
  /// Throws InvalidShape if there are no points, if a coordinate is not finite or exceeds 1e9 in
  /// magnitude, and if the points differ, but by less than 1e-9 in all coordinates.
  static std::shared_ptr<const ConvexHull> compute(std::span<const Eigen::Vector3d> points);

  std::span<const Eigen::Vector3d> vertices() const { return vertices_; }
  /// Outward counter-clockwise triangles over vertices(); empty for a flat set.
  std::span<const std::array<std::int32_t, 3>> facets() const { return facets_; }
  /// The vertices at the other ends of vertex i's edges; empty if the hull has no neighbour lists.
  /// In exact arithmetic, a vertex without a better neighbour is the farthest of all. With
  /// rounding, a climb can end early on a nearly flat part, so a bound needs a scan of all
  /// vertices.
  std::span<const std::int32_t> neighbours(std::int32_t i) const {
    if (neighbour_begin_.empty()) return {};
    const std::int32_t* begin = neighbour_begin_.data() + i;
    return {neighbours_.data() + begin[0], neighbours_.data() + begin[1]};
  }
  /// True for solids with many vertices. For few vertices a scan is cheaper than a climb.
  bool hasNeighbours() const { return !neighbour_begin_.empty(); }
  /// For the engine's own use.
  const HullSupport& support() const { return *support_; }

 private:
  ConvexHull();
  friend struct HullFile;  // private to the library
  friend std::shared_ptr<const ConvexHull> hullOfPart(std::span<const Eigen::Vector3d> points);
  void makeNeighbours(const std::vector<std::array<std::int32_t, 2>>& edges, std::size_t count);

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<std::int32_t> neighbour_begin_;  // vertices + 1 entries into neighbours_
  std::vector<std::int32_t> neighbours_;
  std::unique_ptr<const HullSupport> support_;
};

}  // namespace leeway::collision
