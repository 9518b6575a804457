#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/mesh_engine.h"

namespace leeway::tools::report {

/// AABB and OBBRSS hierarchies, each refitted and rebuilt.
std::vector<std::unique_ptr<MeshEngine>> makeFclMeshEngines();

}  // namespace leeway::tools::report
