#include "tools/leeway/support/robot_state.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "collision/base/numbers.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/read_states.h"

namespace leeway::tools {

void badState(const std::string& text, const std::string& message) {
  throw robots::InputError("command line", 0, fmt::format("--state '{}': {}", text, message));
}

namespace {

/// The end of a message about an unknown state: which of `words` or of the group states may be
/// meant. Empty for numbers that are not finite, and for lists.
std::string meantState(const robots::Model& model, const std::string& text,
                       std::vector<std::string> words) {
  if (text.find(',') != std::string::npos || robots::parseNumber(text)) return "";
  for (const robots::GroupState& state : robots::namedStates(model)) {
    // Several groups may have states of the same name.
    if (std::find(words.begin(), words.end(), state.name) == words.end())
      words.push_back(state.name);
  }
  return planner::didYouMean(model, "group state", text, words);
}

/// Returns the group state of that name that gives all planned joints a value. Where all joints of
/// the robot are planned, the only state of the name will do: other joints are as at the start.
robots::GroupState findState(const planner::Problem& problem, const std::string& name,
                             const std::vector<std::string>& words) {
  const robots::Model& model = *problem.robot.model;
  const std::vector<int>& planned = problem.robot.variables;
  if (const std::string why = model.whyStateLeftOut(name, planned); !why.empty())
    badState(name, "is not known" + why);
  std::vector<robots::GroupState> found;
  for (const robots::GroupState& state : robots::namedStates(model)) {
    if (state.name != name) continue;
    const auto gives = [&](int variable) {
      return std::any_of(state.values.begin(), state.values.end(),
                         [&](const auto& value) { return value.first == variable; });
    };
    if (std::all_of(planned.begin(), planned.end(), gives)) return state;
    found.push_back(state);
  }
  if (found.empty()) {
    std::vector<std::string> names;
    for (const int v : planned) names.push_back(model.variables[at(v)].name);
    badState(name, fmt::format("is neither {} or a group state, nor {} numbers ({}), nor "
                               "NAME=VALUE,...{}",
                               fmt::join(words, ", "), planned.size(), fmt::join(names, ", "),
                               meantState(model, name, words)));
  }
  if (found.size() == 1 && planned.size() == model.variables.size()) return found.front();
  badState(name, robots::stateLackFault(model, name, planned));
}

}  // namespace

std::vector<std::string> splitAt(char separator, const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

double parseNumber(const std::string& option, const std::string& text) {
  const std::optional<double> value = robots::parseFinite(text);
  if (!value) {
    throw robots::InputError("command line", 0,
                             fmt::format("{}: '{}' is not a finite number", option, text));
  }
  return *value;
}

int parseLink(const robots::Model& model, const std::string& name) {
  const int link = model.findLink(name);
  if (link >= 0) return link;
  std::string names;
  for (const robots::Link& known : model.links) names += (names.empty() ? "" : ", ") + known.name;
  throw robots::InputError(
      "command line", 0,
      fmt::format("--link '{}': the robot has no such link; it has {}", name, names));
}

std::vector<double> parseConfiguration(const planner::Problem& problem, const std::string& text,
                                       const std::vector<std::string>& words) {
  std::vector<double> q = problem.start;
  if (text == "start") return q;
  if (planner::namesState(text)) {
    for (const auto& [variable, value] : findState(problem, text, words).values)
      q[at(variable)] = value;
    return q;
  }
  const planner::VariableRanges given = planner::statedRanges("--state", text, problem);
  for (std::size_t v = 0; v < q.size(); ++v)
    if (given[v].given) q[v] = given[v].lower;
  return q;
}

std::string brokenLimit(const planner::ConfigurationSpace& space,
                        const std::vector<double>& point) {
  for (int i = 0; i < space.size(); ++i) {
    const double value = point[static_cast<std::size_t>(i)];
    if (value < space.lower(i) || value > space.upper(i)) {
      const auto variable =
          static_cast<std::size_t>(space.variables()[static_cast<std::size_t>(i)]);
      return fmt::format("{} = {} is outside {} to {}", space.model().variables[variable].name,
                         value, space.lower(i), space.upper(i));
    }
  }
  return {};
}

}  // namespace leeway::tools
