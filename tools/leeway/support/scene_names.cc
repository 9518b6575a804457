#include "tools/leeway/support/scene_names.h"

#include <fmt/format.h>

#include <algorithm>

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

std::optional<double> obstaclesAt(const planner::Problem& problem) {
  const auto& deforming = problem.world.deforming;
  if (std::none_of(deforming.begin(), deforming.end(),
                   [](const planner::DeformingObstacle& o) { return o.motion != nullptr; }))
    return {};
  return problem.execution.start;
}

std::string obstaclesText(const planner::Problem& problem) {
  const auto time = obstaclesAt(problem);
  return time ? fmt::format("; the obstacles stand as at {:g} s", *time) : "";
}

}  // namespace leeway::tools
