#pragma once

#include <string>

#include "leeway/planner/problem.h"
#include "tools/leeway/support/problem_source.h"

namespace leeway::tools::info {

enum class FileKind { kUrdf, kSrdf, kProblem };

/// The kind by the file's ending. Throws robots::InputError for other endings.
FileKind kindOf(const std::string& file);

/// Reads a problem, or a robot as a problem that plans every variable and has no objects. `source`:
/// options of the robot, and the URDF or SRDF that belongs to the file. If it names no URDF for an
/// SRDF, looks for one next to the SRDF. Throws robots::InputError.
planner::Problem loadFile(const std::string& file, FileKind kind, ProblemSource source);

}  // namespace leeway::tools::info
