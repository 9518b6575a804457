#pragma once

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads `objective:` of a problem file: a word, or a map of one word with the objective's
/// settings.
Objective readObjective(const YamlReader& objective);

}  // namespace leeway::planner
