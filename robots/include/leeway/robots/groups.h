#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

// Robots are planned by a group or a list of groups. A joint is a group of its own; where a group
// has its name, the group is meant.

/// Returns whether a group or a joint has this name.
bool isGroup(const RobotDescription& robot, std::string_view name);

/// Returns the variables of groups that are planned together, one group after the other. Throws
/// std::invalid_argument for a name that is not a group's, and with the message of groupsFault().
std::vector<int> variablesOf(const RobotDescription& robot, std::span<const std::string> groups);

/// Returns why groups of the robot are not planned together: there is none, one has no variable, or
/// two share one: "groups 'left' and 'both' both have joint 'left_elbow'; ...". Empty: they can be.
std::string groupsFault(const RobotDescription& robot, std::span<const std::string> groups);

/// Returns the groups whose variables these are, one group after the other: at each place the
/// longest that fits, or else a joint. Empty if none fits. O(groups * variables).
std::vector<std::string> groupsOf(const RobotDescription& robot, std::span<const int> variables);

/// Returns the joints between two links, from the root on: those above one of them alone. O(depth *
/// log(depth)).
std::vector<int> chainJoints(const RobotDescription& robot, int base_link, int tip_link);
std::vector<int> chainVariables(const RobotDescription& robot, int base_link, int tip_link);

/// Returns whether one of the variables moves the link, also by a joint that follows. O(depth *
/// variables).
bool movesLink(const RobotDescription& robot, std::span<const int> variables, int link);

}  // namespace leeway::robots
