#include <fmt/format.h>
#include <fmt/ranges.h>

#include "leeway/planner/planners.h"
#include "tools/leeway/manual/manual.h"
#include "tools/leeway/support/robot_state.h"

namespace leeway::tools {

ValueKind valueKind(const CLI::Option& option) {
  ValueKind kind;
  if (option.get_items_expected_max() == 0) return kind;
  kind.takes_value = true;
  // As `--help` shows it: "FILE", or with the words of CLI::IsMember, "TEXT:{a,b}".
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{');
  if (open != std::string::npos && type.find('}', open) != std::string::npos) {
    kind.choices = splitAt(',', type.substr(open + 1, type.find('}', open) - open - 1));
  } else if (type == "PLANNER") {
    for (const planner::PlannerTraits& planner : planner::plannerNames()) {
      kind.choices.push_back(planner.name);
    }
  } else {
    for (const char* word : {"FILE", "FOLDER", "URDF", "SRDF", "YAML", ".yaml", "PATH"}) {
      kind.file = kind.file || type.find(word) != std::string::npos;
    }
    kind.file = kind.file || type == "DIR";
  }
  kind.name = open == std::string::npos ? type : fmt::format("{}", fmt::join(kind.choices, "|"));
  return kind;
}

std::vector<const CLI::Option*> longOptions(const CLI::App& verb) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->get_lnames().empty()) options.push_back(option);
  }
  return options;
}

std::vector<const CLI::Option*> positionals(const CLI::App& verb) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : verb.get_options()) {
    if (option->get_positional()) options.push_back(option);
  }
  return options;
}

}  // namespace leeway::tools
