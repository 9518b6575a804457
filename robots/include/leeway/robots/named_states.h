#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Returns the robot's group states, and two of the group "all" that every robot has, unless a
/// group state or one that is left out has their name: "zero" has all variables at zero, or at the
/// nearest limit, and floating joints at rest (defaultConfiguration()); "middle" has every variable
/// with finite limits in the middle of them and is "zero" elsewhere. O(states * variables).
std::vector<GroupState> namedStates(const Model& model);

/// Returns the fault of a state as values of all `variables`: "group state 'home' lacks joints 'a'
/// and 'b'; a state with a value for each planned joint is expected". `which` ends that message. Of
/// several states of the name, the nearest to complete counts. Empty for an unknown name and for a
/// state that is complete. O(states * variables^2).
std::string stateLackFault(const Model& model, std::string_view state,
                           std::span<const int> variables,
                           std::string_view which = "each planned joint");

/// Returns what a group state of the robot's files says of joints that are not among the planned
/// `variables` and stand elsewhere in `q`: "group state 'home' gives 'finger' 0.4, which is not
/// planned and stands at 0". Empty where there is nothing. O(states * variables^2).
std::string otherValues(const Model& model, std::string_view state, std::span<const int> variables,
                        std::span<const double> q);

}  // namespace leeway::robots
