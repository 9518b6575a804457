#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"

namespace leeway::planner {

enum class VerifyStatus : unsigned char {
  kCertified,
  kRefuted,
  kUndecided,
  kNothingChecked,  ///< no pair of shapes is checked: nothing is proven
};

/// The outcome of an independent proof.
struct VerifyResult {
  VerifyStatus status = VerifyStatus::kUndecided;
  int segment = -1;       ///< edge that fails or is undecided
  double t0 = 0, t1 = 0;  ///< part of that edge, in [0, 1]
  std::string a, b;       ///< bodies that are too near
  /// Lower bound of a certified path's clearance [m]; infinite without pairs. Rounding apart, it
  /// exceeds the margin by at least a quarter of what the true clearance does.
  double clearance_lower = 0;
  /// The least distance that the proof of a certified path met [m]; infinite where it needed
  /// none.
  double clearance_upper = std::numeric_limits<double>::infinity();
  std::string reason;  ///< in words; also a waypoint outside limits, a wrong start or goal
  std::vector<UncheckedPairs> unchecked;  ///< pairs that were not looked at; of a task in some step
  std::string conditions;                 ///< of a certified path, as Certificate::conditions
};

/// Proves or refutes that a path keeps all margins, on the straight lines between its rows; never
/// samples, except Problem::condition, at states that lie as Condition::resolution says. Slow,
/// plain, and independent of the planner: its own kinematics, first-order bounds (speed, not
/// acceleration), no batches, coarse bounds or caches. Shared are collision::distance() and the
/// definition of an edge. Conservative advancement, see verify.cc. A bad path is refuted, with a
/// reason. Of a problem with steps each one's stretch is verified in the world as the steps before
/// have left it, and lines are proven to be straight; the path must have its steps (Path::steps).
/// Throws robots::InputError for a problem that validate() refuses, and for one without goals and
/// steps.
///
/// `is_enough`: asked whether the interval of a certified path's clearance is narrow enough; if
/// not, the verifier proves more with the same first-order bounds, about five seconds at most for
/// each stretch. By default the proof of the margins is enough.
VerifyResult verify(const Problem& problem, const Path& path, const PlanOptions& options = {},
                    const std::function<bool(const Interval&)>& is_enough = {});

}  // namespace leeway::planner
