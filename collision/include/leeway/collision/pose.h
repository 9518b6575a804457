#pragma once

#include <Eigen/Core>

namespace leeway::collision {

/// A rigid placement: X_AB maps the coordinates of a point in frame B to those in frame A.
///
/// This is not Eigen::Isometry3d, because its alignment depends on the compiler's instruction set
/// (-march): it must not appear in the interface of a library that is compiled separately from its
/// caller.
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

  /// X_BA, by transposition: only as exact as `rotation` is orthogonal.
  Pose inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }

  /// From Eigen::Isometry3d, copied number by number. The converters are inline, so that the
  /// caller's alignment holds. They are templates, so that this header does not need
  /// <Eigen/Geometry>: a caller that has an isometry has included it.
  template <int kOptions>
  static Pose fromIsometry(const Eigen::Transform<double, 3, Eigen::Isometry, kOptions>& isometry) {
    return {isometry.linear(), isometry.translation()};
  }

  /// To Eigen::Isometry3d, copied number by number; include <Eigen/Geometry> before the call.
  template <int kOptions = Eigen::AutoAlign>
  Eigen::Transform<double, 3, Eigen::Isometry, kOptions> toIsometry() const {
    Eigen::Transform<double, 3, Eigen::Isometry, kOptions> isometry;
    isometry.linear() = rotation;
    isometry.translation() = translation;
    isometry.makeAffine();
    return isometry;
  }
};

}  // namespace leeway::collision
