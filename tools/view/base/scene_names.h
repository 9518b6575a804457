#pragma once

#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/constraint_result.h"

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

}  // namespace leeway::tools
