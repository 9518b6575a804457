#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/mesh_engine.h"

namespace leeway::tools::report {

/// Quantised hierarchies, refitted and rebuilt, without distance queries.
std::vector<std::unique_ptr<MeshEngine>> makeBulletMeshEngines();

}  // namespace leeway::tools::report
