#pragma once

#include <memory>
#include <vector>

#include "tools/report/base/mesh_engine.h"

namespace leeway::tools::report {

/// Our deforming meshes behind the rivals' interface, one engine a strategy: "leeway refit", ...
/// "leeway hybrid moved" knows the motion, hence bounds how far vertices move between frames.
std::vector<std::unique_ptr<MeshEngine>> makeOwnMeshEngines();

}  // namespace leeway::tools::report
