#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/constraint_result.h"
#include "leeway/planner/plan.h"

namespace leeway::tools {

/// The two links or objects of a scene's pair, by their names. Empty for pair -1.
struct PairNames {
  std::string a, b;
};
PairNames pairNames(const planner::CompiledScene& scene, int pair);

/// Whether the motion of some obstacle is known, so that it can be shown.
bool movesAsKnown(const planner::Problem& problem);
/// planner::obstaclesAt() as the end of a sentence, with a space before it.
std::string obstaclesText(const planner::Problem& problem);

/// Returns a line for each constraint of a problem, with the bounds that are proven along a path.
/// `results`: one each; none where they are not proven.
std::string constraintsText(const planner::Problem& problem,
                            const std::vector<planner::ConstraintResult>& results);

/// The unit of a variable: "rad", "m", or nothing for a number of a quaternion.
const char* unitOf(const robots::Model& model, int variable);

/// The pairs that blocked most edges of a search: a line; empty if none did.
std::string blockedText(std::span<const planner::BlockedPair> blocked);
/// How near to a goal a search came, and limits that bar the shorter turn: a line for each; empty
/// where nothing is known.
std::string hindranceText(const planner::Problem& problem, const planner::PlanResult& result);

}  // namespace leeway::tools
