#include "leeway/robots/placed_model.h"

#include <Eigen/Geometry>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "leeway/robots/text.h"
#include "robots/model/model_builder.h"

namespace leeway::robots {
namespace {

bool isFree(const Joint& joint) {
  return joint.type == JointType::kPlanar || joint.type == JointType::kFloating;
}
/// Whether a joint has one variable, which bounds limit.
bool isSingle(const Joint& joint) {
  return joint.variable_count == 1 && joint.mimic < 0 && joint.type != JointType::kFixed;
}

std::string unknownJoint(const RobotDescription& robot, const std::string& joint) {
  std::vector<std::string> known;
  for (const Joint& j : robot.joints)
    if (isFree(j) || isSingle(j)) known.push_back(j.name);
  std::string listed;
  for (const std::string& name : known) listed += (listed.empty() ? "" : ", ") + name;
  const std::string* const near = nearestName(joint, known);
  return "no joint is named '" + joint + "'; " +
         (near != nullptr ? "did you mean '" + *near + "'?"
          : known.empty() ? "the robot has no joint that takes bounds"
                          : "joints that take bounds: " + listed);
}

std::string rangeText(double lower, double upper) { return textOf(lower) + " to " + textOf(upper); }

std::string variableName(const std::string& joint, const std::string& axis) {
  return axis.empty() ? joint : joint + "/" + axis;
}

/// Returns the fault of a bound's axis or of its joint; empty if there is none.
std::string axisFault(const Joint& joint, const std::string& axis) {
  const std::string name = "joint '" + joint.name + "'";
  const bool is_planar = joint.type == JointType::kPlanar;
  if (isSingle(joint))
    return axis.empty() ? ""
                        : "axis '" + axis +
                              "' is not known; a lower and an upper bound are expected for " + name;
  if (!isFree(joint))
    return name + (joint.mimic >= 0 ? " follows another joint" : " is fixed") +
           "; a joint that moves by itself is expected";
  const char* const axes = is_planar ? "x and y" : "x, y and z";
  if (axis.empty())
    return name + " is " + (is_planar ? "planar" : "floating") + "; bounds of " + axes +
           " are expected";
  if (axis != "x" && axis != "y" && (is_planar || axis != "z"))
    return "axis '" + axis + "' is not known; " + (is_planar ? "x or y" : "x, y or z") +
           " is expected for the " + (is_planar ? "planar " : "floating ") + name;
  return {};
}

/// Whether a joint, or one that follows it, moves two links against each other.
bool movesApart(const RobotDescription& robot, int joint, int link_a, int link_b) {
  const auto isBelow = [&](int link, int j) {
    for (; link >= 0; link = robot.joints[at(robot.links[at(link)].joint)].parent_link)
      if (robot.links[at(link)].joint == j) return true;
    return false;
  };
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j) {
    int master = j;
    while (robot.joints[at(master)].mimic >= 0) master = robot.joints[at(master)].mimic;
    if (master == joint && isBelow(link_a, j) != isBelow(link_b, j)) return true;
  }
  return false;
}

/// The pairs that the SRDF leaves out because they never meet within limits that a joint now
/// exceeds.
std::string neverPairs(const RobotDescription& robot, int joint) {
  constexpr int kNamed = 5;
  std::string named;
  int count = 0;
  for (const DisabledPair& pair : robot.disabled_pairs) {
    std::string reason = pair.reason;
    for (char& c : reason) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (reason.find("never") == std::string::npos ||
        !movesApart(robot, joint, pair.link_a, pair.link_b))
      continue;
    if (++count <= kNamed)
      named += (named.empty() ? "" : ", ") + robot.links[at(pair.link_a)].name + " and " +
               robot.links[at(pair.link_b)].name;
  }
  return count > kNamed ? named + ", and " + std::to_string(count - kNamed) + " more" : named;
}

/// The names of the joints that follow a joint.
std::string followersOf(const RobotDescription& robot, int joint) {
  std::string names;
  for (const Joint& follower : robot.joints)
    if (follower.mimic == joint && follower.type != JointType::kContinuous)
      names += (names.empty() ? "'" : ", '") + follower.name + "'";
  return names;
}

}  // namespace

std::string boundFault(const RobotDescription& robot, const std::string& joint,
                       const std::string& axis, const JointBound& bound) {
  const int found = robot.findJoint(joint);
  if (found < 0) return unknownJoint(robot, joint);
  const Joint& bounded = robot.joints[at(found)];
  if (std::string fault = axisFault(bounded, axis); !fault.empty()) return fault;
  const auto [lower, upper] = std::pair(bound.lower, bound.upper);
  const std::string name = "joint '" + variableName(joint, axis) + "'";
  if (!(std::abs(lower) <= collision::kLargestSize && std::abs(upper) <= collision::kLargestSize))
    return "the bounds of " + name + " are " + rangeText(lower, upper) + "; " +
           (isFree(bounded) ? "coordinates" : "numbers") + " up to " +
           textOf(collision::kLargestSize) + (isFree(bounded) ? " m" : "") + " are expected";
  if (!(lower <= upper))
    return "the lower bound " + textOf(lower) + " of " + name + " is above the upper bound " +
           textOf(upper) + "; lower <= upper is expected";
  const Variable& own = robot.variables[at(robot.findVariable(variableName(joint, axis)))];
  if (isSingle(bounded) && !bound.widens && (lower < own.lower || upper > own.upper))
    return "the bounds of " + name + " are " + rangeText(lower, upper) +
           ", outside its own limits; a range within " + rangeText(own.lower, own.upper) +
           ", or 'widen', is expected";
  return {};
}

std::string emptyFault(const RobotDescription& robot, const std::string& joint) {
  const std::string fault = boundFault(robot, joint, "", {0, 0, true});
  return !fault.empty()
             ? fault
             : "joint '" + joint + "' has no bounds; a lower and an upper bound are expected";
}

std::shared_ptr<const Model> withBounds(const Model& model, const JointBounds& bounds) {
  auto bounded = std::make_shared<Model>(model);
  for (const auto& [joint, axes] : bounds) {
    if (axes.empty()) throw std::invalid_argument("bounds: " + emptyFault(*bounded, joint));
    for (const auto& [axis, bound] : axes) {
      if (const std::string fault = boundFault(*bounded, joint, axis, bound); !fault.empty())
        throw std::invalid_argument("bounds: " + fault);
      const std::size_t v = at(bounded->findVariable(variableName(joint, axis)));
      Variable& variable = bounded->variables[v];
      if (!variable.file_limits) variable.file_limits = {variable.lower, variable.upper};
      std::tie(variable.lower, variable.upper) = std::pair(bound.lower, bound.upper);
      const auto [file_lower, file_upper] = *variable.file_limits;
      const bool is_wider = bound.lower < file_lower || bound.upper > file_upper;
      if (const std::string followers = followersOf(*bounded, variable.joint);
          is_wider && axis.empty() && !followers.empty())
        bounded->warnings.push_back(
            "bounds of joint '" + joint +
            "' are wider than the robot's limits; the limits of joints that follow it do not hold "
            "there: " +
            followers);
      if (axis.empty()) variable.narrowed_by = bound.where;
      if (is_wider)
        if (const std::string pairs = neverPairs(*bounded, variable.joint); !pairs.empty())
          bounded->warnings.push_back(
              "bounds of joint '" + joint +
              "' are wider than the robot's limits, within which the SRDF says that pairs never "
              "meet; these are not checked: " +
              pairs);
      Joint& limited = bounded->joints[at(variable.joint)];
      if (limited.type == JointType::kContinuous) limited.type = JointType::kRevolute;
    }
  }
  // The constructor compiles the steps.
  bounded->steps = Model(static_cast<const RobotDescription&>(*bounded)).steps;
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
