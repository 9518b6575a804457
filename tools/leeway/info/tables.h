#pragma once

#include "tools/leeway/support/json_result.h"

// Print the JSON of description.h to stdout for people.

namespace leeway::tools::info {

void printRobot(const Json& robot);
void printProblem(const Json& problem);
void printGeometries(const Json& geometries);
void printCompiled(const Json& compiled);

}  // namespace leeway::tools::info
