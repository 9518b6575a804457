#pragma once

#include <memory>
#include <vector>

#include "tools/lab/base/motion_engine.h"

namespace leeway::tools::report {

/// Our timeOfContact(), to within 1e-6 of the motion, default limits.
std::vector<std::unique_ptr<ContactEngine>> makeOwnMotionEngines();

}  // namespace leeway::tools::report
