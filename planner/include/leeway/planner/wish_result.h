#pragma once

#include <optional>

#include "leeway/collision/interval.h"

namespace leeway::planner {

/// How a path keeps one of Margins::wishes.
struct WishResult {
  collision::Interval clearance;  ///< the least [m]; (inf, inf) if nothing is near
  /// Whether it is kept everywhere: proven or refuted; nothing: undecided, or none of its pairs is
  /// checked.
  std::optional<bool> kept;
  collision::Interval cost;  ///< of missing it, including its weight
};

}  // namespace leeway::planner
