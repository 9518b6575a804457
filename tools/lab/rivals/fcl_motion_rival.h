#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/motion_engine.h"

namespace leeway::tools::report {

/// Conservative advancement of shapes and meshes; a thousand discrete steps (FCL's default method,
/// which uses ten); cubic polynomials for triangles.
std::vector<std::unique_ptr<ContactEngine>> makeFclMotionEngines();

}  // namespace leeway::tools::report
