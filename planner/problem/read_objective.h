#pragma once

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// What a problem file's `objective` asks for: a word, or a map of one word with what is asked
/// besides.
Objective readObjective(const YamlReader& objective);

}  // namespace leeway::planner
