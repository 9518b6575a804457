#pragma once

#include <memory>
#include <vector>

#include "tools/report/base/motion_engine.h"

namespace leeway::tools::report {

/// Continuous convex collision (conservative advancement), and the cast by GJK, which knows no
/// rotation.
std::vector<std::unique_ptr<ContactEngine>> makeBulletMotionEngines();

}  // namespace leeway::tools::report
