#pragma once

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// One entry of `deforming:`. After readExecution().
void readDeforming(const YamlReader& reader, const robots::LoadOptions& load, Problem& problem);

}  // namespace leeway::planner
