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
  /// A log's robot stands where obstacles that move may reach it (ReplanStep::exposed); all else is
  /// proven.
  kExposed,
};

/// The outcome of an independent proof.
struct VerifyResult {
  VerifyStatus status = VerifyStatus::kUndecided;
  int segment = -1;       ///< edge that fails or is undecided; -1: none, or a log
  int line = 0;           ///< of a log, from 1, that fails or is not proven; 0: none
  double t0 = 0, t1 = 0;  ///< part of that edge, in [0, 1]; of a log: times [s]
  std::string a, b;       ///< bodies that are too near
  /// Lower bound of a certified path's clearance [m]; infinite without pairs. Rounding apart, it
  /// exceeds the margin by at least a quarter of what the true clearance does.
  double clearance_lower = 0;
  /// The least distance that the proof of a certified path met [m]; infinite where it needed
  /// none.
  double clearance_upper = std::numeric_limits<double>::infinity();
  std::string closest_a, closest_b;  ///< bodies with that distance; empty: it needed none
  std::string reason;  ///< in words; also a waypoint outside limits, a wrong start or goal
  std::vector<UncheckedPairs> unchecked;  ///< pairs that were not looked at; of a task in some step
  std::string conditions;                 ///< of a certified path, as Certificate::conditions
};

/// Proves or refutes that a path keeps all margins, on the straight lines between its rows, or on
/// cubics where it has times (Path::times; with a condition these are undecided); never samples,
/// except Problem::condition, at states that lie as Condition::resolution says. Slow, plain, and
/// independent of the planner: its own kinematics, first-order bounds (speed; acceleration only
/// where it bounds that of a line's frame), no batches, coarse bounds or caches. Shared are
/// collision::distance() and the definition of an edge. Conservative advancement, see
/// verify_path.cc. A bad path is refuted, with a reason.
///
/// In a problem with steps, each stretch is verified in the world as the steps before have left it,
/// and lines are proven to be followed; the path must have its steps (Path::steps). Between two
/// rows with times, a line's place goes on with the share of the joints' way, the motion rests
/// between steps, and frames are proven to keep LineStep::speed. The planner and the verifier share
/// the meaning of steps: where things are held and put down, the places that poses name, and the
/// ways of lines. A path meets a start that is given by poses if it begins at them.
///
/// Throws robots::InputError for a problem that validate() refuses, and for one without goals and
/// steps.
///
/// `is_enough`: asked whether the interval of a certified path's clearance is narrow enough; if
/// not, the verifier proves more with the same first-order bounds, about five seconds at most for
/// each stretch. By default the proof of the margins is enough.
VerifyResult verify(const Problem& problem, const Path& path, const PlanOptions& options = {},
                    const std::function<bool(const Interval&)>& is_enough = {});

/// Proves or refutes the log of an execution, the lines that logLine() makes, from the log and the
/// problem alone: that its steps follow each other without gaps, from the problem's start, within
/// the limits on position, velocity, acceleration and jerk, by differences of rows; that the stop
/// of each step brings the robot to rest within them; that each step kept all margins, whatever
/// obstacles did within their motions, or within the bounds that were stated when they were seen,
/// and that its stop would have, by what was known in that step; that no
/// obstacle was seen farther away than its bound allowed while a step relied on it; and that the
/// robot is in a goal where the log says so. In a step that says `exposed`, the robot must go
/// through the stop of the step before, which is proven as above, and then stand, free of itself
/// and of all that stands still; the result then is kExposed. Costs, reasons and clearances in the
/// log are not used; clearances are proven again. What was observed is taken from the log.
///
/// Independent of Replanner as verify() is: rigid obstacles move by the verifier's own kinematics.
/// Shared are collision::distance(), the interpolation, and the vertices and speed bounds of
/// VertexMotion. Continuous joints go the shorter way from row to row. `is_enough`: as for
/// verify().
///
/// Throws robots::InputError, with file and line, for a file that cannot be read, a line that is no
/// document of a log or was changed or cut, a log of another problem; also as Replanner does.
VerifyResult verifyLog(const Problem& problem, const std::string& file,
                       const PlanOptions& options = {},
                       const std::function<bool(const Interval&)>& is_enough = {});

}  // namespace leeway::planner
