#pragma once

#include "leeway/robots/model.h"

namespace leeway::planner {

/// Returns whether a variable is an angle [rad]. The others are lengths [m], and the four numbers
/// of an orientation.
bool isAngle(const robots::RobotDescription& robot, int variable);

/// Returns the largest magnitude of a variable that is certified: kLargestAngle, or kLargestReach
/// for a length.
double largestValue(const robots::RobotDescription& robot, int variable);

}  // namespace leeway::planner
