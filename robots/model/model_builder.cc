#include "robots/model/model_builder.h"

#include <charconv>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace leeway::robots {

std::string textOf(double number) {
  char digits[32];
  return {digits, std::to_chars(digits, std::end(digits), number).ptr};
}

void appendVariables(RobotDescription& robot, int joint_index, const Eigen::Vector3d& lower,
                     const Eigen::Vector3d& upper, double velocity) {
  static constexpr const char* kPlanarNames[] = {"/x", "/y", "/theta"};
  static constexpr const char* kFloatingNames[] = {"/x", "/y", "/z", "/qx", "/qy", "/qz", "/qw"};
  Joint& joint = robot.joints[static_cast<std::size_t>(joint_index)];
  if (joint.type == JointType::kFixed || joint.mimic >= 0) return;
  joint.first_variable = static_cast<int>(robot.variables.size());
  joint.variable_count = joint.type == JointType::kPlanar     ? 3
                         : joint.type == JointType::kFloating ? 7
                                                              : 1;
  if (joint.variable_count == 1) {
    const bool continuous = joint.type == JointType::kContinuous;
    robot.variables.push_back({joint.name, joint_index, continuous ? -kInfinity : lower.x(),
                               continuous ? kInfinity : upper.x(), velocity});
    return;
  }
  const int bounded = joint.variable_count == 3 ? 2 : 3;
  for (int i = 0; i < joint.variable_count; ++i)
    robot.variables.push_back(
        {joint.name + (joint.variable_count == 3 ? kPlanarNames[i] : kFloatingNames[i]),
         joint_index, i < bounded ? lower(i) : -kInfinity, i < bounded ? upper(i) : kInfinity,
         velocity});
  if (joint.type == JointType::kFloating) robot.variables.back().rest = 1;
}

std::shared_ptr<const Model> freeBody(const std::string& name, std::vector<Geometry> geometries,
                                      JointType type, const Eigen::Vector3d& lower,
                                      const Eigen::Vector3d& upper) {
  const int bounded = type == JointType::kPlanar ? 2 : 3;
  for (int k = 0; k < bounded; ++k)
    if (!(lower[k] <= upper[k]))
      throw std::invalid_argument("the lower bound " + textOf(lower[k]) + " of '" + name + "/" +
                                  "xyz"[k] + "' is not below the upper bound " + textOf(upper[k]) +
                                  "; lower <= upper is expected");
  RobotDescription body;
  body.name = name;
  Link link;
  link.name = name;
  link.joint = 0;
  link.geometries = std::move(geometries);
  body.links.push_back(std::move(link));
  Joint joint;
  joint.name = name;
  joint.type = type;
  joint.child_link = 0;
  joint.axis = Eigen::Vector3d::UnitZ();
  body.joints.push_back(std::move(joint));
  appendVariables(body, 0, lower, upper);
  return std::make_shared<const Model>(std::move(body));
}

}  // namespace leeway::robots
