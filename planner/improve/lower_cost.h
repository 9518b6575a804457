#pragma once

#include <cstdint>
#include <functional>

#include "planner/improve/improve_path.h"
#include "planner/objective/path_cost.h"

namespace leeway::planner {

struct LowerCostOptions {
  std::uint64_t seed = 1;
  double enough = 0;           ///< ends once the path is proven to cost no more
  std::function<bool()> stop;  ///< polled before every edge; true ends with the path so far
};

/// Lowers the proven cost of a path, in place, by rounds of moves as long as these gain. A move
/// shifts a waypoint against the gradient of its cost or at random, bends an edge away from nearby
/// obstacles, cuts between two places of the path, or removes a waypoint. It is taken if its edges
/// are certified and the upper end of the path's cost falls; the interval of a candidate is
/// narrowed only as far as that comparison needs. The path's ends never change. Returns the upper
/// end. Deterministic unless stopped.
double lowerCost(EdgeCertifier& certifier, PathCost& cost, Waypoints& path,
                 const LowerCostOptions& options);

}  // namespace leeway::planner
