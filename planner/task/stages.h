#pragma once

#include <span>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// The problem of one step: that of the task with the world as it is now, and with what the step
/// allows. `world` has neither steps nor goals; a move has its goal. Throws std::invalid_argument
/// for names that do not exist.
Problem stageOf(const Problem& world, const Step& step);

/// The world after a step, with the robot at `configuration` (all variables), which becomes its
/// start. Throws std::invalid_argument for an object that is not there to be taken or let go.
Problem worldAfter(const Problem& world, const Step& step, std::span<const double> configuration);

/// The world before the first step.
Problem firstWorld(const Problem& problem);

/// A step in messages: "step 3 (lift)".
std::string stepText(const Problem& problem, std::size_t step);

}  // namespace leeway::planner
