#include "tools/leeway/support/robot_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "leeway/robots/input_error.h"
#include "leeway/robots/text.h"

namespace leeway::tools {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

[[noreturn]] void badState(const std::string& text, const std::string& message) {
  throw robots::InputError("command line", 0, fmt::format("--state '{}': {}", text, message));
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

std::vector<double> parseConfiguration(const planner::Problem& problem, const std::string& text) {
  const robots::Model& model = *problem.robot.model;
  std::vector<double> q = problem.start;
  if (text == "start") return q;
  for (const robots::GroupState& state : model.group_states) {
    if (state.name != text) continue;
    for (const auto& [variable, value] : state.values) q[at(variable)] = value;
    return q;
  }
  const std::vector<std::string> parts = splitAt(',', text);
  if (text.find('=') == std::string::npos) {
    const std::vector<int>& planned = problem.robot.variables;
    if (parts.size() != planned.size()) {
      badState(text, fmt::format("is neither start or a group state, nor {} numbers, nor "
                                 "NAME=VALUE,...",
                                 planned.size()));
    }
    for (std::size_t i = 0; i < parts.size(); ++i)
      q[at(planned[i])] = parseNumber("--state", parts[i]);
    return q;
  }
  std::vector<char> given(q.size(), 0);
  for (const std::string& part : parts) {
    const std::size_t equals = part.find('=');
    const int variable = model.findVariable(part.substr(0, equals));
    if (equals == std::string::npos || variable < 0) {
      badState(text, fmt::format("'{}' is not NAME=VALUE of a joint's variable", part));
    }
    if (given[at(variable)]) badState(text, fmt::format("gives {} twice", part.substr(0, equals)));
    given[at(variable)] = 1;
    q[at(variable)] = parseNumber("--state", part.substr(equals + 1));
  }
  return q;
}

}  // namespace leeway::tools
