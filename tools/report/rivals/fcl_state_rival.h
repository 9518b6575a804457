#pragma once

#include <memory>

#include "tools/report/base/state_engine.h"

namespace leeway::tools::report {

/// Contacts of all pairs whose bounding spheres meet; above some things that stand still, of those
/// that FCL's dynamic tree finds near. Meshes as OBBRSS hierarchies.
std::unique_ptr<StateEngine> makeFclStateEngine();

}  // namespace leeway::tools::report
