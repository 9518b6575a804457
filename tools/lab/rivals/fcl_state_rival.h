#pragma once

#include <memory>

#include "tools/lab/base/state_engine.h"

namespace leeway::tools::report {

/// Contacts of all pairs whose bounding spheres intersect. Above a number of fixed bodies, FCL's
/// dynamic tree finds the near ones. Meshes are OBBRSS hierarchies. The balls of a body are the
/// cells of an octree that have the balls' centres in them, with edges of 2 r / sqrt(3) for the
/// smallest radius; without OctoMap in FCL such bodies are shapes that the engine lacks.
std::unique_ptr<StateEngine> makeFclStateEngine();

}  // namespace leeway::tools::report
