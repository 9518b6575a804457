#pragma once

#include <Eigen/Core>

namespace leeway::collision {

/// A rigid placement: X_AB maps the coordinates of a point in frame B to those in frame A. A struct
/// of two plain Eigen members and not Eigen's Isometry3d, whose alignment depends on the
/// instruction set that a program is compiled for: this type is part of public interfaces.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // [m]

  /// The coordinates in A of a point given in B.
  Eigen::Vector3d operator*(const Eigen::Vector3d& p_B) const {
    return rotation * p_B + translation;
  }

  /// X_AC = X_AB * X_BC.
  Pose operator*(const Pose& X_BC) const {
    return {rotation * X_BC.rotation, rotation * X_BC.translation + translation};
  }

  /// X_BA, by transposition: an inverse only as far as `rotation` is orthogonal.
  Pose inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

}  // namespace leeway::collision
