#include "leeway/robots/placed_model.h"

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "leeway/robots/text.h"

namespace leeway::robots {
namespace {

/// The shortest digits that read back.
std::string textOf(double number) {
  char digits[32];
  return {digits, std::to_chars(digits, std::end(digits), number).ptr};
}

bool isFree(const Joint& joint) {
  return joint.type == JointType::kPlanar || joint.type == JointType::kFloating;
}

std::string unknownJoint(const RobotDescription& robot, const std::string& joint) {
  std::vector<std::string> known;
  for (const Joint& j : robot.joints)
    if (isFree(j)) known.push_back(j.name);
  std::string listed;
  for (const std::string& name : known) listed += (listed.empty() ? "" : ", ") + name;
  const std::string* const near = nearestName(joint, known);
  return "no joint is named '" + joint + "'; " +
         (near != nullptr ? "did you mean '" + *near + "'?"
          : known.empty() ? "the robot has no planar or floating joint"
                          : "planar and floating joints: " + listed);
}

}  // namespace

std::string boundFault(const RobotDescription& robot, const std::string& joint,
                       const std::string& axis, const std::pair<double, double>& bound) {
  const int found = robot.findJoint(joint);
  if (found < 0) return unknownJoint(robot, joint);
  const Joint& bounded = robot.joints[at(found)];
  if (!isFree(bounded))
    return "joint '" + joint + "' is neither planar nor floating; one that is, is expected";
  const bool planar = bounded.type == JointType::kPlanar;
  if (axis != "x" && axis != "y" && (planar || axis != "z"))
    return "axis '" + axis + "' is not known; " + (planar ? "x or y" : "x, y or z") +
           " is expected for the " + (planar ? "planar" : "floating") + " joint '" + joint + "'";
  const auto [lower, upper] = bound;
  if (!(std::abs(lower) <= collision::kLargestSize && std::abs(upper) <= collision::kLargestSize))
    return "the bounds are " + textOf(lower) + " to " + textOf(upper) + "; coordinates up to " +
           textOf(collision::kLargestSize) + " m are expected";
  if (!(lower <= upper))
    return "the lower bound " + textOf(lower) + " is above the upper bound " + textOf(upper) +
           "; lower <= upper is expected";
  return {};
}

std::shared_ptr<const Model> withBounds(const Model& model, const OriginBounds& bounds) {
  auto bounded = std::make_shared<Model>(model);
  for (const auto& [joint, axes] : bounds)
    for (const auto& [axis, bound] : axes) {
      if (const std::string fault = boundFault(model, joint, axis, bound); !fault.empty())
        throw std::invalid_argument("bounds: " + fault);
      Variable& variable = bounded->variables[at(model.findVariable(joint + "/" + axis))];
      std::tie(variable.lower, variable.upper) = bound;
    }
  return bounded;
}

std::string basePoseFault(const RobotDescription& robot, const Pose& X_WB) {
  if (robot.links.empty()) return "the robot has no links; one with a root link is expected";
  const Joint& base = robot.joints[at(robot.links[0].joint)];
  if (base.type != JointType::kFixed)
    return "joint '" + base.name +
           "' moves the base; a robot whose base is fixed to the world is expected, because the "
           "value of a joint says where this one stands";
  if (!collision::isPose(X_WB) || !(X_WB.rotation.determinant() > 0) ||
      !((X_WB.translation.array().abs() <= collision::kLargestSize).all()))
    return "the base pose is no placement; coordinates up to " + textOf(collision::kLargestSize) +
           " m and a right-handed rotation within " + textOf(collision::kRotationTolerance) +
           " are expected";
  return {};
}

std::shared_ptr<const Model> withBasePose(const Model& model, const Pose& X_WB) {
  if (const std::string fault = basePoseFault(model, X_WB); !fault.empty())
    throw std::invalid_argument(fault);
  auto placed = std::make_shared<Model>(model);
  const std::size_t base = at(model.links[0].joint);
  Pose& X_PJ = placed->joints[base].X_PJ;
  // Products of many link poses must stay rotations.
  X_PJ.rotation = Eigen::Quaterniond(X_WB.rotation).normalized().toRotationMatrix();
  X_PJ.translation = X_WB.translation;
  // The constructor compiles the steps.
  placed->steps = Model(static_cast<const RobotDescription&>(*placed)).steps;
  return placed;
}

}  // namespace leeway::robots
