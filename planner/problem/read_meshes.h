#pragma once

// Private to planner/: the key `meshes`, and what is said of meshes that are not closed.

#include <set>
#include <string>

#include "leeway/planner/problem.h"
#include "leeway/robots/model.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// Reads `meshes` into load.meshes. Throws robots::InputError.
void readMeshes(const YamlReader& meshes, robots::LoadOptions& load);

/// Throws robots::InputError for a name that no mesh has. `found`: LoadOptions::meshes_found, after
/// all that may have meshes was read.
void expectMeshesFound(const YamlReader& meshes, const std::set<std::string>& found,
                       const Problem& problem);
/// The same of LoadOptions::meshes, as a program gives them. The robot may have been loaded before:
/// names of its links that have shapes count as found. `file`: for the message.
void expectMeshesFound(const robots::LoadOptions& load, const std::set<std::string>& found,
                       const std::string& file, const Problem& problem);

/// Appends a warning that begins with `file` where meshes of objects are not closed. (Those of the
/// robot are in its model's warnings.)
void warnOfOpenMeshes(const std::string& file, Problem& problem);

}  // namespace leeway::planner
