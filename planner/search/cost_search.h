#pragma once

#include <optional>

#include "planner/search/search.h"

namespace leeway::planner {

struct CostPath {
  Waypoints path;
  bool simplified = false;
};

/// A path whose cost is as low as the limits allow, by a planner that knows nothing of costs: first
/// paths, shortened, and each lowered by lowerCost(); the cheapest is taken. Ends when a number in
/// a row are no cheaper, or where one costs no more than `enough`.
std::optional<CostPath> searchCost(Search& search, PathCost& cost, const SearchTask& task,
                                   double enough);

}  // namespace leeway::planner
