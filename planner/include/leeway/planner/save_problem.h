#pragma once

#include <string>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Writes a problem as a problem file (problems/README.md): `file` ends in .yaml or .yml. Meshes of
/// objects, and the robot's own limits on its motion, are written into the folder STEM.files beside
/// it; the robot's URDF and SRDF are named, relative to the file where they are below its folder.
/// Numbers read back to the bit, rotations to 1e-14. Ranges, groups and poses may be written in
/// other words that mean the same: frames may be added for poses that no frame or link has. What
/// filters removed from clouds, names of wishes, and warnings are not written.
///
/// The new file is loaded and compared with the problem before it replaces an existing one.
/// Throws robots::InputError, leaving an existing file as it was, for what files cannot say, as
/// validate() does, and for a file that cannot be written; robots::Stopped. O(problem), and loading
/// it.
void saveProblem(const Problem& problem, const std::string& file, const robots::Stop& stop = {});

}  // namespace leeway::planner
