#pragma once

#include <span>
#include <string>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Returns the variables of groups that are planned together, one group after the other. Throws
/// std::invalid_argument for a name that is not a group's, and with the message of groupsFault().
std::vector<int> variablesOf(const RobotDescription& robot, std::span<const std::string> groups);

/// Returns why groups of the robot are not planned together: there is none, one has no variable, or
/// two share one: "groups 'left' and 'both' both have joint 'left_elbow'; ...". Empty: they can be.
std::string groupsFault(const RobotDescription& robot, std::span<const std::string> groups);

/// Returns the groups whose variables these are, one group after the other: at each place the
/// longest that fits. Empty if none fits. O(groups * variables).
std::vector<std::string> groupsOf(const RobotDescription& robot, std::span<const int> variables);

/// Returns whether one of the variables moves the link, also by a joint that follows. O(depth *
/// variables).
bool movesLink(const RobotDescription& robot, std::span<const int> variables, int link);

}  // namespace leeway::robots
