#pragma once

#include <optional>
#include <string>
#include <utility>

#include "planner/validate/checks.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Fails with the fault of a section, at the line of the key or name with the fault.
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

/// Returns a problem that was read, after validate(). Readers report their own faults with a line;
/// this check finds the faults that they do not look for.
inline Problem validated(Problem problem, const std::string& file) {
  std::string name = std::exchange(problem.name, file);  // for the message
  validate(problem);
  problem.name = std::move(name);
  return problem;
}

}  // namespace leeway::planner
