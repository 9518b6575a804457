#pragma once

#include "leeway/planner/verify.h"

namespace leeway::planner::verification {

/// verify() of a problem with steps: the path must say which of its waypoints belong to which step.
/// Each stretch is verified in the world of its step, from where the one before has ended; lines
/// are proven to be as straight as they must, by first-order bounds.
VerifyResult verifyTask(const Problem& problem, const Path& path, const PlanOptions& options);

/// verify() of a valid problem without steps.
VerifyResult verifyValid(const Problem& problem, const Path& path, const PlanOptions& options);

}  // namespace leeway::planner::verification
