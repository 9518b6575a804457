#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "planner/search/search.h"

namespace leeway::planner {

struct ClearancePath {
  Waypoints path;
  double clearance = 0;  ///< certified lower bound [m]
  /// Of MaximumClearance::at_most_longer: the shortest path's length; otherwise infinity.
  double shortest = std::numeric_limits<double>::infinity();
  double longest = std::numeric_limits<double>::infinity();  ///< length that the path may have
  bool simplified = false;
  EdgeCertifier::Statistics work = {};  ///< of the searches with raised margins
};

/// For MaximumClearance: a path whose least clearance is as great as the limits allow, by a planner
/// that knows nothing of clearance: pushes, and searches with rising margins; then shorter ones
/// with no less, see clearance_search.cc. `bound`: no path can have more [m].
std::optional<ClearancePath> searchClearance(const std::shared_ptr<const CompiledScene>& scene,
                                             Search& search, const SearchTask& task, double bound);

}  // namespace leeway::planner
