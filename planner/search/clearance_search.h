#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "planner/search/search.h"

namespace leeway::planner {

struct ClearancePath {
  Waypoints path;
  double clearance = 0;  ///< certified lower bound [m]
  /// The shortest path's length, for MaximumClearance::at_most_longer; otherwise infinity.
  double shortest = std::numeric_limits<double>::infinity();
  double longest =
      std::numeric_limits<double>::infinity();  ///< greatest allowed length of the path
  bool simplified = false;
  EdgeCertifier::Statistics work = {};  ///< of the searches with raised margins
};

/// For MaximumClearance: a path whose least clearance is as great as the limits allow, by a planner
/// without a notion of clearance. It uses pushes and searches with rising margins, then finds
/// shorter paths with the same clearance; see clearance_search.cc. `bound`: an upper bound on the
/// clearance of every path [m].
std::optional<ClearancePath> searchClearance(const std::shared_ptr<const CompiledScene>& scene,
                                             Search& search, const SearchTask& task, double bound);

}  // namespace leeway::planner
