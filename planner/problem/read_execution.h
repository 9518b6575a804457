#pragma once

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// `execution:` of a problem file. Before readDeforming(), which needs its start.
void readExecution(const YamlReader& reader, Problem& problem);

}  // namespace leeway::planner
