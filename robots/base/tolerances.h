#pragma once

// Tolerances of robots/: unit, reason, and the effect of a change. First those that guarantees
// depend on, then those that only trade time for tightness. As in collision/base/tolerances.h, some
// numbers are kept next to their algorithm instead.

#include "collision/base/tolerances.h"

namespace leeway::robots {

// ------------------------------------------------------------------------------------------------
// Guarantees. Smaller roundings and slacks make bounds wrong, larger ones only loosen them. For
// limits on input and for kGapInwards it is the reverse.

/// Rounding of a reach, relative to it and in metres. A walk over a hundred joints rounds by 1e-14
/// of the coordinates.
inline constexpr double kReachRounding = 1e-12;

/// Rounding of a joint's pose, as a fraction of the lengths above it. Derived in kinematics.cc.
inline constexpr double kJointRounding = 256 * collision::kUnitRoundoff;

/// Relative rounding of a sum of about a hundred positive terms, and of halving a box (an ulp
/// each).
inline constexpr double kBoundRounding = 1e-12;

/// A proof that links stay apart needs a distance that exceeds the motion by this length [m]: the
/// rounding of kinematics for robots of up to 1e5 m.
inline constexpr double kApartSlack = 1e-9;

/// Limit on origins in a URDF [m], the same as for positions in problem files. Within it, bounds
/// have digits far below a nanometre.
inline constexpr double kFarthestOrigin = 1e9;
/// Limit on joint limits [rad or m]. Files write numbers up to 1e16 for "no limit"; larger ones
/// make the range infinite.
inline constexpr double kGreatestLimit = 1e16;
/// Limits of a mimic joint that narrow a range by no more than this are ignored, because dividing
/// by a multiplier rounds [rad or m].
inline constexpr double kSameLimit = 1e-9;
/// A value that a file states for a mimic joint follows from its master's up to this: the digits
/// that setup assistants write [rad or m]. A smaller one warns of rounding.
inline constexpr double kSameStated = 1e-4;

/// Up to this share of its coordinates, a polygon of a mesh file counts as planar and as not
/// crossing itself: the departure from a plane that single precision and six digits leave. Its
/// triangles are then one of the surfaces that it can mean, and no other is farther away. A larger
/// value loses cover without a message; a smaller one covers flat faces as if they were thick, with
/// a warning.
inline constexpr double kPlanarShare = 1e-6;
/// For this share, coordinates count up to this many times the size of the polygon, however far
/// away it is. Digits are not lost to an offset that double precision has room for ...
inline constexpr double kPlanarOffset = 10;
/// ... up to this share of the offset.
inline constexpr double kPlanarRounding = 16 * collision::kUnitRoundoff;

/// Rounding of coordinates and angles in provenGaps(): relative, and in metres and radians.
inline constexpr double kGapSlack = 1e-9;

/// Edges that rise by less than this are not clipped to a slice [m], because clipping them would
/// round by more than kGapSlack.
inline constexpr double kGapLevel = 1e-6;

/// Share of a proven gap that is stored; after rounding to single precision it is still below the
/// gap.
inline constexpr double kGapInwards = 1 - 1e-6;

/// Rounding in a proof that a pose is out of reach: relative to the sizes involved, and in metres
/// and radians. Kinematics of a chain round by 1e-14 of its sizes.
inline constexpr double kProofSlack = 1e-11;

// ------------------------------------------------------------------------------------------------
// Tuning: any positive value is safe, unless stated otherwise.

/// Axes that are parallel (the sine between them) or meet (their distance [m]) to within this have
/// a closed form of inverse kinematics. It allows for the digits that a URDF loses. With a larger
/// value, solutions need longer polishing.
inline constexpr double kSameAxis = 1e-7;
/// A subproblem of a closed form counts as singular if it is this close to having one solution or
/// none, or any angle (relative). It must exceed the error that kSameAxis leaves in the
/// subproblem's numbers.
inline constexpr double kSingular = 1e-6;
/// The least sine between axes that count as meeting: their point is then known to a hundred times
/// the axes' rounding.
inline constexpr double kMeetingSine = 0.01;

/// Solutions of inverse kinematics whose variables all differ by less than this are one solution
/// [rad or m]: at a singular pose, an error of 1e-13 separates them by its root.
inline constexpr double kSameSolution = 1e-5;
/// Limits that omit less than this of a turn count as a whole turn that was written in few digits
/// [rad].
inline constexpr double kWholeTurnGap = 1e-4;
/// A solution of a closed form that is this far outside a limit is moved onto the limit and
/// polished [rad]. A smaller value loses solutions on limits.
inline constexpr double kPolished = 1e-5;
/// If a redundant arm is this close to its poses (the search's squared error), the search moves it
/// there, because it moves all joints a little. The closed form would leave one joint where it is.
inline constexpr double kNearPosesSquared = 0.01;
/// Below this squared error a search is close to its solution, and only rounding ends it.
inline constexpr double kNearSolutionSquared = 1e-10;
/// Squared error from rounding of coordinates below one reach, at which the search ends.
inline constexpr double kSearchRoundingSquared = 1e-29;

/// Proof that a pose is out of reach: a box whose best bound is below this is not split further [m
/// or rad]. A smaller value only delays giving up.
inline constexpr double kSmallestSpread = 1e-6;
/// Axes within this distance of each other meet [m], and axes whose squared sine is at most this
/// are parallel. Both choose the points that the proof examines; any points are correct.
inline constexpr double kProofMeet = 1e-6;
inline constexpr double kProofParallelSquared = 1e-6;

/// provenApart(): configurations in which pairs are tested first, because pairs that meet in one of
/// them need no proof, and the step between them, for which any irrational number is suitable.
inline constexpr int kApartSamples = 200;
inline constexpr double kGoldenSection = 0.6180339887498949;

/// provenApart(): boxes of configurations that are examined for a pair before it is left to be
/// checked (a few ms).
inline constexpr int kApartBoxes = 2000;
/// provenApart(): after this many boxes, this share of all must be proven; otherwise the rest is
/// not tried, because with many joints between two links the proof does not end.
inline constexpr int kApartTrial = 150;
inline constexpr double kApartTrialShare = 1e-3;

/// provenApart(): boxes are not split below this half width [rad or m]. Pairs that need smaller
/// boxes stay checked.
inline constexpr double kApartSmallest = 1e-3;

/// touchAtJoint(): links this close to each other touch [m]. Surfaces that are meant to meet are
/// apart by the rounding of a URDF's digits.
inline constexpr double kTouch = 1e-6;
/// touchAtJoint(): steps from limit to limit, or of a whole turn, at whose ends links are tested.
/// More steps find smaller gaps between parts that touch almost everywhere; most pairs that
/// separate are found by the first steps.
inline constexpr int kTouchLooks = 128;

/// provenGaps(): slices of a turning body. More slices are tighter and slower.
inline constexpr int kGapSlices = 24;

/// provenGaps(): angles with which the proof starts, and which determine the link that is replaced
/// by its solid of revolution.
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

/// provenGaps(): limit on the distance queries for a pair of links; gaps that need more stay
/// unproven.
inline constexpr int kGapQueries = 5'000;

}  // namespace leeway::robots
