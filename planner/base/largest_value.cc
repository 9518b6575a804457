#include "planner/base/largest_value.h"

#include <algorithm>
#include <cmath>

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
  double most = isAngle(robot, variable) ? kLargestAngle : kLargestReach;
  const int joint = robot.variables[at(variable)].joint;
  for (const robots::Joint& follower : robot.joints) {
    if (follower.mimic != joint) continue;
    const double its =
        follower.type == robots::JointType::kPrismatic ? kLargestReach : kLargestAngle;
    const double left = its - std::abs(follower.offset);
    if (!(left >= 0)) return -1;
    if (follower.multiplier != 0) most = std::min(most, left / std::abs(follower.multiplier));
  }
  return most;
}

}  // namespace leeway::planner
