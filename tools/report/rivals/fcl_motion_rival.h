#pragma once

#include <memory>
#include <vector>

#include "tools/report/base/motion_engine.h"

namespace leeway::tools::report {

/// Conservative advancement of shapes and of meshes; a thousand steps, which is what FCL does by
/// default (with ten); its cubic polynomials for triangles.
std::vector<std::unique_ptr<ContactEngine>> makeFclMotionEngines();

}  // namespace leeway::tools::report
