#pragma once

// Private to collision/: spheres around vertices, for Shape's factories.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>

#include "collision/base/tolerances.h"

namespace leeway::collision {

/// The norm, rounded outwards.
inline double outwardNorm(double x, double y, double z) { return std::hypot(x, y, z) * kOutwards; }

/// A sphere around points, rounded outwards.
struct BoundingSphere {
  Eigen::Vector3d center;
  double radius;  // [m]
  double extent;  // upper bound on the distance of the points from the origin [m]
};

inline BoundingSphere sphereAround(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d lowest = points[0], highest = points[0];
  for (const Eigen::Vector3d& p : points) {
    lowest = lowest.cwiseMin(p);
    highest = highest.cwiseMax(p);
  }
  BoundingSphere sphere{0.5 * lowest + 0.5 * highest, 0, 0};
  // std::hypot takes as long as everything else, so it is called only where the square may be the
  // largest.
  const auto enlarge = [](double& largest, const Eigen::Vector3d& v) {
    if (v.squaredNorm() * (1 + 0x1p-48) >= largest * largest)
      largest = std::max(largest, std::hypot(v.x(), v.y(), v.z()));
  };
  for (const Eigen::Vector3d& p : points) {
    enlarge(sphere.radius, p - sphere.center);
    enlarge(sphere.extent, p);
  }
  // The rounding of the differences is proportional to the coordinates, not to the radius.
  sphere.radius = sphere.radius * kOutwards + sphere.extent * 0x1p-51;
  sphere.extent = sphere.extent * kOutwards;
  return sphere;
}

}  // namespace leeway::collision
