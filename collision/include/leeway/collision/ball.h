#pragma once

#include <Eigen/Core>

namespace leeway::collision {

/// A solid ball in some frame.
struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< [m]
  double radius = 0;                                 ///< [m]
};

}  // namespace leeway::collision
