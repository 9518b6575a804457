#pragma once

// Private to planner/: proofs of motions over time among obstacles that move.

#include <cstddef>
#include <limits>
#include <vector>

#include "leeway/planner/verify.h"
#include "planner/verify/moving_body.h"
#include "planner/verify/task_check.h"

namespace leeway::planner::verification {

/// In place of the step of an edge: nothing moves along it.
constexpr std::size_t kGap = std::numeric_limits<std::size_t>::max();

/// A motion: at constant speed from row to row of a path, the shorter way in continuous joints.
struct TimedPath {
  Path path;
  std::vector<double> times;       ///< of the rows [s]
  std::vector<std::size_t> steps;  ///< the step of each edge, or kGap
  /// Edges on which the robot stands and obstacles that move may reach it, increasing.
  std::vector<std::size_t> exposed;
  std::vector<MovingBody> bodies;
  std::vector<std::vector<Sighting>> known;  ///< in each step, of each body
};

/// Proves that a motion keeps all margins; on its exposed edges, those of pairs without an obstacle
/// that moves. The path has no fault that findFault() finds.
VerifyResult verifyTimed(const Problem& problem, TimedPath& motion, const PlanOptions& options,
                         const ClearanceWish& wish);

}  // namespace leeway::planner::verification
