#pragma once

#include <limits>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/robots/model.h"

namespace leeway::robots {

/// Appends the variables of robot.joints[joint], which it must not have yet; none for a fixed or
/// mimic joint. `lower` and `upper` bound x for a joint of one variable (ignored for a continuous
/// one), x and y of a planar, x, y and z of a floating one.
void appendVariables(RobotDescription& robot, int joint, const Eigen::Vector3d& lower,
                     const Eigen::Vector3d& upper, double velocity = kInfinity);

/// The shortest digits that read back.
std::string textOf(double number);

}  // namespace leeway::robots
