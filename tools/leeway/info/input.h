#pragma once

#include <string>

#include "leeway/planner/problem.h"
#include "tools/leeway/support/problem_source.h"

namespace leeway::tools::info {

enum class FileKind { kUrdf, kSrdf, kProblem };

/// By the file's ending. Throws robots::InputError for another one.
FileKind kindOf(const std::string& file);

/// Reads a problem, or a robot as a problem that plans every variable and has no objects.
/// `source`: options of the robot, and the URDF or SRDF that belongs to the file; the URDF of an
/// SRDF is looked for beside it where `source` names none. Throws robots::InputError.
planner::Problem loadFile(const std::string& file, FileKind kind, ProblemSource source);

}  // namespace leeway::tools::info
