#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads an entry of `allowed`: returns the pairs of names of its links, objects or groups.
using ReadPair = std::function<std::vector<std::pair<std::string, std::string>>(const YamlReader&)>;

/// Reads `steps:` of a problem file, after start, objects and frames. Fails for names that do not
/// exist when their step begins, and for steps that contradict those before them.
void readSteps(const YamlReader& reader, const ReadPair& readPair, Problem& problem);

/// Reads `waypoints:` of a problem file: a task of one line.
void readWay(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
