#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/motion_engine.h"

namespace leeway::tools::report {

/// Continuous convex collision (conservative advancement), and the GJK cast, which ignores
/// rotation.
std::vector<std::unique_ptr<ContactEngine>> makeBulletMotionEngines();

}  // namespace leeway::tools::report
