// Checks the limits, execution, objective and planner of a problem.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/settings.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/space/ompl_planners.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

bool isSize(double x) { return x >= 0 && std::isfinite(x); }
bool isAbove0(double x) { return x > 0 && std::isfinite(x); }

/// "WHERE.KEY is VALUE; EXPECTED is expected".
Fault faultAt(const std::string& where, const char* key, double value,
              const std::string& expected) {
  return {fmt::format("{}.{} is {}; {} is expected", where, key, value, expected), key, {}};
}

/// Returns the fault of limits that are given by the names of planned variables.
std::optional<Fault> byVariableFault(const Problem& problem, const Setting& setting,
                                     const std::map<std::string, double>& limits) {
  if (limits.empty()) return std::nullopt;
  std::vector<std::string> known;
  for (const int v : problem.robot.variables)
    known.push_back(problem.robot.model->variables[at(v)].name);
  const std::string key(setting.key.substr(setting.key.rfind('.') + 1));
  for (const auto& [name, limit] : limits) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      return Fault{fmt::format("{}: no planned variable is named '{}'{}", setting.key, name,
                               didYouMean(name, known)),
                   key, name};
    if (auto fault = numberFault(setting, fmt::format("{}.{}", setting.key, name), limit))
      return Fault{*fault, key, name};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Fault> executionFault(const Problem& problem) {
  const Execution& e = problem.execution;
  if (!(e.duration >= e.step))
    return faultAt("execution", "duration", e.duration,
                   fmt::format("at least a step, {} s,", e.step));
  for (const Setting& setting : settings())
    if (const auto* place =
            std::get_if<SettingPlace<std::map<std::string, double>>>(&setting.value))
      if (auto wrong = byVariableFault(problem, setting, *settingValue(problem, *place)))
        return wrong;
  return std::nullopt;
}

std::optional<Fault> termFault(const CostTerm& term, const std::string& where) {
  const char* key = term.nearness.kind == Nearness::Kind::kHinge ? "hinge" : "inverse";
  if (!isAbove0(term.nearness.distance))
    return faultAt(where, key, term.nearness.distance, "a length above 0 [m]");
  if (!isSize(term.weight)) return faultAt(where, "weight", term.weight, "zero or more");
  return std::nullopt;
}

std::optional<std::string> costFault(const MinimumCost& cost) {
  if (!isSize(cost.length))
    return faultAt("objective", "length", cost.length, "zero or more").message;
  if (cost.length > 0 || std::any_of(cost.terms.begin(), cost.terms.end(),
                                     [](const CostTerm& term) { return !(term.weight <= 0); }))
    return std::nullopt;
  return "the objective weighs nothing; length, integral or worst with a weight above 0 is "
         "expected";
}

bool asksForCost(const Problem& problem) {
  return std::holds_alternative<MinimumCost>(problem.objective) ||
         (std::holds_alternative<MinimumLength>(problem.objective) &&
          !problem.margins.wishes.empty());
}

std::optional<std::string> wishesFault(const Problem& problem) {
  if (problem.margins.wishes.empty() ||
      !std::holds_alternative<MaximumClearance>(problem.objective))
    return std::nullopt;
  return "wishes stand beside the objective clearance, which has no cost that they could add to; "
         "another objective, or margins alone, are expected";
}

std::optional<Fault> wishFault(const Wish& wish, const std::string& where) {
  if (!isAbove0(wish.clearance)) return faultAt(where, "wish", wish.clearance, "a number above 0");
  if (!isAbove0(wish.weight)) return faultAt(where, "weight", wish.weight, "a number above 0");
  return std::nullopt;
}

std::optional<std::string> improveFault(const Problem& problem) {
  const auto improve = problem.planner.parameters.find("improve");
  if (improve == problem.planner.parameters.end()) return std::nullopt;
  const bool is_asked = parameterNumber(improve->second).value_or(0) > 0;
  const bool by_length =
      std::holds_alternative<MinimumLength>(problem.objective) && problem.margins.wishes.empty();
  if (!is_asked || by_length) return std::nullopt;
  return fmt::format(
      "planner parameter 'improve' is {}, beside {}: only paths of the objective length, without "
      "wishes, become shorter; such a problem, or 0, is expected",
      improve->second,
      problem.margins.wishes.empty() ? fmt::format("the objective {}", toString(problem.objective))
                                     : "margins with a wish");
}

std::optional<std::string> costPlannerFault(const Problem& problem) {
  const PlannerTraits* planner = findPlanner(problem.planner.name);
  if (planner == nullptr || !planner->optimizing || !asksForCost(problem)) return std::nullopt;
  const auto* cost = std::get_if<MinimumCost>(&problem.objective);
  const bool adds_up =
      cost == nullptr || std::none_of(cost->terms.begin(), cost->terms.end(),
                                      [](const CostTerm& term) { return term.worst; });
  if (adds_up && planner->costs) return std::nullopt;
  std::string names;
  for (const PlannerTraits& other : plannerNames())
    if (!other.optimizing || (adds_up && other.costs))
      names += (names.empty() ? "" : ", ") + other.name;
  return fmt::format("planner '{}' {}; one of {} is expected", planner->name,
                     adds_up ? "adds up lengths, whatever a path costs"
                             : "adds up costs of edges, and the worst place of a path does not add "
                               "up",
                     names);
}

std::optional<std::string> speedBoundFault(const DeformingObstacle& obstacle, double start) {
  if (!obstacle.motion || !std::isfinite(obstacle.speed_bound)) return std::nullopt;
  const double most = obstacle.motion->speedBound(start, std::numeric_limits<double>::max());
  if (obstacle.speed_bound >= most) return std::nullopt;
  return fmt::format("is {}, and the motion may reach {} m/s; at least that is expected",
                     obstacle.speed_bound, most);
}

std::optional<std::string> speedBoundFault(const Object& object, double start) {
  const ObjectMotion* motion = object.motion.get();
  if (motion == nullptr || !motion->poses) return std::nullopt;
  const double extent = extentOf(object);
  const double bound = pointSpeed(motion->speed_bound, motion->turn_bound, extent);
  const double most = motion->poses->speedBound(start, std::numeric_limits<double>::max(), extent);
  if (bound >= most) return std::nullopt;
  return fmt::format(
      "and that of its turning bound its points to {} m/s, and the motion may reach {} m/s; at "
      "least that is expected",
      bound, most);
}

}  // namespace leeway::planner
