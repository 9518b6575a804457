#include "tools/leeway/support/path_ends.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "leeway/planner/configuration_space.h"
#include "planner/verify/path_check.h"

namespace leeway::tools {
namespace {

/// Half a unit in the last place of a joint value of 8 rad in single precision is 2.4e-7. Robots
/// are not that accurate.
constexpr double kNearEnd = 1e-6;
/// The verifier itself accepts ends that are nearer than this.
constexpr double kExactEnd = 1e-9;

using Kind = planner::ConfigurationSpace::Kind;

/// The point of the goal that is nearest to q, up to whole turns of angles.
std::vector<double> nearestInGoal(const planner::ConfigurationSpace& space,
                                  const planner::Goal& goal, std::vector<double> q) {
  for (const planner::ConfigurationSpace::Part& part : space.parts()) {
    const auto i = static_cast<std::size_t>(part.first);
    const auto [low, high] = goal.ranges[i];
    if (part.kind == Kind::kRotation) {
      // A quaternion is given as a whole, or it is free.
      if (low != high) continue;
      for (std::size_t k = i; k < i + 4; ++k) q[k] = goal.ranges[k].first;
      continue;
    }
    if (!(low <= high)) continue;
    if (part.kind == Kind::kCircle) {
      if (high - low >= 2 * std::numbers::pi) continue;
      const double middle = low / 2 + high / 2;
      q[i] = middle + std::remainder(q[i] - middle, 2 * std::numbers::pi);
    }
    q[i] = std::clamp(q[i], low, high);
  }
  return q;
}

/// The goal of joints that is nearest to q, and the distance; null: none.
std::pair<const planner::Goal*, double> nearestGoal(const planner::ConfigurationSpace& space,
                                                    const planner::Problem& problem,
                                                    const std::vector<double>& q) {
  std::pair<const planner::Goal*, double> nearest{nullptr, std::numeric_limits<double>::max()};
  for (const planner::Goal& goal : problem.goals) {
    if (goal.ranges.size() != q.size()) continue;
    const double off = space.distance(nearestInGoal(space, goal, q), q);
    if (off <= nearest.second) nearest = {&goal, off};
  }
  return nearest;
}

}  // namespace

void addShortest(CLI::App& app, bool& shortest) {
  app.add_flag("--shortest", shortest,
               "the file's continuous joints go the shorter way from row to row; without it rows "
               "mean straight lines, and from 3 to -3 a joint turns by 6 rad");
}

std::vector<std::string> takeNearEnds(const planner::Path& path, planner::Problem& problem) {
  const planner::ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const auto size = static_cast<std::size_t>(space.size());
  std::vector<std::string> warnings;
  if (path.positions.empty() || path.positions.front().size() != size ||
      path.positions.back().size() != size)
    return warnings;
  const std::vector<double>& first = path.positions.front();
  if (const double off = space.distance(startPoint(problem), first);
      problem.start_poses.empty() && off > kExactEnd && off <= kNearEnd) {
    warnings.push_back(
        fmt::format("the path begins {:.2g} off the start, and is taken from there", off));
    for (std::size_t i = 0; i < size; ++i)
      problem.start[static_cast<std::size_t>(problem.robot.variables[i])] = first[i];
  }
  const std::vector<double>& last = path.positions.back();
  if (const auto [goal, off] = nearestGoal(space, problem, last);
      goal != nullptr && off > kExactEnd && off <= kNearEnd) {
    warnings.push_back(
        fmt::format("the path ends {:.2g} off {}, and is taken to there", off, goal->name));
    planner::Goal moved{goal->name, {}};
    for (const double x : last) moved.ranges.emplace_back(x, x);
    problem.goals.push_back(std::move(moved));
  }
  return warnings;
}

std::vector<std::string> strayEnds(const planner::Path& path, const planner::Problem& problem) {
  const planner::ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  std::vector<std::string> messages;
  if (const double off = space.distance(startPoint(problem), path.positions.front());
      !(off <= kNearEnd))
    messages.push_back(fmt::format("the path begins {:.2g} off the problem's start", off));
  const std::vector<double>& last = path.positions.back();
  if (problem.steps.empty() && !(nearestGoal(space, problem, last).second <= kNearEnd) &&
      !planner::verification::isInGoal(problem, space, last))
    messages.emplace_back("the path ends in none of the problem's goals");
  return messages;
}

}  // namespace leeway::tools
