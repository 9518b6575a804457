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
  double extent;  // no point is farther from the origin [m]
};

inline BoundingSphere sphereAround(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d lowest = points[0], highest = points[0];
  for (const Eigen::Vector3d& p : points) {
    lowest = lowest.cwiseMin(p);
    highest = highest.cwiseMax(p);
  }
  BoundingSphere sphere{0.5 * lowest + 0.5 * highest, 0, 0};
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = p - sphere.center;
    sphere.radius = std::max(sphere.radius, std::hypot(d.x(), d.y(), d.z()));
    sphere.extent = std::max(sphere.extent, std::hypot(p.x(), p.y(), p.z()));
  }
  // The differences' rounding is proportional to the coordinates, not to the radius.
  sphere.radius = sphere.radius * kOutwards + sphere.extent * 0x1p-51;
  sphere.extent = sphere.extent * kOutwards;
  return sphere;
}

}  // namespace leeway::collision
