#pragma once

// Private: how documents and files list the pairs that a certificate does not cover.

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "leeway/planner/compiled_scene.h"

namespace leeway::planner {

/// {"pairs": count, "reasons": [{"reason", "pairs", "names": where they are assumed}, ...]}.
nlohmann::ordered_json uncheckedJson(std::span<const UncheckedPairs> unchecked);

}  // namespace leeway::planner
