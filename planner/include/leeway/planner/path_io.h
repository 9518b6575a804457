#pragma once

#include <string>

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// Reads .json, .yaml, .csv or .path by its ending. Columns are matched to the problem's planned
/// variables by name (.path: by order); one that is not planned must say what the problem says of
/// it. JSON and YAML: trajectory_msgs/JointTrajectory, alone or under `joint_trajectory`, or what
/// `leeway plan --json` prints. Numbers come back to the bit. Throws robots::InputError.
Path readPath(const std::string& file, const Problem& problem);

/// Writes by ending, whole or not at all (temporary name, then rename). Throws robots::InputError
/// when it cannot, leaving an existing file as it was. Continuous joints are written unwrapped. A
/// path has no times of its own: those written give each edge the time in which every joint keeps
/// its velocity limit (1 rad/s or m/s where it has none) and mean nothing to the certificate.
void writePath(const std::string& file, const Problem& problem, const PlanResult& result);

/// The text of a file, whole or not at all: written under a temporary name beside it, then renamed.
/// Of a symbolic link what it names is replaced; a device or pipe is written to. Throws
/// robots::InputError.
void writeFileWhole(const std::string& file, const std::string& text);

}  // namespace leeway::planner
