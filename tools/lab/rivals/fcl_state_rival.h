#pragma once

#include <memory>

#include "tools/lab/base/state_engine.h"

namespace leeway::tools::report {

/// Contacts of all pairs whose bounding spheres intersect. Above a number of fixed bodies, FCL's
/// dynamic tree finds the near ones. Meshes are OBBRSS hierarchies.
std::unique_ptr<StateEngine> makeFclStateEngine();

}  // namespace leeway::tools::report
