#pragma once

#include <Eigen/Core>

#include "leeway/collision/pose.h"

namespace leeway::collision {

using Vector = Eigen::Vector3d;

// Written-out products that every query computes. Unlike Eigen's matrix products they are always
// inlined, and the order of the sums is fixed.

/// a x b. (Eigen's own is in Eigen/Geometry, which is slow to compile.)
inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
          a.x() * b.y() - a.y() * b.x()};
}

/// R v.
inline Vector rotated(const Eigen::Matrix3d& R, const Vector& v) {
  return {R(0, 0) * v.x() + R(0, 1) * v.y() + R(0, 2) * v.z(),
          R(1, 0) * v.x() + R(1, 1) * v.y() + R(1, 2) * v.z(),
          R(2, 0) * v.x() + R(2, 1) * v.y() + R(2, 2) * v.z()};
}

/// R^T v.
inline Vector rotatedBack(const Eigen::Matrix3d& R, const Vector& v) {
  return {R(0, 0) * v.x() + R(1, 0) * v.y() + R(2, 0) * v.z(),
          R(0, 1) * v.x() + R(1, 1) * v.y() + R(2, 1) * v.z(),
          R(0, 2) * v.x() + R(1, 2) * v.y() + R(2, 2) * v.z()};
}

/// X p.
inline Vector placed(const Pose& X, const Vector& p) {
  const Vector r = rotated(X.rotation, p);
  return {r.x() + X.translation.x(), r.y() + X.translation.y(), r.z() + X.translation.z()};
}

}  // namespace leeway::collision
