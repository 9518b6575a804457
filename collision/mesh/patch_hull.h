#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/base/vector.h"
#include "collision/convex/gjk/convex_view.h"

namespace leeway::collision {

/// The convex hull of a patch of a surface, with the planes of its facets.
class PatchHull {
 public:
  /// A facet's plane: normal . (x - point) <= doubt for every point x of the hull; the normal is of
  /// length 1 to within rounding, which `doubt` covers [m].
  struct Plane {
    Vector normal, point;
    double doubt;
  };

  /// False for points whose hull is not solid. O(n log n).
  bool build(std::vector<Vector> points);

  /// Over the points given to build().
  const std::vector<std::array<std::int32_t, 3>>& facets() const { return facets_; }
  const Plane& plane(std::int32_t facet) const { return planes_[static_cast<std::size_t>(facet)]; }
  /// The facets that have this point for a corner.
  std::span<const std::int32_t> facetsAt(std::int32_t point) const {
    const std::int32_t* const first = first_.data() + point;
    return {around_.data() + first[0], around_.data() + first[1]};
  }
  /// The hull's vertices.
  const std::vector<Vector>& corners() const { return corners_; }
  const Vector& low() const { return low_; }
  const Vector& high() const { return high_; }
  const Vector& center() const { return center_; }  ///< about the centroid of the volume
  double size() const { return size_; }             ///< no two points are farther apart [m]
  double reach() const { return reach_; }           ///< no point is farther from the centre [m]
  ConvexView view() const {
    return viewOfPoints(corners_.data(), static_cast<int>(corners_.size()), 0);
  }

 private:
  void makePlanes();
  void makeCenter();

  std::vector<Vector> points_, corners_;
  std::vector<std::array<std::int32_t, 3>> facets_;
  std::vector<Plane> planes_;
  std::vector<std::int32_t> first_, around_;  // facets at each point
  Vector low_, high_, center_;
  double size_ = 0, reach_ = 0;
};

}  // namespace leeway::collision
