#pragma once

// Tolerances of robots/: unit, reason, and what a change breaks. First what guarantees rest on,
// then what only trades time for tightness. What stands here and what beside its algorithm is
// decided as in collision/base/tolerances.h.

#include "collision/base/tolerances.h"

namespace leeway::robots {

// ------------------------------------------------------------------------------------------------
// Guarantees. Of roundings and slacks, smaller values make bounds untrue, larger ones only loosen
// them; of limits on input and of kGapInwards it is the other way.

/// Rounding of a reach, relative to it and in metres. A walk over a hundred joints rounds by 1e-14
/// of the coordinates.
inline constexpr double kReachRounding = 1e-12;

/// Rounding of a joint's pose, as a fraction of the lengths above it. Derived in kinematics.cc.
inline constexpr double kJointRounding = 256 * collision::kUnitRoundoff;

/// Relative rounding of a sum of some hundred positive terms, and of halving a box (an ulp each).
inline constexpr double kBoundRounding = 1e-12;

/// A proof that links stay apart needs a distance that exceeds the motion by this [m]: the rounding
/// of kinematics for robots of up to 1e5 m.
inline constexpr double kApartSlack = 1e-9;

/// What a URDF may say: origins up to this [m], as positions in problem files; bounds keep digits
/// below a nanometre far within it.
inline constexpr double kFarthestOrigin = 1e9;
/// And limits of joints [rad or m]. Files that mean none write up to 1e16; more makes the range
/// infinite.
inline constexpr double kGreatestLimit = 1e16;
/// Limits of a mimic joint that narrow a range by no more than this do not [rad or m]: dividing by
/// a multiplier rounds.
inline constexpr double kSameLimit = 1e-9;

/// A polygon of a mesh file counts as planar, and as not crossing itself, up to this share of its
/// coordinates: what single precision and six digits leave of a plane. Its triangles are then one
/// of the surfaces that it can mean, and no other is farther away. Larger loses cover in silence;
/// smaller covers flat faces as if they were thick, with a warning.
inline constexpr double kPlanarShare = 1e-6;
/// Coordinates count up to this many times the size of the polygon, however far away it is: digits
/// are not lost to an offset that double precision has room for ...
inline constexpr double kPlanarOffset = 10;
/// ... up to this share of it.
inline constexpr double kPlanarRounding = 16 * collision::kUnitRoundoff;

/// Rounding of coordinates and angles in provenGaps(): relative, and in metres and radians.
inline constexpr double kGapSlack = 1e-9;

/// Edges that rise by less are not clipped to a slice [m]: clipping them would round by more than
/// kGapSlack.
inline constexpr double kGapLevel = 1e-6;

/// Share of a proven gap that is stored: rounded to single precision, it stays below the gap.
inline constexpr double kGapInwards = 1 - 1e-6;

/// Rounding in a proof that a pose is out of reach: relative to the sizes in it, and in metres and
/// radians. Kinematics of a chain round by 1e-14 of its sizes.
inline constexpr double kProofSlack = 1e-11;

// ------------------------------------------------------------------------------------------------
// Tuning: any positive value is safe, where nothing else is said.

/// Axes that are parallel (the sine between them) or meet (their distance [m]) to within this have
/// a closed form of inverse kinematics: what a URDF's digits lose. Larger ones are polished longer.
inline constexpr double kSameAxis = 1e-7;
/// A subproblem of a closed form this near to having one solution or none, or any angle, counts as
/// singular (relative). It must exceed what kSameAxis leaves of the subproblem's numbers.
inline constexpr double kSingular = 1e-6;
/// Axes that meet have at least this sine between them: their point is then known to a hundred
/// times the axes' rounding.
inline constexpr double kMeetingSine = 0.01;

/// Solutions of inverse kinematics whose variables all differ by less are one [rad or m]: at a
/// singular pose an error of 1e-13 leaves them apart by its root.
inline constexpr double kSameSolution = 1e-5;
/// Limits that leave out less than this of a turn are those of a whole one, written in few digits
/// [rad].
inline constexpr double kWholeTurnGap = 1e-4;
/// A solution of a closed form this far outside of a limit is moved onto it and polished [rad].
/// Smaller loses solutions on limits.
inline constexpr double kPolished = 1e-5;
/// A redundant arm this near to its poses (the search's squared error) is moved there by the
/// search, which moves all joints a little; the closed form would leave one where it is.
inline constexpr double kNearPosesSquared = 0.01;
/// Below this squared error a search is near its solution, and only rounding ends it.
inline constexpr double kNearSolutionSquared = 1e-10;
/// Squared error that rounding of coordinates below one reach leaves: the search ends.
inline constexpr double kSearchRoundingSquared = 1e-29;

/// Proof that a pose is out of reach: a box whose best bound is below this is not split on [m or
/// rad]. Smaller only delays giving up.
inline constexpr double kSmallestSpread = 1e-6;
/// Axes this near to each other meet [m], and those whose squared sine is no larger are parallel:
/// they choose the points that the proof looks at, of which any are right.
inline constexpr double kProofMeet = 1e-6;
inline constexpr double kProofParallelSquared = 1e-6;

/// provenApart(): configurations in which pairs are looked at first, as those that meet somewhere
/// need no proof, and the step between them, for which any irrational number would do.
inline constexpr int kApartSamples = 200;
inline constexpr double kGoldenSection = 0.6180339887498949;

/// provenApart(): boxes of configurations examined for a pair before it is left to be checked (a
/// few ms).
inline constexpr int kApartBoxes = 2000;
/// provenApart(): after so many boxes such a share of all must be proven, or the rest is not tried:
/// with many joints between two links it never ends.
inline constexpr int kApartTrial = 150;
inline constexpr double kApartTrialShare = 1e-3;

/// provenApart(): no box is split below this half width [rad or m]. Pairs that need smaller ones
/// stay checked.
inline constexpr double kApartSmallest = 1e-3;

/// touchAtJoint(): links this near to each other touch [m]: surfaces that a URDF lets meet are
/// apart by the rounding of its digits.
inline constexpr double kTouch = 1e-6;
/// touchAtJoint(): steps from limit to limit, or of a whole turn, at whose ends links are looked
/// at. More of them find smaller gaps between parts that touch almost everywhere; pairs that come
/// apart are mostly found by the first.
inline constexpr int kTouchLooks = 128;

/// provenGaps(): slices of a turning body. More are tighter and slower.
inline constexpr int kGapSlices = 24;

/// provenGaps(): angles at which the proof begins, and that choose which link to replace by its
/// solid of revolution.
inline constexpr int kGapSamples = 32;

/// provenGaps(): largest and smallest gap that is tried [m], and the first try's share of the
/// distance at the middle of the arc.
inline constexpr double kMostGap = 0.1, kLeastGap = 1e-3, kGapShare = 0.75;

/// provenGaps(): pairs whose gap by one angle is below kNearGap for half of the angles are examined
/// by both angles, for a gap of kCellGap [m].
inline constexpr double kNearGap = 0.04, kCellGap = 1e-3;

/// provenGaps(): arcs of each angle in the largest and the smallest block of cells that is proven
/// at once.
inline constexpr int kGapBlock = 8, kLeastBlock = 2;

/// provenGaps(): distance queries for a pair of links; what they leave open stays unproven.
inline constexpr int kGapQueries = 5'000;

}  // namespace leeway::robots
