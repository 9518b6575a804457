#pragma once

#include <string_view>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads the settings (settings.h) with keys in `map` itself into `problem`, whose objective must
/// have them. `place`: the map's place in the file, such as "limits"; empty for the file. Skips
/// settings that have a reader of their own. If errors are gathered, goes on with the next setting
/// after an error.
void readSettings(const YamlReader& map, std::string_view place, Problem& problem);

void readExecution(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
