#pragma once

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// `steps:` of a problem file; after start, objects and frames. Errors for names that do not exist
/// by the time of their step, and for steps that contradict those before them.
void readSteps(const YamlReader& reader, Problem& problem);

/// `waypoints:` of a problem file: a task of one line.
void readWay(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
