#include "tools/view/base/scene_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "leeway/planner/configuration_space.h"
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

std::string blockedText(std::span<const planner::BlockedPair> blocked) {
  constexpr std::size_t kPairs = 3;
  std::string text;
  for (const planner::BlockedPair& pair : blocked.first(std::min(kPairs, blocked.size())))
    text += fmt::format("{}{} and {} ({})", text.empty() ? "" : ", ", pair.a, pair.b, pair.edges);
  return text.empty() ? "" : fmt::format("Most edges were blocked by: {}.\n", text);
}

const char* unitOf(const robots::Model& model, int variable) {
  const robots::Variable& v = model.variables[static_cast<std::size_t>(variable)];
  const robots::JointType type = model.joints[static_cast<std::size_t>(v.joint)].type;
  if (type == robots::JointType::kFloating && v.name.find("/q") != std::string::npos) return "";
  return type == robots::JointType::kRevolute || type == robots::JointType::kContinuous ||
                 v.name.ends_with("/theta")
             ? "rad"
             : "m";
}

std::string hindranceText(const planner::Problem& problem, const planner::PlanResult& result) {
  std::string text;
  const auto nameOf = [&](std::size_t i) -> const std::string& {
    const int v = problem.robot.variables[i];
    return problem.robot.model->variables[static_cast<std::size_t>(v)].name;
  };
  const planner::SearchGap& gap = result.gap;
  if (!gap.from.empty()) {
    const planner::ConfigurationSpace space(problem.robot.model, problem.robot.variables);
    std::vector<double> to = gap.to;
    space.unwrap(gap.from, to);
    std::size_t most = 0;
    for (std::size_t i = 0; i < to.size(); ++i)
      if (std::abs(to[i] - gap.from[i]) > std::abs(to[most] - gap.from[most])) most = i;
    // Coordinates of a quaternion have no unit, and tell a reader nothing.
    const std::string unit = unitOf(*problem.robot.model, problem.robot.variables[most]);
    text += fmt::format(
        "Start and goal came within {:.3f} of each other (distance of configurations), most of it "
        "in '{}'{}.\n",
        gap.distance, nameOf(most),
        unit.empty() ? "" : fmt::format(" ({:.3f} {})", std::abs(to[most] - gap.from[most]), unit));
  }
  for (const std::string& name : result.long_turns)
    text += fmt::format("The limits of '{}' bar the shorter turn to the goal.\n", name);
  return text;
}

}  // namespace leeway::tools
