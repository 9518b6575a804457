#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/replanner.h"
#include "tools/view/least_clearance.h"

namespace leeway::tools::view {

/// When, and where the robot was.
struct ExecutedPlace {
  double time = 0;  ///< [s]
  std::vector<double> position;
};

/// The least clearances that the certified steps of an execution kept, from the world and of the
/// robot from itself. `least` has no segments.
struct ExecutedClearance {
  LeastClearance least;
  ExecutedPlace world, self;  ///< of the upper ends; without a position: nothing is near
  /// Whether the motions of all obstacles are known. If not, the clearances hold for all
  /// motions of the obstacles within their bounds, and have no upper end.
  bool is_known = true;
  bool is_self_nearer = false;  ///< the robot comes nearer to itself than to the world
  bool has_obstacles = false;   ///< that move

  const ExecutedPlace& all() const { return is_self_nearer ? self : world; }
};

/// Refines the clearances of steps as people see them, as leastClearance() does for paths: parts of
/// the motion are halved until the obstacles stand nearly still in each. `stop` may return true to
/// accept wider intervals. Work limits leave them wider where a robot keeps its distance from what
/// moves fast.
ExecutedClearance executedClearance(const planner::Problem& problem,
                                    const std::shared_ptr<const planner::CompiledScene>& scene,
                                    const std::vector<planner::ReplanStep>& steps,
                                    const std::function<bool()>& stop = {});

/// Where it was nearest, for people: "Nearest: hand and post, 42.86 mm, at 0.85 s."; empty if
/// nothing is near. `certified`: all steps are.
std::string nearestText(const ExecutedClearance& executed, bool certified);
/// The clearance that every step is proven to keep: "least clearance 42.86 mm", "at least 5.00 mm",
/// ...
std::string keptText(const ExecutedClearance& executed);

}  // namespace leeway::tools::view
