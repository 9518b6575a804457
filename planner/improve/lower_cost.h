#pragma once

#include <cstdint>
#include <functional>

#include "planner/improve/improve_path.h"
#include "planner/objective/path_cost.h"

namespace leeway::planner {

struct LowerCostOptions {
  std::uint64_t seed = 1;
  double enough = 0;           ///< ends where the path is proven to cost no more
  std::function<bool()> stop;  ///< asked before every edge; true ends with the path so far
};

/// Lowers what a path is proven to cost, in place: moves waypoints against the gradient of their
/// cost, or at random, bends edges away from what is near, cuts between places of the path, and
/// leaves waypoints out, as long as rounds of these gain. A move is taken when its edges are
/// certified and the upper end of the path's cost falls; of a candidate the interval is narrowed
/// only as far as that comparison needs. Its ends never change. Returns the upper end.
/// Deterministic unless stopped.
double lowerCost(EdgeCertifier& certifier, PathCost& cost, Waypoints& path,
                 const LowerCostOptions& options);

}  // namespace leeway::planner
