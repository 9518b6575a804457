#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "tools/leeway/support/json_result.h"

namespace leeway::tools {

/// Settings from the command line, which take the place of the problem's.
struct PlanOverrides {
  /// The text of each setting (leeway/planner/settings.h) that was given, by the setting's name.
  std::map<std::string, std::string, std::less<>> given;
  std::optional<double> hinge, inverse;  ///< of an integral [m]
  std::optional<double> length_weight;
  std::vector<std::string> upright;  ///< frame, axis, angle
  std::string certificate = "path";

  std::optional<double> timeLimit() const;  ///< [s]
  /// Each setting that was given, by its name.
  Json json() const;
};
/// interactivePlanOptions() for a plan of `problem`, with the certificate that is asked for.
planner::PlanOptions planOptions(const PlanOverrides& overrides, const planner::Problem& problem);

/// What is wrong with the text of a seed; empty: nothing. CLI11 alone takes -1 for the largest.
std::string seedError(const std::string& text);
/// Validators of option values, as CLI::Range but for NaN, which that takes, and counts too large
/// for their type.
CLI::Validator numberFrom(double lower, double upper);
CLI::Validator countFrom(std::int64_t lower,
                         std::int64_t upper = std::numeric_limits<std::int64_t>::max());
/// --seed and --time: for verbs that answer questions about what is given.
void addRunLimits(CLI::App& app, PlanOverrides& overrides);
/// Those and the options of all other settings: for verbs that plan.
void addPlanOverrides(CLI::App& app, PlanOverrides& overrides);

void apply(const PlanOverrides& overrides, planner::Problem& problem);

}  // namespace leeway::tools
