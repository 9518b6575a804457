#pragma once

#include <optional>

#include "planner/search/search.h"

namespace leeway::planner {

struct CostPath {
  Waypoints path;
  bool simplified = false;
};

/// A path whose cost is as low as the limits allow, by a planner without a notion of costs: first
/// paths are shortened and lowered by lowerCost(), and the cheapest is taken. Ends after a number
/// of paths in a row without a cheaper one, or once a path costs at most `enough`.
std::optional<CostPath> searchCost(Search& search, PathCost& cost, const SearchTask& task,
                                   double enough);

}  // namespace leeway::planner
