#include "planner/base/largest_value.h"

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

bool isAngle(const robots::RobotDescription& robot, int variable) {
  const robots::Joint& joint = robot.joints[at(robot.variables[at(variable)].joint)];
  return joint.type == robots::JointType::kRevolute ||
         joint.type == robots::JointType::kContinuous ||
         (joint.type == robots::JointType::kPlanar && variable == joint.first_variable + 2);
}

double largestValue(const robots::RobotDescription& robot, int variable) {
  return isAngle(robot, variable) ? kLargestAngle : kLargestReach;
}

}  // namespace leeway::planner
