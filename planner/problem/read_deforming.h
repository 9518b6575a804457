#pragma once

#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads one entry of `deforming:`. Call it after readExecution().
void readDeforming(const YamlReader& reader, const robots::LoadOptions& load, Problem& problem);

}  // namespace leeway::planner
