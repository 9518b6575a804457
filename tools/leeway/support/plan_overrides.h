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
#include "tools/leeway/support/problem_source.h"

namespace leeway::tools {

/// Settings from the command line, which replace the problem's.
struct PlanOverrides {
  /// The text of each setting (leeway/planner/settings.h) that was given, by the setting's name.
  std::map<std::string, std::string, std::less<>> given;
  std::optional<double> hinge, inverse;  ///< of an integral [m]
  std::optional<double> length_weight;
  std::vector<std::string> upright;  ///< frame, axis, angle
  std::string certificate = "path";

  std::optional<double> timeLimit() const;  ///< [s]
  /// The given settings by their names.
  Json json() const;
};
/// interactivePlanOptions() for a plan of `problem`, with the certificate detail for its output.
planner::PlanOptions planOptions(const PlanOverrides& overrides, const planner::Problem& problem);

/// Adds --seed of something that has a seed of its own.
void addSeed(CLI::App& app, const char* help, std::uint64_t& seed);
/// Adds --samples and --seed of random configurations.
void addSamples(CLI::App& app, const char* help, int& samples, std::uint64_t& seed);
/// Validators of option values. Unlike CLI::Range, they refuse NaN, and counts that are too large
/// for their type.
CLI::Validator numberFrom(double lower, double upper);
CLI::Validator countFrom(std::int64_t lower,
                         std::int64_t upper = std::numeric_limits<std::int64_t>::max());
/// Adds --seed and --time, for verbs that check given states or paths.
void addRunLimits(CLI::App& app, PlanOverrides& overrides);
/// Adds --upright, for verbs that know constraints.
void addUpright(CLI::App& app, PlanOverrides& overrides);
/// Adds what a path is proven for, for verbs that prove paths again: --keep, the scales of limits,
/// --upright.
void addTerms(CLI::App& app, PlanOverrides& overrides);
/// Adds those and the options of all other settings, for verbs that plan.
void addPlanOverrides(CLI::App& app, PlanOverrides& overrides);

void apply(const PlanOverrides& overrides, planner::Problem& problem);
/// loadProblem() with these settings.
planner::Problem loadProblem(const ProblemSource& source, const PlanOverrides& overrides);

}  // namespace leeway::tools
