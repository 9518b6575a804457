#pragma once

#include <memory>

#include "tools/report/base/state_engine.h"

namespace leeway::tools::report {

/// Contacts of all pairs whose bounding spheres meet; meshes as OBBRSS hierarchies.
std::unique_ptr<StateEngine> makeFclStateEngine();

}  // namespace leeway::tools::report
