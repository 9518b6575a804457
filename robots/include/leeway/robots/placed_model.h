#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Bounds of planar and floating joints: by joint and axis ("x", "y", of a floating joint also
/// "z"), lower and upper coordinate of the child link's origin in the joint's frame [m].
using OriginBounds = std::map<std::string, std::map<std::string, std::pair<double, double>>>;

/// Returns the robot with these bounds. An axis that is not named keeps its own. Throws
/// std::invalid_argument with the message of boundFault(). O(links + geometries).
std::shared_ptr<const Model> withBounds(const Model& model, const OriginBounds& bounds);

/// Returns what is wrong with one bound, "joint 'elbow' is revolute; ..."; empty: nothing.
std::string boundFault(const RobotDescription& robot, const std::string& joint,
                       const std::string& axis, const std::pair<double, double>& bound);

/// Returns a robot, whose root link is fixed to the world, with that link at X_WB. Throws
/// std::invalid_argument with the message of basePoseFault(). O(links + geometries).
std::shared_ptr<const Model> withBasePose(const Model& model, const Pose& X_WB);

/// Returns what is wrong with a base pose: the root is not fixed to the world, or X_WB is not
/// finite or no rotation within collision::kRotationTolerance; empty: nothing.
std::string basePoseFault(const RobotDescription& robot, const Pose& X_WB);

}  // namespace leeway::robots
