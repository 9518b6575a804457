#pragma once

// Private: how documents and files list what a certificate does not cover.

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/problem.h"

namespace leeway::planner {

/// {"pairs": count, "reasons": [{"reason", "pairs", "names": where they are assumed}, ...]}.
nlohmann::ordered_json uncheckedJson(std::span<const UncheckedPairs> unchecked);
/// The clouds of the world, with the number of balls that each filter removed. An answer is valid
/// for the remaining balls.
nlohmann::ordered_json cloudsJson(const Problem& problem);
/// One of them: the object's.
nlohmann::ordered_json cloudJson(const Object& object);

}  // namespace leeway::planner
