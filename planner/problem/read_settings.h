#pragma once

#include <string_view>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads the settings (settings.h) that stand in `map` itself into `problem`, whose objective must
/// have them. `place`: of the map in the file, "limits"; empty: the file. Settings that have a
/// reader of their own are left out. After an error with the next one where errors are gathered.
void readSettings(const YamlReader& map, std::string_view place, Problem& problem);

void readExecution(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
