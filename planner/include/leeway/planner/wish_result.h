#pragma once

#include <optional>

#include "leeway/collision/interval.h"

namespace leeway::planner {

/// What became of one of Margins::wishes along a path.
struct WishResult {
  collision::Interval clearance;  ///< the least [m]; (inf, inf): nothing to be near
  /// Everywhere: proven, or refuted; nothing: not decided, or none of its pairs is checked.
  std::optional<bool> kept;
  collision::Interval cost;  ///< of missing it, its weight included
};

}  // namespace leeway::planner
