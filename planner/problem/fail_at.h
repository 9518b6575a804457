#pragma once

#include <optional>
#include <string>
#include <utility>

#include "planner/validate/checks.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Fails at the line where a section says what is wrong with it.
[[noreturn]] inline void failAt(const YamlReader& section, const Fault& fault) {
  std::optional<YamlReader> place = section.find(fault.key);
  std::string message = fault.message;
  if (place && place->isMap()) {
    if (const auto entry = place->find(fault.name)) place = entry;
  } else if (!fault.name.empty()) {  // one value for all names
    message.erase(message.find("." + fault.name), fault.name.size() + 1);
  }
  place.value_or(section).fail(message);
}

/// A problem that was read, if validate() finds nothing wrong with it. Readers name the line of
/// what is wrong; this is for what they do not look at.
inline Problem validated(Problem problem, const std::string& file) {
  std::string name = std::exchange(problem.name, file);  // for the message
  validate(problem);
  problem.name = std::move(name);
  return problem;
}

}  // namespace leeway::planner
