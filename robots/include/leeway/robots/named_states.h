#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Returns the robot's group states, and two of the group "all" that every robot has, unless a
/// group state or one that is left out has their name: "zero" is defaultConfiguration(), "middle"
/// has every variable with finite limits in the middle of them and is "zero" elsewhere. O(states *
/// variables).
std::vector<GroupState> namedStates(const Model& model);

/// Returns the fault of a state as values of all `variables`: "group state 'home' lacks joints 'a'
/// and 'b'; a state with a value for each planned joint is expected". `which` ends that message. Of
/// several states of the name, the nearest to complete counts. Empty for an unknown name and for a
/// state that is complete. O(states * variables^2).
std::string stateLackFault(const Model& model, std::string_view state,
                           std::span<const int> variables,
                           std::string_view which = "each planned joint");

}  // namespace leeway::robots
