#pragma once

#include <Eigen/Core>

namespace leeway::collision {

// Exact signs of determinants of points with double coordinates. A floating-point filter decides
// nearly always. Expansion arithmetic (J. R. Shewchuk, "Adaptive precision floating-point
// arithmetic and fast robust geometric predicates", 1997) decides the other cases. The results are
// valid while every coordinate is 0 or between kSmallestExact and 1e90 in magnitude, because then
// no product of three leaves the range of normal doubles.

/// Sign of ((b - a) x (c - a)) . (d - a): +1 if d lies on the side from which abc is
/// counter-clockwise, 0 if the four points are exactly coplanar.
int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d);

/// Sign of the turn a, b, c in the plane of the coordinates i and j: +1 if counter-clockwise, 0 if
/// exactly straight.
int turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int i,
         int j);

/// True when a, b and c lie exactly on one line.
bool collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace leeway::collision
