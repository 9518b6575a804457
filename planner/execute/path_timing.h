#pragma once

// Private to planner/: time-optimal speed along a curve in configuration space.

#include <span>
#include <vector>

#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// A piece of a curve q(s), s in [0, length]. q'(s) changes linearly from `first` to `last`, which
/// are equal on a straight piece, and continuously from piece to piece.
struct CurvePiece {
  std::vector<double> first, last;
  double length = 0;  ///< positive
  bool straight = true;
};

/// Times a motion from rest to rest along the pieces (at least one). At every time |dq_i/dt| <=
/// velocity[i] and |d2q_i/dt2| <= acceleration[i], all positive and finite. The last phase has rate
/// and acceleration 0 and begins at the end. Time-optimal on straight pieces. On bent pieces it is
/// optimal among speeds whose acceleration along s is constant in each of kBendCells cells.
///
/// Two passes over linear constraints, after H. Pham and Q.-C. Pham, "A new approach to
/// time-optimal path parameterization based on reachability analysis", 2018. Over a cell, q' and
/// (ds/dt)^2 are linear in s, and so is d2q/dt2. So its values at the ends of the cell bound it.
/// O(pieces, variables).
std::vector<TimedPhase> timeOptimal(std::span<const CurvePiece> pieces,
                                    std::span<const double> velocity,
                                    std::span<const double> acceleration);

/// The time at which the distance `way` along a piece is reached [s].
double timeAt(std::span<const TimedPhase> phases, int piece, double way);

/// The time at which the share `way` in [0, 1] is reached [s]. Bisects, because it has no simple
/// inverse.
double timeAt(const RestToRest& profile, double way);

}  // namespace leeway::planner
