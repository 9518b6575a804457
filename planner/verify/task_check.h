#pragma once

#include "leeway/planner/verify.h"

namespace leeway::planner::verification {

/// When the interval of the clearance is narrow enough: `is_enough` as verify() has it, null:
/// always. It is called with the least clearance of this path and of other paths, `others`.
struct ClearanceWish {
  std::function<bool(const Interval&)> is_enough;
  Interval others{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// verify() of a problem with steps: the path must say which of its waypoints belong to which step.
/// Each stretch is verified in the world of its step, from where the one before has ended; lines
/// are proven to be as straight as they must, by first-order bounds.
VerifyResult verifyTask(const Problem& problem, const Path& path, const PlanOptions& options,
                        const ClearanceWish& wish);

/// verify() of a valid problem without steps.
VerifyResult verifyValid(const Problem& problem, const Path& path, const PlanOptions& options,
                         const ClearanceWish& wish);

}  // namespace leeway::planner::verification
