#pragma once

// Private to planner/: the key `meshes`, and warnings about meshes that are not closed.

#include <set>
#include <string>

#include "leeway/planner/problem.h"
#include "leeway/robots/model.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads `meshes` into load.meshes. Throws robots::InputError.
void readMeshes(const YamlReader& meshes, robots::LoadOptions& load);

/// Throws robots::InputError for a name that no mesh has. `found`: LoadOptions::meshes_found, after
/// everything that may have meshes was read.
void expectMeshesFound(const YamlReader& meshes, const std::set<std::string>& found,
                       const Problem& problem);
/// The same for LoadOptions::meshes from a program. The robot may have been loaded before, so the
/// names of its links with shapes count as found. `file`: for the message.
void expectMeshesFound(const robots::LoadOptions& load, const std::set<std::string>& found,
                       const std::string& file, const Problem& problem);

/// Appends a warning, which begins with `file`, for each object with meshes that are not closed.
/// (The robot's meshes are in the warnings of its model.)
void warnOfOpenMeshes(const std::string& file, Problem& problem);

}  // namespace leeway::planner
