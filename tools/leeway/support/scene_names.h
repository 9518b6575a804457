#pragma once

#include <string>

#include "leeway/planner/compiled_scene.h"

namespace leeway::tools {

/// The two things of a scene's pair, as a user named them: links and objects. Empty for pair -1.
struct PairNames {
  std::string a, b;
};
PairNames pairNames(const planner::CompiledScene& scene, int pair);

}  // namespace leeway::tools
