#pragma once

#include <optional>
#include <string>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// What a problem file's `objective` asks for: a word, or a map of one word with what is asked
/// besides.
Objective readObjective(const YamlReader& objective);

/// Why the planner's parameter `improve` would be ignored: only paths of the objective length,
/// without wishes, become shorter. Nothing where it is absent, 0, or serves the problem.
std::optional<std::string> improveError(const Problem& problem);

}  // namespace leeway::planner
