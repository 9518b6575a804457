#pragma once

#include <optional>
#include <string>

#include "leeway/planner/compiled_scene.h"

namespace leeway::tools {

/// The two things of a scene's pair, as a user named them: links and objects. Empty for pair -1.
struct PairNames {
  std::string a, b;
};
PairNames pairNames(const planner::CompiledScene& scene, int pair);

/// Where obstacles move: the time of their motions [s] at which plans, checks and proofs look at
/// them. Nothing where all stand still.
std::optional<double> obstaclesAt(const planner::Problem& problem);
/// The same for the end of a sentence, with a space before it.
std::string obstaclesText(const planner::Problem& problem);

}  // namespace leeway::tools
