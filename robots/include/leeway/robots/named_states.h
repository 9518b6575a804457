#pragma once

#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Returns the robot's group states, and two of the group "all" that every robot has, unless a
/// group state or one that is left out has their name: "zero" is defaultConfiguration(), "middle"
/// has every variable with finite limits in the middle of them and is "zero" elsewhere. O(states *
/// variables).
std::vector<GroupState> namedStates(const Model& model);

}  // namespace leeway::robots
