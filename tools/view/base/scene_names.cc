#include "tools/view/base/scene_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/validate/checks.h"
#include "tools/view/base/figures.h"

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

bool movesAsKnown(const planner::Problem& problem) {
  return std::any_of(problem.world.deforming.begin(), problem.world.deforming.end(),
                     [](const auto& o) { return o.motion != nullptr; }) ||
         std::any_of(problem.world.objects.begin(), problem.world.objects.end(),
                     [](const auto& o) { return o.motion && o.motion->poses; });
}

std::string obstaclesText(const planner::Problem& problem) {
  const auto time = planner::obstaclesAt(problem);
  if (!time) return "";
  std::string text = fmt::format("; the obstacles stand as at {:g} s", *time);
  for (const planner::Object& o : problem.world.objects)
    if (o.motion && o.motion->age > 0)
      text += fmt::format(", '{}' where it was seen {:g} s before", o.name, o.motion->age);
  return text;
}

namespace {

/// Decimals that show a part of `allowed`.
int decimalsOf(double allowed) {
  return std::clamp(3 - static_cast<int>(std::floor(std::log10(allowed))), 3, 9);
}

}  // namespace

std::string constraintsText(const planner::Problem& problem,
                            const std::vector<planner::ConstraintResult>& results) {
  std::string text;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const planner::Constraint& constraint = problem.constraints[i];
    const planner::ConstraintResult& proven = results[i];
    std::string off;
    for (const auto& [from, to] : constraint.position)
      if (std::isfinite(from) || std::isfinite(to))
        off = fmt::format(
            " at most {} mm off ({} are allowed)",
            formatUpper(1e3 * proven.deviation, decimalsOf(1e3 * constraint.position_tolerance)),
            1e3 * constraint.position_tolerance);
    if (constraint.turn != planner::Constraint::Turn::kAny)
      off += fmt::format("{} at most {} rad turned ({} are allowed)", off.empty() ? "" : ",",
                         formatUpper(proven.angle, decimalsOf(constraint.angle)), constraint.angle);
    text += fmt::format("Constraint '{}' holds everywhere, proven: '{}' is{}.\n", constraint.name,
                        constraint.frame, off);
  }
  return text;
}

}  // namespace leeway::tools
