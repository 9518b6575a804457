#pragma once

// The tolerances of collision/: each with its unit, its reason, and the effect of changing it.
//
// This file has every number that bounds an error, or that is the limit at which a value counts as
// zero, equal, lost or out of range. Two kinds may be kept in their algorithm's file instead:
// counts and shares that only steer it (limits of steps, capacities, costs of work), and the
// factors of an error bound that is derived in the same few lines.
//
// Guarantees depend on part 1: a wrong value there makes an interval wrong. Part 2 only tunes: any
// value leaves every interval correct, and changes time, widths, or which of several correct
// answers is returned.
//
// "Units" are multiples of kUnitRoundoff; "sizes" is the sum of the bodies' extents and their
// distance [m]. Unless stated otherwise, a number has no unit, and a larger rounding constant only
// widens intervals.

namespace leeway::collision {

// =================================================================================================
// Part 1: numbers that guarantees depend on
// =================================================================================================

// Rounding of one operation

/// Unit roundoff of double precision: a correctly rounded operation errs by at most this fraction.
inline constexpr double kUnitRoundoff = 0x1p-53;

/// A norm, or another root of a sum of a few squares, errs by less than 4 units; multiplying it by
/// this factor rounds it outwards. Smaller breaks the guarantee.
inline constexpr double kOutwards = 1 + 0x1p-50;

/// Relative rounding of geometry on meshes and hulls (a point's distance from a triangle, a radius,
/// an extent), as a share of the coordinates involved. About 20 units in the last place are needed;
/// smaller breaks the guarantee.
inline constexpr double kRelativeRounding = 1e-14;

/// Rounding of a composition of two poses, or of the distance of two centres, as a share of the
/// coordinates involved. Smaller breaks the guarantee.
inline constexpr double kTransferRounding = 1e-14;

/// Rounding of planeGap(), per sizes: two supports (6 units each, see farthest()), the products and
/// sums around them, and a direction whose length is 1 to within 4 units. Smaller breaks the
/// guarantee.
inline constexpr double kPlaneGapRounding = 64 * kUnitRoundoff;

// Poses (pose_check.h, convex_view.cc)

/// Largest departure
/// R^T R - 1
///  (Frobenius) of a matrix that is accepted as a rotation; beyond it, a query is kInvalid. The
///  departure itself always widens the interval, to first order. With a larger value, terms of
///  second order would matter.
inline constexpr double kRotationTolerance = 1e-6;

/// Rounding of X_BA computed from two world poses, in units times the sizes; derived in
/// convex_view.cc. Smaller breaks the guarantee.
inline constexpr double kPoseRounding = 24;

// Range of sizes and places

/// Shapes whose largest size [m] is beyond these limits are rejected. No robot has them, and within
/// the limits products of six lengths and quotients of two keep their digits. Sizes of 0 are
/// accepted. Larger ranges break this, and also single precision, which holds squares of lengths up
/// to 1e19.
inline constexpr double kSmallestSize = 1e-9;
inline constexpr double kLargestSize = 1e9;

/// Frames farther apart (sum of the coordinates' magnitudes) [m] make a query kInvalid. Bodies at
/// coordinates up to kLargestSize are closer.
inline constexpr double kFarthest = 1e10;

/// Added to sums of sizes [m]. Two points may then be arbitrarily close, because the sum's
/// rounding, 1e-56, covers what squares of the smallest numbers lose. Smaller than 1e-130 breaks
/// the guarantee.
inline constexpr double kLeastSum = 1e-40;

/// Smallest magnitude of a non-zero coordinate [m] for which the exact predicates are exact:
/// products of three smaller ones leave the range of normal doubles. Hulls and meshes replace
/// smaller coordinates by 0; that change is far below the rounding of kLeastSum.
inline constexpr double kSmallestExact = 1e-70;

/// Squares (of lengths [m^2], or of products of two lengths) below this may be denormal or close to
/// it, and have lost digits: no direction is computed from them.
inline constexpr double kLeastSquare = 1e-290;

/// Lengths [m, or m^2 of a normal] above which squares are normal doubles, with room.
inline constexpr double kLeastToSquare = 1e-140;

/// Squared length of the part of a unit direction across the axis below which a round cap returns
/// its centre. The support value changes by less than 1e-140 of the radius, and the square root
/// stays away from denormal numbers.
inline constexpr double kAcrossAxisSquared = 1e-280;

/// Replaces a divisor of 0, in its unit. The dividend is then 0, too, or the quotient is clamped. A
/// larger value would change quotients that matter.
inline constexpr double kInsteadOfZero = 1e-300;

// Exact predicates (exact_predicates.cc)

/// Error of a computed determinant of three, or of two, differences, as a share of its permanent:
/// Shewchuk's (7 + 56 eps) eps and (3 + 16 eps) eps with eps = kUnitRoundoff, rounded up. Smaller
/// gives wrong signs; larger costs exact evaluations.
inline constexpr double kOrientationRounding = 8e-16;
inline constexpr double kTurnRounding = 4e-16;

// Distances of convex shapes (gjk.cc, closed_form.cc, convex_distance.cc)

/// Rounding of one support plane or witness distance, in units times (extents + |translation|);
/// derived in gjk.cc (about 26 are needed). Smaller breaks the guarantee.
inline constexpr double kSupportRounding = 32;

/// Rounding of a closed form, in units times the sizes; derived in closed_form.cc. Smaller breaks
/// the guarantee.
inline constexpr double kClosedFormRounding = 32;

/// Share of a tetrahedron's volume that each of the four weights must have, and of the cube of its
/// size that the volume must have, so that it holds the origin in spite of rounding. Smaller breaks
/// the guarantee.
inline constexpr double kHeldWell = 1e-6;

// Farthest vertices of hulls (hull_support.cc, hull_scan-inl.h)

/// Rim of a cell of directions, in cells. Rounding may put a direction into the neighbouring cell;
/// quotients are accurate to 1e-15, so the direction lies in that cell's rim. A rim smaller than
/// that misses farthest vertices.
inline constexpr double kCellRim = 1e-9;

/// Directions whose largest coordinate is at least this are looked up in the table of cells. Below
/// it, quotients would leave the range of double, and all vertices are scanned.
inline constexpr double kSmallestDirection = 1e-290;

// Depths of round shapes (curved_depth.cc, cell_bound.cc, curved_cell.h, curved_facet.cc)

/// Rounding of a cell's bound, in units times the sizes; derived in curved_depth.cc. Smaller breaks
/// the guarantee.
inline constexpr double kCellRounding = 128;

/// Error of M x for a corner x, in units times a core's size: entries of X_BA, rounded once, 2;
/// their products and sums 5; M 1. Smaller breaks the guarantee.
inline constexpr double kCornerRounding = 8;

/// The mean of three vectors has no direction if it is no longer than this multiple of their error
/// or, if the error is unknown, than this share of the sizes. The bound is then 0.
inline constexpr double kLostBelow = 16;
inline constexpr double kLostShare = 1e-12;

/// A vector across the axis of two bodies counts as rounding if it is shorter than this many units
/// times the sizes.
inline constexpr double kAcrossRounding = 16;
/// Rounding of directions in a half plane through an axis, in units times the sizes: the axis and
/// `across` err by 6, a corner's halving by half a unit, 48 times. Smaller breaks the guarantee.
inline constexpr double kHalfPlaneRounding = 64;

/// Rounding of roots and sums in Hadeler's criterion, as a share of their terms, of which there are
/// only a few. Smaller breaks the guarantee.
inline constexpr double kRootRounding = 16 * kUnitRoundoff;

/// Rounding of a bound over a facet's cells (curved_facet.cc, where it is derived), in units of
/// kUnitRoundoff times the sizes' square. Smaller breaks the guarantee.
inline constexpr double kFacetRounding = 256;

// Oriented boxes and swept meshes (box_gaps_simd.cc, mesh_sweep.cc)

/// Rounding of a gap between two oriented boxes in single precision, as a share of the boxes'
/// halves and the distance of their centres (60 units of 2^-24 are derived in box_gaps_simd.cc),
/// and of the query's centre. Smaller breaks the guarantee; larger visits more nodes.
inline constexpr float kBoxRounding = 64 * 0x1p-24F;
inline constexpr float kBoxCenterRounding = 4 * 0x1p-24F;

/// Rounding of a box's displacement over a part of a motion, and of the numbers that it is computed
/// from, as a share of them (box_gaps_simd.cc needs less than 32 units of 2^-24). Smaller breaks
/// the guarantee.
inline constexpr double kWayRounding = 64 * 0x1p-24;
/// Factor for radii of boxes: they are rounded to the nearest float, of axes that are orthogonal to
/// within 2^-21. Smaller breaks the guarantee.
inline constexpr double kRadiusRounding = 1 + 0x1p-18;

/// Error of the Frobenius norm, divided by sqrt(2), of a difference of two rotations' matrices, as
/// a share of the norm. Smaller breaks the guarantee.
inline constexpr double kStretchRounding = 1e-12;

/// Limit on the halvings of a motion [count]: times are dyadic and exact, and numbers of parts fit
/// an int. More than 30 overflows them.
inline constexpr int kSweepHalvings = 30;

// Bounds of links: coarse shapes and vector lanes (coarse_shape.cc, ball_cover.cc, lane_frames.h,
// make_lane_sweep.cc, lane_passes_simd.cc, lane_frames_simd.cc)

/// Relative rounding of a point's distance to a placed box, cylinder or ball: about twenty
/// operations of 1.2e-16 each, and a rotation's departure of the same order. Smaller breaks the
/// guarantee.
inline constexpr double kCoarseRounding = 2e-14;

/// Inner balls shrink by this much (relative, and in metres at coordinates of 1 m). This is far
/// above the rounding of a plane through three vertices that are not a sliver, and far too small to
/// cost a proof. Below that rounding it breaks the guarantee.
inline constexpr double kInnerBallSlack = 1e-9;

/// Rounding of one comparison of LaneSweep, in single precision, relative to the sizes and
/// coordinates involved; derived in lane_balls-inl.h (half of it is needed). Smaller breaks the
/// guarantee.
inline constexpr double kLaneSweepRounding = 64 * 0x1p-24;

/// The unit of placeFrames()'s bound (lane_frames.h): 80 times the unit roundoff of single
/// precision. It adds to half an interval's motion at most 4 (sum of half |turn| / kLanes)
/// kLaneRounding of it, and 2 n kLaneRounding times the sum of half |slide| / kLanes. Smaller
/// breaks the guarantee.
inline constexpr double kLaneRounding = 80 * 0x1p-24;

/// Largest turn of one joint over one motion that placeFrames() accepts [rad]: the accuracy of
/// larger turns is not proven.
inline constexpr float kLargestLaneTurn = 7;

/// Factor for a threshold on a plane in a lane: the normal's length is within 61 kLaneRounding
/// of 1. Smaller breaks the guarantee.
inline constexpr float kLaneNormalOutwards = 1 + 0x1p-11F;

/// Factor for radii in a plane's offset: the normal's length is within a few units of 2^-24 of 1.
/// Smaller breaks the guarantee.
inline constexpr double kLanePlaneOutwards = 1 + 1e-6;

/// Factor for LaneGrowth's sums: 4 units of 2^-24 for each term, with at most 40 terms. Smaller
/// breaks the guarantee.
inline constexpr float kLaneGrowthOutwards = 1 + 1e-5F;

/// Replaces a divisor of 0, or the square of a very short vector, in single precision. A larger
/// value would change quotients that matter.
inline constexpr float kLaneInsteadOfZero = 1e-30F;

// Deforming meshes in single precision (refit_simd.cc, deform_descent.cc, probe.cc,
// nearest_triangle_simd.cc, overlap_octree.h, round_body.cc)

/// Rounding of a box's distance in single precision, as a share of the coordinates involved: about
/// thirty operations of 2^-24 each. Smaller breaks the guarantee.
inline constexpr double kSingleRounding = 0x1p-19;

/// Squared lengths [m^2] up to this have no direction in single precision, because the square has
/// lost digits and a normal longer than 1 would prove too much. Smaller breaks the guarantee.
inline constexpr float kLeastWaySquared = 1e-30F;

/// Factor for distances of boxes in single precision: three differences, three squares and a root,
/// each off by 2^-24 of itself. Larger breaks the guarantee.
inline constexpr float kBoxDistanceInwards = 1 - 0x1p-20F;

/// Rounding of a comparison of such a squared distance with a bound (nearest_triangle_simd.cc), as
/// a share of either: six roundings of 2^-24 for the square, one for the root, and those of the
/// bound. Smaller breaks the guarantee.
inline constexpr double kNearestBoxRounding = 0x1p-20;

/// Rounding of both ends of a triangle's distance there, as a share of the coordinates relative to
/// the core's centre: 13 units for its nearest point and the displacement's length, and a few for a
/// segment's own point. Smaller breaks the guarantee.
inline constexpr double kNearestTriangleRounding = 32 * kUnitRoundoff;

/// Half length [m] above which that search accepts segments: in single precision, shorter ones have
/// no direction.
inline constexpr double kNearestLeastHalf = 1e-12;

/// Largest change of a bone's weight over a node's box that a gradient may represent: the bound of
/// rounding in skinned_bounds.cc depends on it.
inline constexpr double kSteepestWeight = 4;

// Motions of deforming meshes (*_motion.cc, key_track.h)

/// Largest magnitude of a coordinate [m], time [s] or other number in the definition of a motion.
/// The motion's bounds multiply and add several of them, and larger numbers come from broken files.
/// Any value below 1e60 keeps the products in range.
inline constexpr double kLargestMotion = 1e15;

/// Largest phase of a wave [rad]. The phase is added to an angle unreduced, so a larger one would
/// only lose digits.
inline constexpr double kLargestPhase = 1e5;

/// Rounding of the fraction of a segment between two keys (key_track.h), in units. Smaller breaks
/// the guarantee.
inline constexpr double kShareRounding = 16;

// Time of contact (rigid_motion.cc, time_of_contact.cc)

/// Rounding of a pose on a motion, as a share of the coordinates involved: about thirty operations.
/// Smaller breaks the guarantee.
inline constexpr double kMotionRounding = 1e-14;

/// Factor for computed bounds of acceleration, for their own rounding: about a hundred operations
/// on positive numbers. Smaller breaks the guarantee.
inline constexpr double kGrowthOutwards = 1 + 1e-12;

/// A screw that turns by less than this [rad] has no axis that could be distinguished from its
/// travel. The turn is dropped, which moves no point by more than this times its distance. A larger
/// value moves the motion away from the given poses.
inline constexpr double kLeastScrewTurn = 1e-12;

// =================================================================================================
// Part 2: numbers that only tune
// =================================================================================================

// Accuracy of requests (default_tolerance.h, dispatch.cc)

/// Tolerance of requests that do not set one, as a share of the larger body's bounding radius ...
inline constexpr double kDefaultShare = 1e-9;
/// ... at most this [m]; internal queries about bodies of any size also use it ...
inline constexpr double kDefaultTolerance = 1e-9;
/// ... and at least this share of the larger extent or of the offset between the frames: rounding
/// leaves 3e-13 of them, most of it in depths of round bodies. Only bodies of a kilometre and more
/// reach this lower limit.
inline constexpr double kDefaultLeastShare = 1e-12;

/// An ellipsoid counts as a ball if its semi-axes differ by at most this share of the tolerance,
/// which leaves the rest for other errors ...
inline constexpr double kBallShare = 0.125;
/// ... and by at most this share of the shortest semi-axis, so that points and normals stay as
/// accurate as elsewhere. The difference widens the interval.
inline constexpr double kNearlyBall = 1e-9;

// Convex searches (gjk.cc, support.cc, vertex_search-inl.h, epa.cc, convex_distance.cc)

/// Hulls with at least this many vertices have neighbour lists, and their support function climbs
/// along edges; for smaller ones a scan is cheaper (measured) [count].
inline constexpr int kClimbFrom = 32;

/// Newton steps for round cores are tried once the relative width of the interval is below the
/// first number (for wider intervals, GJK's own steps are cheaper). After a failure they are tried
/// again once the width has shrunk by the second factor. They end after this many steps that do not
/// halve the width, and after this many failures [count]. The best of a few values on cylinders,
/// cones and ellipsoids.
inline constexpr double kNewtonFrom = 0.3;
inline constexpr double kNewtonAgain = 0.1;
inline constexpr int kIdleNewtonSteps = 2;
inline constexpr int kNewtonFailures = 3;

/// Squared sine of the angle between a direction and an axis below which Newton steps do not move a
/// rim point. The whole rim is then nearly equally far, and one point cannot represent it.
inline constexpr double kFollowRimSquared = 1e-6;

/// Squared share of a point's length below which an edge's nearest point has lost too many digits
/// to cancellation and is computed again. Ten digits are left at this value.
inline constexpr double kCancelled = 1e-6;

/// A ray counts as passing through a facet that it misses by less than this share of it, because
/// between two facets rounding may leave it outside both. This only selects the facet that
/// determines a depth.
inline constexpr double kBesideFacet = 1e-6;

/// Unit normals whose cosine is at least this count as those of one plane: 0.08 degrees. This only
/// selects the plane that is reported with one of several equally good translations.
inline constexpr double kSameNormal = 1 - 1e-6;

// Closed forms (box_overlap.cc, box_pairs.cc, cylinder_pairs.cc, parallel_axes.cc)

/// A closed form's answer is accepted if its ends differ by at most this share of the sizes: the
/// width that rounding leaves, with some room. Smaller values send pairs to the slow query.
inline constexpr double kPairNarrow = 1e-12;

/// Below this sine, an edge of a box counts as perpendicular to a direction. Its end is then closer
/// to the plane than that share of its length, so a witness may be off by as much.
inline constexpr double kPerpendicularEdge = 1e-13;

/// Squared sine below which edges of two boxes count as parallel and do not form a pair, because
/// the plane across them is that of a face or close to it.
inline constexpr double kParallelEdgesSquared = 1e-8;

/// Newton steps along a rim end when the loss of the rim's plane is at most this share of the
/// radius (half of it, to second order). The actual loss is always evaluated.
inline constexpr double kRimNarrow = 1e-14;

/// Squared sine below which a direction counts as perpendicular to a cap. The distance is always
/// evaluated.
inline constexpr double kSameDirectionSquared = 1e-24;

/// Corners of a section whose distance along a direction is within this share of the sizes of the
/// largest one form its side. A witness may be off by as much.
inline constexpr double kSideTogether = 1e-13;

/// Sine between two axes above which the closed form for parallel axes gains nothing.
inline constexpr double kNearlyParallelAxes = 1e-2;

// Depths of round shapes (curved_depth.cc, curved_face.cc)

/// A depth is first searched to within these shares of the sizes: a proof at such a width stays
/// valid if the next search does not finish.
inline constexpr double kRoughDepths[] = {1e-4, 1e-6};

/// Ellipsoids whose axes differ by no more than this share are first tried as balls.
inline constexpr double kSlightlyLonger = 1e-2;

/// Penalty for the distance from the middle of a face, see CurvedFaces. It exceeds the error of
/// rounding and only selects the member.
inline constexpr double kEvenly = 1e-8;

/// If the share of a round part in a member differs by more than this from the assumed share, its
/// curvature is another one, and the member is selected once more. Smaller costs time.
inline constexpr double kRoundTaken = 0.1;

/// Determinants below the first share of their terms count as 0. Where |M e| is below the second
/// share of a rim's radius, the whole disc counts as farthest. Both only select the member.
inline constexpr double kSingularFace = 1e-13;
inline constexpr double kFlatRim = 1e-8;

// Rigid meshes: construction of their hierarchies (hull_excess.cc, convex_pieces.cc)

/// The excess of a mesh's hull is refined until it is within this ratio of a distance that is
/// attained ...
inline constexpr double kExcessRatio = 1.05;
/// ... or below this, a share of the extent for meshes up to a metre and [m] for larger ones, far
/// less than any planner needs ...
inline constexpr double kExcessTolerance = 1e-7;
/// ... or until this many parts (and four for each facet) have been cut [count]: about 0.1 s.
inline constexpr long kExcessPieces = 40'000;

/// Share of the mesh's diagonal by which a convex piece's hull may protrude from the solid, proven.
/// A larger value makes fewer pieces, and more queries that must test triangles.
inline constexpr double kPieceTolerance = 1e-5;

/// A small component counts as convex if no vertex is farther above a triangle than this share of
/// the largest coordinate: the rounding of vertices to single precision in mesh files. Its hull's
/// excess is proven.
inline constexpr double kConvexRounding = 2e-7;

// Queries of meshes (mesh_descent.cc, obb_descent.cc, triangle_pair.cc, deform_descent.cc)

/// A node is bounded to within this share of the smaller radius, plus its excess, because its
/// children replace the bound anyway. Measured.
inline constexpr double kNodeTolerance = 1e-3;

/// Once two meshes are known to overlap, the search ignores pairs of triangles that are deeper by
/// less than this share of the depth, and it visits at most this many node pairs [count]: the upper
/// end of a mesh's depth is loose in any case.
inline constexpr double kDeeperShare = 0.1;
inline constexpr int kDeeperNodes = 256;

/// Two points of two triangles are nearest if the slab across the segment between them is at least
/// this share of its length: the rest is rounding.
inline constexpr double kTrianglesApart = 1 - 1e-12;

// Swept meshes (mesh_sweep.cc)

/// If one box of a pair moves farther than this share of the larger box's radius over a part of a
/// motion, the part is halved. Measured.
inline constexpr double kSweepTimeShare = 0.5;

/// After this many halvings, a gap is evaluated before the next halving [count]. Otherwise a pair
/// that has already separated would be halved until it hardly moves. Measured: evaluating after
/// each halving costs more than it saves.
inline constexpr int kSweepHalvingsBetweenLooks = 2;

// Depths of solids and translations that separate (solid_depth.cc, mesh_separation.cc,
// separation.cc, nearest_in_half_spaces.cc)

/// Tolerance of a solid's depth at a point. For convex and deforming solids it is in [m], or a
/// share of the extent for solids up to a metre; for rigid meshes it is a share of their extent.
/// Depths are looser by as much.
inline constexpr double kSolidTolerance = 1e-9;
inline constexpr double kSolidShare = 1e-3;

/// Limits of the search for a translation that separates two overlapping meshes: the number of
/// queries and the node pairs for each [counts]; how often the length is multiplied (by 1.1 at
/// first, by 4 later) and how often it is halved back [counts]; the first and last angle by which
/// the direction turns [rad]; and the share of the length that a turn must save, per radian. More
/// tightens the lower end of a depth and costs time.
inline constexpr int kSeparationQueries = 64;
inline constexpr int kSeparationNodes = 2000;
inline constexpr int kSeparationSteps = 20;
inline constexpr int kSeparationHalvings = 8;
inline constexpr double kSeparationFirstTurn = 0.5;
inline constexpr double kSeparationLastTurn = 0.03;
inline constexpr double kSeparationGain = 0.1;

/// A direction whose cosine with a half-space's normal is at least this counts as that normal, the
/// only direction in which a half-space is bounded. A smaller value would treat it as bounded in
/// other directions, too; translations are proven by queries.
inline constexpr double kAlongHalfSpace = 1 - 1e-12;

/// Planes at a smaller sine than the first number meet too far away to be of use. A point may be
/// outside planes that it was not made from by the second share of its distance and of theirs.
/// Translations are proven by queries.
inline constexpr double kParallelPlanes = 1e-9;
inline constexpr double kHalfSpaceDoubt = 1e-12;

/// Limit on the choices of planes that are examined [count]; the smallest angle by which directions
/// are turned [rad]; steps of a march out of a concavity [count]. Larger limits find shorter
/// translations and cost queries.
inline constexpr int kSeparationChoices = 300;
inline constexpr double kSeparationLeastTurn = 1e-3;
inline constexpr int kSeparationRaySteps = 16;

// Covers of links and vector lanes (coarse_shape.cc, part_cover.cc, point_cover.cc, lanes/)

/// Vertices of a hull or mesh that are kept as inner balls of radius 0 [count]. Each proves more
/// collisions, but makes pairs that are free more expensive.
inline constexpr int kVertexProbes = 12;

/// A mesh whose hull protrudes from it by no more than this [m] is not covered in parts, because
/// few of its pairs need them and each part takes milliseconds to make.
inline constexpr double kLeastConcavity = 0.01;

/// A hull's cover with points is accurate enough if the omitted vertices are within this distance
/// [m], because other bounds of an edge are wider. A smaller value costs time; a larger one leaves
/// more to exact queries.
inline constexpr double kPointCoverRadius = 2e-4;

/// Distance at which the path towards an obstacle counts as arrived [m].
inline constexpr float kLaneTouching = 1e-4F;

/// LaneSweep searches planes to within this distance of the widest gap [m], because chords and
/// radii leave more open.
inline constexpr double kLanePlaneTolerance = 5e-4;

// Scenes (scene_query.cc)

/// How far beyond the margins decide() searches, and clearance() at first [m]. A larger reach costs
/// queries; a smaller one gives a looser bound on the clearance.
inline constexpr double kDecideReach = 0.1;

// Deforming meshes (deformable.cc, probe.cc)

/// Number of triangles below which the hybrid strategy leaves nodes to the queries, unless the
/// caller sets one [count]. A larger value makes updates cheaper and queries more expensive.
inline constexpr int kHybridSplit = 512;

/// If a body's rotation makes the box around it this many times as large (sum of sides) as its own
/// box, it also gets bounds along its own axes, at twice the cost.
inline constexpr double kTurnedBox = 1.1;

// Time to impact and time of contact (time_to_impact.cc, time_of_contact.cc)

/// Tolerance of a distance that determines the time of the next check: this length [m], or this
/// share of the known gap. A finer tolerance costs more than the later check saves.
inline constexpr double kImpactTolerance = 1e-4;
inline constexpr double kImpactShare = 0.1;

/// A pair that coarse bounds postpone by this many horizons is not queried exactly. Measured:
/// fewest queries.
inline constexpr double kImpactHorizons = 8;

/// A step by the bound on closing is accepted if it is at least this share of the way to the
/// contact that present velocities predict. Otherwise a sweep over the second share of that way is
/// tried, and halved until the step is as long.
inline constexpr double kContactStepShare = 0.5;
inline constexpr double kContactSweepShare = 0.9;

/// Tolerance of a distance on the way, as a share of the distance that is expected after the last
/// query.
inline constexpr double kContactDistanceShare = 0.01;

/// A contact's normal is computed from a distance before it that is known to within this share. The
/// normal is off by at most 12 degrees where corners meet, and by far less elsewhere.
inline constexpr double kContactNormalShare = 0.02;

/// A mesh is welded only if facets lower than this many times the weld have at most this share of
/// its area.
inline constexpr double kWeldHeights = 4, kWeldedShare = 0.01;

}  // namespace leeway::collision
