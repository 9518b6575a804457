#pragma once

// Private to the layers above robots/: compile_scene.cc has it.

#include <span>
#include <string>

#include "leeway/planner/compiled_scene.h"

namespace leeway::planner {

/// The reason in words why a point is undecided wherever bodies are: a continuous joint beyond -pi
/// to pi that a mimic joint follows with a factor that is not an integer. Otherwise empty.
std::string whyUndecided(const CompiledScene& scene, std::span<const double> point);

}  // namespace leeway::planner
