#pragma once

#include <span>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Returns the problem of one step: the task's problem with the world as it is now and with the
/// contacts that the step allows. `world` has neither steps nor goals; a move's problem has its
/// goal. Throws std::invalid_argument for names that do not exist.
Problem stageOf(const Problem& world, const Step& step);

/// Returns the world after a step. Its start is `configuration` (all variables). Throws
/// std::invalid_argument if the object to attach or detach is not there.
Problem worldAfter(const Problem& world, const Step& step, std::span<const double> configuration);

/// The world before the first step.
Problem firstWorld(const Problem& problem);

/// Why nothing is proven of a task without a step that moves.
inline constexpr char kNoMove[] = "no step moves the robot";

/// The text that names a step in messages: "step 3 (lift)".
std::string stepText(const Problem& problem, std::size_t step);

}  // namespace leeway::planner
