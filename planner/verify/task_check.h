#pragma once

#include "leeway/planner/verify.h"

namespace leeway::planner::verification {

/// Decides when the interval of the clearance is narrow enough. `is_enough` is the function that
/// verify() takes; null means always. It gets the least clearance of this path and of `others`.
struct ClearanceWish {
  std::function<bool(const Interval&)> is_enough;
  Interval others{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// verify() for a problem with steps. The path must say which of its waypoints belong to which
/// step. Verifies each stretch in the world of its step, from the end of the step before. Proves by
/// first-order bounds that lines are as straight as the steps require.
VerifyResult verifyTask(const Problem& problem, const Path& path, const PlanOptions& options,
                        const ClearanceWish& wish);

/// verify() for a valid problem without steps.
VerifyResult verifyValid(const Problem& problem, const Path& path, const PlanOptions& options,
                         const ClearanceWish& wish);

}  // namespace leeway::planner::verification
