#pragma once

#include <cstdint>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/model.h"
#include "tools/leeway/support/json_result.h"

// The contents of a robot or problem as JSON. Lengths in metres, times in seconds, angles in
// radians.

namespace leeway::tools::info {

/// Links, joints by type, variables with limits (null: unlimited), groups and states.
Json robotJson(const robots::Model& model);

/// Planned variables, goals, objects, deforming obstacles, and the execution's settings.
Json problemJson(const planner::Problem& problem);

/// One entry for every collision shape of links, objects and attached objects.
Json geometriesJson(const planner::Problem& problem);

/// Bodies and pairs that are checked, dropped pairs with reasons, and the pairs that touch in none
/// or in all of `samples` random configurations.
Json compiledJson(const planner::CompiledScene& scene, int samples, std::uint64_t seed);

}  // namespace leeway::tools::info
