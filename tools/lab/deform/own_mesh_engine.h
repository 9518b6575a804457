#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/mesh_engine.h"

namespace leeway::tools::report {

/// Our deforming meshes behind the rivals' interface, one engine for each strategy: "leeway refit",
/// ... "leeway hybrid moved" uses the motion to bound how far vertices move between frames.
std::vector<std::unique_ptr<MeshEngine>> makeOwnMeshEngines();

}  // namespace leeway::tools::report
