#pragma once

#include <Eigen/Geometry>
#include <stdexcept>

#include "leeway/robots/model.h"

namespace leeway::dense {

/// The motion of a joint at a value [rad or m]. Throws std::runtime_error for joints of several
/// degrees of freedom.
inline Eigen::Isometry3d jointMotion(const robots::Joint& joint, double value) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  switch (joint.type) {
    case robots::JointType::kFixed:
      break;
    case robots::JointType::kRevolute:
    case robots::JointType::kContinuous:
      X.rotate(Eigen::AngleAxisd(value, joint.axis));
      break;
    case robots::JointType::kPrismatic:
      X.translate(value * joint.axis);
      break;
    case robots::JointType::kPlanar:
    case robots::JointType::kFloating:
      throw std::runtime_error("joint '" + joint.name +
                               "': this checker knows joints of one degree of freedom");
  }
  return X;
}

}  // namespace leeway::dense
