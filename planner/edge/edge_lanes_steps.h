#pragma once

// Private to planner/: what the building of EdgeLanes and its edges share.

#include <Eigen/Core>

#include "collision/lanes/lane_frames.h"
#include "leeway/robots/kinematics.h"

namespace leeway::planner {

/// A rotation that turns z onto the unit vector `axis`, orthogonal to rounding.
inline Eigen::Matrix3d turningZ(const Eigen::Vector3d& axis) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d u, v;
  robots::planeAxes(axis, u, v);
  rotation << u, v, axis;
  return rotation;
}

/// Column by column.
inline void copyMatrix(const Eigen::Matrix3d& m, float* out) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(m.data()[i]);
}

inline void copyVector(const Eigen::Vector3d& v, float* out) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}

}  // namespace leeway::planner
