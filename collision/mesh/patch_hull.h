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
  /// A facet's plane: normal . (x - point) <= doubt for every point x of the hull. The normal has
  /// length 1 up to rounding, which `doubt` covers [m].
  struct Plane {
    Vector normal, point;
    double doubt;
  };

  /// False if the hull of the points is not solid. O(n log n).
  bool build(std::vector<Vector> points);

  /// Facets over the points given to build().
  const std::vector<std::array<std::int32_t, 3>>& facets() const { return facets_; }
  const Plane& plane(std::int32_t facet) const { return planes_[static_cast<std::size_t>(facet)]; }
  /// The facets that have this point as a corner.
  std::span<const std::int32_t> facetsAt(std::int32_t point) const {
    const std::int32_t* const first = first_.data() + point;
    return {around_.data() + first[0], around_.data() + first[1]};
  }
  /// The hull's vertices.
  const std::vector<Vector>& corners() const { return corners_; }
  const Vector& low() const { return low_; }
  const Vector& high() const { return high_; }
  const Vector& center() const { return center_; }  ///< approximately the centroid of the volume
  double size() const {
    return size_;
  }  ///< upper bound on the distance of two points
     ///< [m]
  double reach() const {
    return reach_;
  }  ///< upper bound on the distance of the points
     ///< from the centre [m]
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
