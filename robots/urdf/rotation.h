#pragma once

// Private to robots/: rotations as robot files write them.

#include <Eigen/Core>
#include <vector>

namespace leeway::robots {

/// The rotation of `angle` [rad] about an axis of any length but 0.
Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle);
/// The shortest rotation of the z axis onto a direction of any length but 0; opposite to it, half a
/// turn about x.
Eigen::Matrix3d rotationOfZ(const Eigen::Vector3d& direction);
/// The rotation of w x y z of any length but 0.
Eigen::Matrix3d rotationOf(const std::vector<double>& quaternion);

}  // namespace leeway::robots
