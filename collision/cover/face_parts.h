#pragma once

// Surfaces as polygons, clipped by planes.

#include <Eigen/Core>
#include <cstddef>
#include <memory_resource>
#include <span>
#include <vector>

#include "collision/base/large_pages.h"
#include "collision/cover/coarse_shape.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

/// Convex polygons, stored as consecutive corners.
class Polygons {
 public:
  std::size_t size() const { return ends_.size(); }
  bool empty() const { return ends_.empty(); }
  std::span<const Eigen::Vector3d> operator[](std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends_[i - 1];
    return std::span(corners_).subspan(begin, ends_[i] - begin);
  }
  /// The corners of all polygons.
  std::span<const Eigen::Vector3d> corners() const { return corners_; }

  void reserve(std::size_t polygons, std::size_t corners) {
    ends_.reserve(polygons);
    corners_.reserve(corners);
  }
  /// O(corners).
  void add(std::span<const Eigen::Vector3d> polygon) {
    corners_.insert(corners_.end(), polygon.begin(), polygon.end());
    ends_.push_back(corners_.size());
  }
  /// Adds the part of a convex polygon (not one of these) on one side of the plane x[axis] = at:
  /// the part with greater x[axis] for side 1, with smaller x[axis] for -1. Corners on the plane
  /// are kept. O(corners).
  void addClipped(std::span<const Eigen::Vector3d> polygon, Eigen::Index axis, double at,
                  double side);

 private:
  std::pmr::vector<Eigen::Vector3d> corners_{largeArrays()};
  std::pmr::vector<std::size_t> ends_{largeArrays()};
};

/// All polygons, each clipped as by addClipped(). O(corners).
Polygons clipped(const Polygons& polygons, Eigen::Index axis, double at, double side);

/// The triangles of a mesh.
Polygons polygonsOf(const TriangleMesh& mesh);

/// A small ball around the points, rounded outwards: steps towards the farthest point (M. Badoiu,
/// K. Clarkson, "Smaller core-sets for balls", 2003); the best of the centres is used. O(points).
Ball ballAround(std::span<const Eigen::Vector3d> points);

}  // namespace leeway::collision
