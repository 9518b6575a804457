#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace leeway::collision {

/// An oriented box: |axes.col(k) . (x - center)| <= half[k] for k = 0, 1, 2 [m].
struct FittedBox {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< a rotation
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), half = Eigen::Vector3d::Zero();

  /// An eighth of the surface area [m^2].
  double halfArea() const {
    return half.x() * half.y() + half.y() * half.z() + half.z() * half.x();
  }
};

/// Fits oriented boxes to sets of triangles.
class ObbFit {
 public:
  /// Starts a set of `triangles` >= 1 triangles.
  void start(std::size_t triangles);
  /// Adds a corner of a triangle, three for each.
  void add(const Eigen::Vector3d& corner) {
    column_[0][corners_] = corner.x();
    column_[1][corners_] = corner.y();
    column_[2][corners_] = corner.z();
    ++corners_;
  }
  /// Returns the smallest (by area) of a few boxes, once all corners are added: along the
  /// coordinate axes; for a single triangle along its best edge; otherwise along the principal axes
  /// of the corners and of the surface (S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", 1996), and
  /// along the mean normal. Not rounded outwards. O(triangles).
  FittedBox fit();

 private:
  static constexpr std::size_t kMostFrames = 4;

  Eigen::Vector3d corner(std::size_t triangle, std::size_t k) const {
    const std::size_t at = 3 * triangle + k;
    return {column_[0][at], column_[1][at], column_[2][at]};
  }
  FittedBox smallestAlong(const Eigen::Matrix3d* frames, std::size_t count) const;
  Eigen::Matrix3d frameOfTriangle() const;
  void addFrames(std::array<Eigen::Matrix3d, kMostFrames>& frames, std::size_t& count) const;

  std::size_t triangles_ = 0, corners_ = 0;
  std::array<std::vector<double>, 3> column_;  // coordinates, padded to whole blocks
};

}  // namespace leeway::collision
