#pragma once

#include "leeway/robots/model.h"

namespace leeway::planner {

/// Returns whether a variable is an angle [rad]. The others are lengths [m], and the four numbers
/// of an orientation.
bool isAngle(const robots::RobotDescription& robot, int variable);

/// Returns the largest magnitude of a variable that is certified: kLargestAngle, or kLargestReach
/// for a length, and less if a joint that mimics it would be farther than that: -1 if it always is.
/// O(joints).
double largestValue(const robots::RobotDescription& robot, int variable);

}  // namespace leeway::planner
