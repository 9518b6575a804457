#pragma once

#include <memory>
#include <vector>

#include "tools/report/mesh_engine.h"

namespace leeway::tools::report {

/// Our deforming meshes behind the rivals' interface, one engine a strategy: "leeway refit", ...;
/// "leeway hybrid moved" is told, besides the vertices, how far the motion can have taken them.
std::vector<std::unique_ptr<MeshEngine>> makeOwnMeshEngines();

}  // namespace leeway::tools::report
