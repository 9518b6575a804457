#pragma once

// Private to planner/: how fast a curve in configuration space can be gone along.

#include <span>
#include <vector>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// A piece of a curve q(s), s in [0, length]: q'(s) goes linearly from `first` to `last`, which are
/// the same where it is straight. Joined to its neighbours without a jump of q'.
struct CurvePiece {
  std::vector<double> first, last;
  double length = 0;  ///< positive
  bool straight = true;
};

/// From rest to rest along the pieces (at least one) with |dq_i/dt| <= velocity[i] and |d2q_i/dt2|
/// <= acceleration[i] (all positive and finite) at every moment, not only on a grid. The last phase
/// has rate and acceleration 0 and starts when the end is reached. As fast as speeds allow that are
/// constant in acceleration of s over each of kBendCells parts of a bent piece; on straight pieces
/// as fast as can be.
/// Two passes over linear constraints as in H. Pham and Q.-C. Pham, "A new approach to time-optimal
/// path parameterization based on reachability analysis", 2018. With q' and (ds/dt)^2 both linear
/// in s over a cell, so is d2q/dt2: the cell's two ends bound it. O(pieces, variables).
std::vector<TimedPhase> timeOptimal(std::span<const CurvePiece> pieces,
                                    std::span<const double> velocity,
                                    std::span<const double> acceleration);

}  // namespace leeway::planner
