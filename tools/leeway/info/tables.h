#pragma once

#include "tools/leeway/support/json_result.h"

// Print the JSON of description.h to stdout for people. Without `all`, the output fits on one
// screen: long tables show their first rows, and the treatment of meshes is not shown.

namespace leeway::tools::info {

void printRobot(const Json& robot, bool all);
void printProblem(const Json& problem);
/// `is_short`: in numbers instead of a table.
void printGeometries(const Json& geometries, bool all, bool is_short);
void printCompiled(const Json& compiled, bool all);

}  // namespace leeway::tools::info
