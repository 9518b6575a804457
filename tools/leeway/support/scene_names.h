#pragma once

#include <optional>
#include <string>

#include "leeway/planner/compiled_scene.h"

namespace leeway::tools {

/// The two links or objects of a scene's pair, by their names. Empty for pair -1.
struct PairNames {
  std::string a, b;
};
PairNames pairNames(const planner::CompiledScene& scene, int pair);

/// Whether the motion of some obstacle is known, so that it can be shown.
bool movesAsKnown(const planner::Problem& problem);
/// If obstacles move, the time of their motions [s] at which plans, checks and proofs place them.
/// Nothing if all are at rest.
std::optional<double> obstaclesAt(const planner::Problem& problem);
/// The same as the end of a sentence, with a space before it.
std::string obstaclesText(const planner::Problem& problem);

}  // namespace leeway::tools
