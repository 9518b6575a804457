#pragma once

#include <string>
#include <vector>

#include "leeway/planner/plan.h"

namespace leeway::planner {

enum class VerifyStatus : unsigned char { kCertified, kRefuted, kUndecided };

/// What an independent proof says of a path.
struct VerifyResult {
  VerifyStatus status = VerifyStatus::kUndecided;
  int segment = -1;       ///< where it fails or cannot be decided
  double t0 = 0, t1 = 0;  ///< between which fractions of the segment
  std::string a, b;       ///< between what
  /// Proven for the whole path when certified [m]; infinite without pairs. Rounding apart, what it
  /// exceeds the margin by is at least a quarter of what the true clearance does.
  double clearance_lower = 0;
  std::string reason;  ///< also: a waypoint outside limits, start or goal not the problem's
};

/// Slow, plain, independent of everything that plans: its own kinematics, first-order bounds
/// (speed, not acceleration), no batches, no coarse bounds, no caches; shares only the shapes'
/// distance() and the definition of an edge. Proves, never samples.
VerifyResult verify(const Problem& problem, const Path& path, const PlanOptions& options = {});

}  // namespace leeway::planner
