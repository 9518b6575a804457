#pragma once

#include <map>
#include <memory>
#include <string>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// The range of a joint, in place of the one that the robot has.
struct JointBound {
  double lower, upper;  ///< [rad or m]
  /// Whether the range may reach beyond the robot's own limits. If not, a wider one is refused.
  bool widens = false;
  std::string where = "bounds";  ///< in messages about what is outside: what says it
};

/// Bounds by joint and axis. Axes of planar and floating joints are "x", "y" and, of the latter,
/// "z": coordinates of the child link's origin in the joint's frame. Revolute, continuous and
/// prismatic joints have the axis "".
using JointBounds = std::map<std::string, std::map<std::string, JointBound>>;

/// Returns the robot with these bounds. An axis that is not named keeps its own. A continuous joint
/// becomes revolute. Which links touch wherever their joint stands is still decided within the
/// robot's own limits (Variable::touchRange()). Throws std::invalid_argument with the message of
/// boundFault() or emptyFault(). O(links + geometries).
std::shared_ptr<const Model> withBounds(const Model& model, const JointBounds& bounds);

/// Returns what is wrong with one bound, "joint 'elbow' follows another joint; ..."; empty:
/// nothing.
std::string boundFault(const RobotDescription& robot, const std::string& joint,
                       const std::string& axis, const JointBound& bound);

/// Returns the fault of a joint that bounds name without giving one: it is unknown, or takes some.
std::string emptyFault(const RobotDescription& robot, const std::string& joint);

/// Returns a robot, whose root link is fixed to the world, with that link at X_WB. Throws
/// std::invalid_argument with the message of basePoseFault(). O(links + geometries).
std::shared_ptr<const Model> withBasePose(const Model& model, const Pose& X_WB);

/// Returns what is wrong with a base pose: the root is not fixed to the world, or X_WB is not
/// finite or no rotation within collision::kRotationTolerance; empty: nothing.
std::string basePoseFault(const RobotDescription& robot, const Pose& X_WB);

}  // namespace leeway::robots
