#include "tools/leeway/support/scene_names.h"

namespace leeway::tools {

PairNames pairNames(const planner::CompiledScene& scene, int pair) {
  if (pair < 0) {
    return {};
  }
  const auto& entry = scene.scene().pairs()[static_cast<std::size_t>(pair)];
  const auto bodies = scene.scene().bodies();
  return {bodies[static_cast<std::size_t>(entry.body_a)].name,
          bodies[static_cast<std::size_t>(entry.body_b)].name};
}

}  // namespace leeway::tools
