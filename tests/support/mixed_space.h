#pragma once

#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "planner/base/random.h"
#include "tests/support/random_model.h"

namespace leeway::planner::testing {

/// Every kind of part: lines, circles and, unless `rotations` is false, a rotation. Lines reach
/// from -2 to 2.
inline ConfigurationSpace mixedSpace(bool rotations = true) {
  using robots::JointType;
  const JointType types[] = {
      JointType::kFixed,      rotations ? JointType::kFloating : JointType::kPrismatic,
      JointType::kPlanar,     JointType::kRevolute,
      JointType::kContinuous, JointType::kPrismatic};
  robots::RobotDescription robot = robots::testing::chain(
      6, JointType::kRevolute, 2,
      [&](int i, robots::Link& /*link*/, robots::Joint& joint) { joint.type = types[i]; });
  std::vector<int> variables;
  for (std::size_t i = 0; i < robot.variables.size(); ++i) variables.push_back(static_cast<int>(i));
  return {std::make_shared<robots::Model>(std::move(robot)), variables};
}

inline std::vector<double> randomPoint(Random& random, const ConfigurationSpace& space) {
  std::vector<double> point(static_cast<std::size_t>(space.size()));
  for (const ConfigurationSpace::Part& part : space.parts()) {
    double& x = point[static_cast<std::size_t>(part.first)];
    if (part.kind == ConfigurationSpace::Kind::kRotation)
      random.quaternion(&x);
    else
      x = part.kind == ConfigurationSpace::Kind::kLine
              ? random.uniform(-2, 2)
              : random.uniform(-std::numbers::pi, std::numbers::pi);
  }
  return point;
}

}  // namespace leeway::planner::testing
