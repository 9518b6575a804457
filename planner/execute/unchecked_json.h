#pragma once

// Private: how documents and files tell which pairs a certificate does not speak of.

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "leeway/planner/compiled_scene.h"

namespace leeway::planner {

/// {"pairs": how many, "reasons": [{"reason", "pairs", "names": where they are assumed}, ...]}.
nlohmann::ordered_json uncheckedJson(std::span<const UncheckedPairs> unchecked);

}  // namespace leeway::planner
