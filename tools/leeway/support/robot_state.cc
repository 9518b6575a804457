#include "tools/leeway/support/robot_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>

#include "collision/base/numbers.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"

namespace leeway::tools {

void badState(const std::string& text, const std::string& message) {
  throw robots::InputError("command line", 0, fmt::format("--state '{}': {}", text, message));
}

std::string meantState(const robots::Model& model, const std::string& text,
                       std::vector<std::string> words) {
  if (text.find_first_of(",=") != std::string::npos || robots::parseNumber(text)) return "";
  for (const robots::GroupState& state : robots::namedStates(model)) {
    // Several groups may have states of the same name.
    if (std::find(words.begin(), words.end(), state.name) == words.end())
      words.push_back(state.name);
  }
  return planner::didYouMean(model, "group state", text, words);
}

std::optional<robots::GroupState> findState(const planner::Problem& problem,
                                            const std::string& name) {
  const std::vector<int>& planned = problem.robot.variables;
  if (const std::string why = problem.robot.model->whyStateLeftOut(name, planned); !why.empty())
    badState(name, "is not known" + why);
  std::vector<robots::GroupState> found;
  for (const robots::GroupState& state : robots::namedStates(*problem.robot.model)) {
    if (state.name != name) continue;
    const auto gives = [&](int variable) {
      return std::any_of(state.values.begin(), state.values.end(),
                         [&](const auto& value) { return value.first == variable; });
    };
    if (std::all_of(planned.begin(), planned.end(), gives)) return state;
    found.push_back(state);
  }
  if (found.empty()) return std::nullopt;
  // Where a whole robot is planned, as one that is read alone, a state is of some of its joints.
  if (found.size() == 1 && planned.size() == problem.robot.model->variables.size())
    return found.front();
  badState(name, robots::stateLackFault(*problem.robot.model, name, planned));
}

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

std::vector<std::string> listed(const std::string& text) {
  if (text.find('=') != std::string::npos) return splitAt(',', text);
  std::vector<std::string> values;
  for (const std::string& part : splitAt(',', text)) {
    std::istringstream words(part);
    const std::size_t before = values.size();
    for (std::string word; words >> word;) values.push_back(word);
    if (values.size() == before) values.emplace_back();  // an error of its reader: "1,,2"
  }
  return values;
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

std::vector<double> parseConfiguration(const planner::Problem& problem, const std::string& text) {
  const robots::Model& model = *problem.robot.model;
  std::vector<double> q = problem.start;
  if (text == "start") return q;
  if (const auto state = findState(problem, text)) {
    for (const auto& [variable, value] : state->values) q[at(variable)] = value;
    return q;
  }
  const std::vector<std::string> parts = listed(text);
  if (text.find('=') == std::string::npos) {
    const std::vector<int>& planned = problem.robot.variables;
    if (parts.size() != planned.size()) {
      badState(text, fmt::format("is neither start or a group state, nor {} numbers, nor "
                                 "NAME=VALUE,...{}",
                                 planned.size(), meantState(model, text, {"start"})));
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].empty())
        badState(text, fmt::format("value {} is empty; a number for {} is expected", i + 1,
                                   model.variables[at(planned[i])].name));
      q[at(planned[i])] = parseNumber("--state", parts[i]);
    }
    return q;
  }
  std::vector<char> given(q.size(), 0);
  for (const std::string& part : parts) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos)
      badState(text, fmt::format("'{}' is not NAME=VALUE of a joint's variable", part));
    const std::string name = part.substr(0, equals);
    const int variable = model.findVariable(name);
    if (variable < 0) {
      std::vector<std::string> known;
      for (const robots::Variable& other : model.variables) known.push_back(other.name);
      badState(text, fmt::format("the robot has no variable '{}'{}", name,
                                 planner::didYouMean(name, known)));
    }
    if (given[at(variable)]) badState(text, fmt::format("gives {} twice", name));
    given[at(variable)] = 1;
    q[at(variable)] = parseNumber("--state", part.substr(equals + 1));
  }
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
