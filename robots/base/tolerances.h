#pragma once

// Every tolerance of robots/: unit, reason, and what goes wrong when it is changed. What stands
// here and what beside its algorithm is decided as in collision's.

#include "collision/base/tolerances.h"

namespace leeway::robots {

/// Added to every reach, relative to it and as metres: a walk over a hundred joints rounds by 1e-14
/// of the coordinates. Smaller would risk reaches rounded inwards; larger only loosens bounds.
inline constexpr double kReachRounding = 1e-12;

/// Rounding of a joint's place, as a fraction of the lengths above it; derived in kinematics.cc.
/// Smaller breaks the guarantee.
inline constexpr double kJointRounding = 256 * collision::kUnitRoundoff;

/// Relative rounding of sums of some hundred positive terms, and of halving a box (an ulp each).
inline constexpr double kBoundRounding = 1e-12;

/// provenApart(): a distance must beat the motion by this much [m]: kinematics' rounding for robots
/// of up to 1e5 m.
inline constexpr double kApartSlack = 1e-9;

/// provenApart(): boxes looked at for one pair before it is left to be checked (a few ms).
inline constexpr int kApartBoxes = 2000;

/// provenApart(): no box is split below this half width [rad or m]: pairs that come that near stay
/// checked.
inline constexpr double kApartSmallest = 1e-3;

/// provenGaps(): slices of what turns, more of which tell more and take longer; samples are where
/// proofs begin, and tell which of two links to take for turning.
inline constexpr int kGapSlices = 24, kGapSamples = 32;

/// provenGaps(): what is proven by both angles, for pairs whose gap by one is below kNearGap for
/// half of the angles [m]; and the arcs of either that a proof begins and ends with.
inline constexpr double kCellGap = 1e-3, kNearGap = 0.04;
inline constexpr int kGapBlock = 8, kLeastBlock = 2;

/// provenGaps(): no larger gap is proven, and no smaller one; tried is this share of the distance
/// found halfway [m; m; 1].
inline constexpr double kMostGap = 0.1, kLeastGap = 1e-3, kGapShare = 0.75;

/// provenGaps(): queries about one pair of links, after which what is left stays unproven.
inline constexpr int kGapQueries = 5'000;

/// provenGaps(): a gap is told as this much of what is proven, so that single precision rounds none
/// above it.
inline constexpr double kGapInwards = 1 - 1e-6;

/// provenGaps(): rounding of coordinates and angles, relative and in metres and radians; edges that
/// rise less are taken whole [m], so that none is cut with more rounding than that.
inline constexpr double kGapSlack = 1e-9, kGapLevel = 1e-6;

}  // namespace leeway::robots
