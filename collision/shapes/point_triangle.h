#pragma once

#include <Eigen/Core>

namespace leeway::collision {

/// The point of triangle abc closest to p, up to rounding (C. Ericson, "Real-Time Collision
/// Detection", 2005, section 5.1.5). For triangles of any shape it is a convex combination of the
/// corners up to rounding, so its distance from p is an upper bound on the true distance. O(1).
Eigen::Vector3d closestPointOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace leeway::collision
