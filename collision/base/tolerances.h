#pragma once

// Every tolerance of collision/: unit, reason, and what goes wrong when it is changed.
//
// What decides: a number that says how far another may be from the truth, or from where on one
// counts as zero, as equal, as lost or as out of range, stands here. Counts (limits of steps,
// capacities, prices of work) and shares that steer an algorithm, none of which changes what an
// answer may claim, may stand beside it; so may the factors of an error bound that is derived in
// the same few lines.

namespace leeway::collision {

/// Unit roundoff of double precision: a correctly rounded operation errs by at most this fraction.
inline constexpr double kUnitRoundoff = 0x1p-53;

/// Rounding of one support plane or witness distance, as a multiple of kUnitRoundoff * (extents +
/// |translation|); derived in gjk.cc (about 26 are needed). Smaller breaks the guarantee; larger
/// only widens every interval.
inline constexpr double kSupportRounding = 32;

/// Rounding of a closed form, in the same unit; derived in closed_form.cc.
inline constexpr double kClosedFormRounding = 32;

/// Rounding of X_BA made from two world poses, in the same unit; derived in convex.cc.
inline constexpr double kPoseRounding = 24;

/// Tolerance of requests that name none, as a share of the larger body's bounding radius ...
inline constexpr double kDefaultShare = 1e-9;
/// ... and the most that it is [m]. What we ask ourselves, of bodies of any size, is asked with it,
/// too.
inline constexpr double kDefaultTolerance = 1e-9;
/// The least that it is, as a share of the larger extent or of the offset between the frames:
/// rounding leaves 3e-13 of them, most of it in depths of round bodies. Only bodies of a kilometre
/// and more have it.
inline constexpr double kDefaultLeastShare = 1e-12;

/// Share of the tolerance that the semi-axes of an ellipsoid may differ by for it to be taken for a
/// ball: the rest is left for all else. It only widens intervals.
inline constexpr double kBallShare = 0.125;
/// ... and of the least of them, so that points and normals are no worse than elsewhere.
inline constexpr double kNearlyBall = 1e-9;

/// Largest departure ||R^T R - 1|| (Frobenius) of a matrix that is still taken for a rotation;
/// above, a query is kInvalid. The departure itself always is part of the interval's width.
inline constexpr double kRotationTolerance = 1e-6;

/// Sums of sizes and distances outside [kSmallestScale, kLargestScale] [m] are answered from
/// bounding spheres, because products of four lengths would leave the range of double.
inline constexpr double kLargestScale = 1e60;
inline constexpr double kSmallestScale = 1e-40;
/// GJK's steps in vector lanes square directions that are products of three lengths: larger sizes
/// [m] are left to the general way.
inline constexpr double kLargestForLanes = 1e50;

/// Squared length of the part of a unit direction across the axis below which a round cap is asked
/// at its centre: it moves the support value by less than 1e-140 of the radius, and keeps the
/// square root away from denormal numbers. No unit.
inline constexpr double kAcrossAxisSquared = 1e-280;

/// From this many vertices on a hull has neighbour lists and its support climbs along its edges;
/// below, scanning all is cheaper (measured).
inline constexpr int kClimbFrom = 32;

// Lengths and directions (shape.cc, convex.cc, support.cc, penetration.cc)

/// A norm, or another root of a sum of a few squares, errs by less than 4 units of roundoff; times
/// this it is rounded outwards.
inline constexpr double kOutwards = 1 + 0x1p-50;
/// The other way about, so that what is brought to a length is no longer.
inline constexpr double kInwards = 1 - 0x1p-50;

/// What bounds to first order in a rotation's departure are multiplied with: those of second order
/// are less than kRotationTolerance of them. No unit.
inline constexpr double kFirstOrderOutwards = 1 + 0x1p-10;

/// Squares (of lengths [m^2], or of products of two lengths) below this are among the numbers that
/// lose digits, or near them: no direction is made from them.
inline constexpr double kLeastSquare = 1e-290;

/// Lengths [m, or m^2 of a normal] from and to which squares are normal doubles, with room.
inline constexpr double kLeastToSquare = 1e-140;
inline constexpr double kMostToSquare = 1e140;

/// Stands for a divisor that is 0, in its unit: what is divided is 0 then, too, or the quotient is
/// cut to a range. Larger would change quotients that count.
inline constexpr double kInsteadOfZero = 1e-300;

/// How far from 1 the square of a normal may be before it counts as lost at the ends of double's
/// range. No unit.
inline constexpr double kUnitNormal = 1e-6;

/// A ray passes through a facet that it misses by less than this share of it: between two facets
/// rounding may leave it beside both. No unit; it only says which member carries a depth.
inline constexpr double kBesideFacet = 1e-6;

/// Cosine from which on two unit normals count as those of one plane: 0.08 degrees. It only says
/// which of equally good translations is told with which plane.
inline constexpr double kSameNormal = 1 - 1e-6;

// Closed forms (box_overlap.cc, box_pairs.cc, cylinder_pairs.cc, parallel_axes.cc)

/// A closed form's answer is taken when its ends are apart by at most this share of the sizes: what
/// rounding leaves, with room. Smaller sends pairs to the slow query.
inline constexpr double kPairNarrow = 1e-12;

/// Below this sine an edge of a box counts as perpendicular to a direction: its end is then nearer
/// to the plane than that share of its length, which a witness may be off by.
inline constexpr double kPerpendicularEdge = 1e-13;

/// Edges of two boxes that are parallel to within this sine (squared) are no pair: the plane across
/// them is a face's, or next to it.
inline constexpr double kParallelEdgesSquared = 1e-8;

/// Cosines from and to which a face or an edge is tried in a cached direction. Any value is right.
inline constexpr double kCachedAligned = 0.99;
inline constexpr double kCachedAcross = 0.1;

/// Newton's steps along a rim end when its plane lacks at most this share of the radius (half of
/// it, to second order). What it lacks is evaluated anyway.
inline constexpr double kRimNarrow = 1e-14;

/// Sine (squared) between two directions that are taken for one where a cap is met squarely; the
/// distance is evaluated anyway.
inline constexpr double kSameDirectionSquared = 1e-24;

/// Corners of a section this near to the farthest along a direction, as a share of the sizes, are
/// its side: a witness may be off by as much.
inline constexpr double kSideTogether = 1e-13;

/// Beyond this sine between two axes the closed form of parallel ones has nothing to give that is
/// worth the time.
inline constexpr double kNearlyParallelAxes = 1e-2;

// Depths of curved pairs (curved_depth.cc, cell_bound.cc, curved_cell.h, curved_face.cc)

/// Rounding of a cell's bound, in units of kUnitRoundoff times the sizes involved; derived in
/// curved_depth.cc. Smaller breaks the guarantee.
inline constexpr double kCellRounding = 128;

/// What M x of a corner errs by, in units of kUnitRoundoff times a core's size: entries of X_BA
/// that are rounded once 2, their products and sums 5, M 1. Smaller breaks the guarantee.
inline constexpr double kCornerRounding = 8;

/// Three vectors whose middle is no longer than so many times what they err by have no direction;
/// or than this share of the sizes, where what they err by is not known. There 0 is the bound.
inline constexpr double kLostBelow = 16;
inline constexpr double kLostShare = 1e-12;

/// Rounding of roots and sums in Hadeler's criterion, as a share of their terms, of which there are
/// a few. Smaller breaks the guarantee.
inline constexpr double kRootRounding = 16 * kUnitRoundoff;

/// What a depth is first known to, as a share of the sizes: what is proven roughly stays proven.
/// Costs time, never truth.
inline constexpr double kRoughDepth = 1e-6;

/// Ellipsoids whose axes differ by no more than this share are looked at as balls first. Any value
/// is right.
inline constexpr double kSlightlyLonger = 1e-2;

/// See CurvedFaces: what being beside the middle of a face costs. Less is lost in rounding; it only
/// says which member is taken.
inline constexpr double kEvenly = 1e-8;

/// Round parts whose share in a member is other than was supposed by more than this bend otherwise,
/// too: the member is chosen once more. It only says which one is taken; smaller costs time.
inline constexpr double kRoundTaken = 0.1;

/// Determinants below this share of their terms are taken for 0, and |M e| below the other share of
/// a rim's radius: all of its disc is farthest. They only say which member is taken.
inline constexpr double kSingularFace = 1e-13;
inline constexpr double kFlatRim = 1e-8;

/// Rounding of a bound over a facet's cells (curved_facet.cc, where it is derived), in units of
/// kUnitRoundoff times the sizes' square. Smaller breaks the guarantee.
inline constexpr double kFacetRounding = 256;

// Hulls' vertices (hull_support.cc, simd/scan-inl.h, simd/vertex_gjk.cc)

/// Rim of a cell of directions, in cells: a direction that rounding puts into the cell beside it is
/// in its rim, because places are good to 1e-15. Smaller than that misses farthest vertices.
inline constexpr double kCellRim = 1e-9;

/// A direction's largest coordinate outside of these is not looked up in cells, because quotients
/// would leave the range of double: all vertices are scanned then. No unit.
inline constexpr double kSmallestDirection = 1e-290;
inline constexpr double kLargestDirection = 1e290;

/// Squared share of a point's length below which an edge's nearest point has lost digits that
/// count: ten are left.
inline constexpr double kCancelled = 1e-6;

/// Share of a tetrahedron's volume that each of the four weights must have, and of the cube of its
/// size that the volume must have, for there to be no doubt that it holds the origin.
inline constexpr double kHeldWell = 1e-6;

// Signs (exact.cc)

/// What a computed determinant of three or of two differences errs by, as a share of its permanent:
/// Shewchuk's (7 + 56 eps) eps and (3 + 16 eps) eps with eps = kUnitRoundoff, rounded up. Smaller
/// gives wrong signs, larger asks for exact ones more often.
inline constexpr double kOrientationRounding = 8e-16;
inline constexpr double kTurnRounding = 4e-16;

// Scene (coarse_shape.cc, scene.cc, point_cover.cc, lane_sweep.cc)

/// Relative rounding of a point's distance to a placed box, cylinder or ball: some twenty
/// operations of 1.2e-16 each, with room for a rotation that departs from orthogonality by the
/// same. Smaller risks a bound that does not hold.
inline constexpr double kCoarseRounding = 2e-14;

/// Inner balls are made smaller by this much (relative, and in metres at coordinates of 1 m), far
/// above the rounding of a plane through three vertices that are not a sliver, far below anything
/// that costs a proof.
inline constexpr double kInnerBallSlack = 1e-9;

/// Vertices of a hull or mesh that are kept as inner balls of no radius [count]: each proves more
/// collisions and makes every pair that is free dearer.
inline constexpr int kVertexProbes = 12;

/// Composition of two poses and the distance of two centres, relative to the coordinates at play.
inline constexpr double kTransferRounding = 1e-14;

/// Rounding of one comparison of LaneSweep, in single precision, relative to the sizes and
/// coordinates at play; derived in simd/lane_sweep.cc (half of it is needed). Smaller breaks the
/// guarantee.
inline constexpr double kLaneSweepRounding = 64 * 0x1p-24;

/// The unit of placeFrames()'s bound (lane_frames.h): 80 times the unit roundoff of single
/// precision. What it does to half an interval's motion is at most 4 (sum of half |turn| / kLanes)
/// as much, and 2 n kLaneRounding times the sum of half |slide| / kLanes. Smaller breaks the
/// guarantee.
inline constexpr double kLaneRounding = 80 * 0x1p-24;

/// Turns of one joint over one motion that placeFrames() takes [rad]. More would cost accuracy.
inline constexpr float kLargestLaneTurn = 7;

/// A bar for a plane in a lane is multiplied with this: the normal's length is within 61
/// kLaneRounding of 1. Smaller breaks the guarantee.
inline constexpr float kLaneNormalOutwards = 1 + 0x1p-11F;

/// Radii in a plane's offset likewise, whose normal is of a length within some units of 2^-24 of 1.
inline constexpr double kLanePlaneOutwards = 1 + 1e-6;

/// Stands for a divisor that is 0, or for the square of what is very short, in single precision.
/// Larger would change quotients that count.
inline constexpr float kLaneInsteadOfZero = 1e-30F;

/// Where the way towards an obstacle counts as having come to it [m]. Any value is right.
inline constexpr float kLaneTouching = 1e-4F;

/// A mesh whose hull stands out from it by no more than this [m] is not covered in parts: few of
/// its pairs need them, and each takes milliseconds to make. Costs time, never truth.
inline constexpr double kLeastConcavity = 0.01;

/// What LaneGrowth's sums are multiplied with: 4 units of 2^-24 a term, of which there are 40 at
/// most. Smaller breaks the guarantee.
inline constexpr float kLaneGrowthOutwards = 1 + 1e-5F;

/// How near to the widest gap LaneSweep searches planes [m]: chords and radii leave more open.
inline constexpr double kLanePlaneTolerance = 5e-4;

/// A hull's cover with points is good enough when the vertices that are left out are this near [m]:
/// other bounds of an edge are wider. Smaller costs time, larger leaves more to exact queries.
inline constexpr double kPointCoverRadius = 2e-4;

// Hulls and meshes (hull_builder.cc, convex_hull.cc, mesh_tree.cc, hull_excess.cc)

/// Largest size or coordinate that shapes accept [m]: the exact predicates of hulls and meshes
/// multiply three, the engine four.
inline constexpr double kLargestCoordinate = 1e60;

/// Coordinates that are not zero must not be smaller than this for the exact predicates to be
/// exact: smaller, a product of three would leave the range of normal doubles. Hulls take smaller
/// ones for 0 and count that as excess [m].
inline constexpr double kSmallestExact = 1e-70;

/// Rounding of a distance of a point from a triangle or of a radius, as a fraction of the
/// coordinates at play, used while hulls and meshes are built. About 20 units in the last place are
/// needed.
inline constexpr double kRelativeRounding = 1e-14;

/// The excess of a mesh's hull is refined until it is within this ratio of a distance that was met,
/// ...
inline constexpr double kExcessRatio = 1.05;
/// ... or below this [m], of meshes within a metre this share of their extent, far less than what
/// any planner asks for, ...
inline constexpr double kExcessTolerance = 1e-7;
/// ... or this many pieces (and four a facet) have been cut: about 0.1 s.
inline constexpr long kExcessPieces = 40'000;

// Convex pieces of meshes (convex_pieces.cc)

/// A piece's hull may leave the solid by this share of the mesh's diagonal, proven. Larger makes
/// fewer pieces, and more queries that have to look at triangles; answers stay right.
inline constexpr double kPieceTolerance = 1e-5;
/// Pieces are used where there are at least this many triangles to a piece or loose triangle.
/// Measured with bench_meshes: at 8, queries cost up to 2.7 times as much as with triangles alone;
/// at 20, a quarter to a half for distances and about the same for thresholds; from 100 on, a
/// twentieth and a third.
inline constexpr double kPieceTriangles = 16;
/// Meshes of fewer triangles are left alone: their hierarchy is one or two nodes deep.
inline constexpr int kLeastDecomposed = 24;
/// A piece's hull is flat, and is given a point inside the solid, where the largest ball in it is
/// smaller than this share of its reach.
inline constexpr double kPieceThin = 0.02;
/// A patch stops growing when this many batches did not fit [count]. More finds better pieces.
inline constexpr int kPieceFailures = 32;
/// A decomposition is given up after this much work a triangle, and this much in all [units of
/// about 0.2 us]; and as soon as there are that many pieces and loose triangles more than pay for
/// the triangles done so far (seeds that promise most come first).
inline constexpr double kPieceWork = 100;
inline constexpr double kPieceMostWork = 5e6;
inline constexpr double kPieceHeadStart = 64;

// Deforming meshes (deformable.cc, deform_descent.cc)

/// Largest coordinate of a deforming mesh's vertices [m]: areas of their boxes stay within single
/// precision.
inline constexpr double kLargestDeformed = 1e15;

/// Triangles below which the hybrid strategy leaves nodes to the queries, where the caller does not
/// say [count]. Larger: cheaper updates, dearer queries; no value changes an answer.
inline constexpr int kHybridSplit = 512;

/// Rounding of a box's distance in single precision, as a fraction of the coordinates at play: some
/// thirty operations of 2^-24 each. Smaller breaks the guarantee.
inline constexpr double kSingleRounding = 0x1p-19;

/// A box around a body that its turn makes this many times as large (sum of sides) as its own box
/// is worth bounds along its own axes, which cost as much again. Any value is right.
inline constexpr double kTurnedBox = 1.1;

/// Ways between boxes whose square [m^2] is not above this have no direction in single precision.
inline constexpr float kLeastWaySquared = 1e-30F;

/// Distances of boxes in single precision are multiplied with this: three differences, three
/// squares and a root, each off by 2^-24 of itself. Larger breaks the guarantee.
inline constexpr float kBoxDistanceInwards = 1 - 0x1p-20F;

/// The same held against a bar (deform_nearest.cc), as a share of either: six roundings of 2^-24
/// for the square, one for the root, and those of the bar.
inline constexpr double kNearestBoxRounding = 0x1p-20;

/// Rounding of both ends of a triangle's distance there, as a share of the coordinates seen from
/// the core's middle: 13 units for its nearest point and the way's length, and some for a segment's
/// own point. Smaller breaks the guarantee.
inline constexpr double kNearestTriangleRounding = 32 * kUnitRoundoff;

/// Half lengths of segments from which on, and distances of a core from the mesh's origin up to
/// which that search is taken [m]: in single precision shorter ones have no direction and the
/// squares of farther ones no room.
inline constexpr double kNearestLeastHalf = 1e-12;
inline constexpr double kNearestFarthest = 1e18;

/// Largest change of a bone's weight over a node's box that a gradient may stand for: bounds of
/// rounding count on it. No unit.
inline constexpr double kSteepestWeight = 4;

// Queries of meshes (mesh_descent.cc, containment.cc)

/// A node is bounded to within this share of the smaller radius, and of its excess: closer work on
/// a bound that its children will better is lost. Any value is right; this one was fast.
inline constexpr double kNodeTolerance = 1e-3;

/// Rounding of a gap between two oriented boxes in single precision, as a fraction of the boxes'
/// halves and the way between their centres (48 units of 2^-24 are derived in simd/box_gaps.cc),
/// and of the query's centre. Smaller breaks the guarantee, larger visits more nodes.
inline constexpr float kBoxRounding = 64 * 0x1p-24F;
inline constexpr float kBoxCenterRounding = 4 * 0x1p-24F;

/// Sizes and distances [m] between which single precision may filter; beyond, squares would leave
/// its range.
inline constexpr double kSmallestBoxScale = 1e-12;
inline constexpr double kLargestBoxScale = 1e12;

/// Rounding of the way that a box goes over a part of a motion, and of the numbers that it is made
/// from, as a fraction of them (simd/box_gaps.cc needs less than 32 units of 2^-24); and what radii
/// of boxes lack, which are rounded to the nearest float, of axes that are orthogonal within 2^-21.
/// Smaller breaks the guarantee.
inline constexpr double kWayRounding = 64 * 0x1p-24;
inline constexpr double kRadiusRounding = 1 + 0x1p-18;

/// A pair of boxes of which one moves farther than this share of the larger one's radius over a
/// part of a motion is looked at in halves of it. Measured; costs time, never truth.
inline constexpr double kSweepTimeShare = 0.5;

/// After so many halvings its gap is looked at anew before it is halved again, lest what has long
/// come apart be halved until it stands still. Measured: looking after one costs more than it
/// saves.
inline constexpr int kSweepHalvingsBetweenLooks = 2;

/// A motion is not halved more often than this: times are exact, and numbers of parts are ints.
inline constexpr int kSweepHalvings = 30;

/// Once two meshes are known to overlap, pairs of triangles that are deeper by less than this share
/// of the depth are not looked for, nor more than that many node pairs visited: the upper end of a
/// mesh's depth is loose anyway.
inline constexpr double kDeeperShare = 0.1;
inline constexpr int kDeeperNodes = 256;

/// A translation that separates two overlapping meshes is looked for with this many queries at
/// most, each with this many node pairs: its length is multiplied this often (by 1.1 at first, by 4
/// later) and halved back that often, its direction turned by angles from the first to the last
/// [rad], each turn having to save this share of length a radian. More makes the lower end of a
/// depth better and the query dearer; no value makes it wrong.
inline constexpr int kSeparationQueries = 64;
inline constexpr int kSeparationNodes = 2000;
inline constexpr int kSeparationSteps = 20;
inline constexpr int kSeparationHalvings = 8;
inline constexpr double kSeparationFirstTurn = 0.5;
inline constexpr double kSeparationLastTurn = 0.03;
inline constexpr double kSeparationGain = 0.1;

/// The search for a point that is deep in two solids looks at a few starts and, where a solid
/// deforms, at a grid of this many points along each axis of what their boxes share, then takes so
/// many steps from the best. More makes the upper end of a depth better and the query dearer; a
/// fifth point along each axis gains next to nothing, without a grid deforming solids would have
/// looser depths than rigid ones.
inline constexpr int kDeepestPointGrid = 4;
inline constexpr int kDeepestPointSteps = 20;

/// Nothing is nearer than two points of two triangles when what lies between the planes across
/// their way is all of it but this share. What it lacks is no more than rounding.
inline constexpr double kTrianglesApart = 1 - 1e-12;

/// What a solid's depth at a point is asked to within: a convex or deforming one's [m], of those
/// within a metre as a share of their extent, and a rigid mesh's as a share of its extent. It only
/// says how deep a contact is, and where it is left.
inline constexpr double kSolidTolerance = 1e-9;
inline constexpr double kSolidShare = 1e-3;

/// Difference of two rotations' matrices: what its Frobenius norm over the root of 2 is off by.
/// Smaller breaks the guarantee.
inline constexpr double kStretchRounding = 1e-12;

// Pushing out (separation.cc, nearest_in_halfspaces.cc)

/// Cosine from which on a direction is a half-space's normal, along which alone it ends. Smaller
/// would give it an end that it has not; translations are proven by queries.
inline constexpr double kAlongHalfSpace = 1 - 1e-12;

/// Planes at a smaller sine than this meet too far away to be of use; a point may be outside of
/// planes that it was not made from by the other share of its distance and of theirs. No unit.
/// Translations are proven by queries.
inline constexpr double kParallelPlanes = 1e-9;
inline constexpr double kHalfSpaceDoubt = 1e-12;

/// Choices of planes that are looked at; directions are turned down to this angle [rad]; a march
/// out of a hollow has this many steps. More finds shorter translations and costs queries; nothing
/// that is returned rests on them.
inline constexpr int kSeparationChoices = 300;
inline constexpr double kSeparationLeastTurn = 1e-3;
inline constexpr int kSeparationRaySteps = 16;

/// A segment that decides inside or outside leaves the box of the component by this share of its
/// size, and is tilted by multiples of it: far enough from edges and vertices of axis-aligned parts
/// to be regular at once.
inline constexpr double kSegmentTilt = 1.0 / 1024;

/// Newton steps for round cores are tried from this relative width of the interval on (farther out
/// GJK's own steps are cheaper), and after a failure once it has shrunk by the second factor; that
/// many steps may pass without halving it. They change the number of steps, never an answer's
/// truth. No unit; the best of a few values on cylinders, cones and ellipsoids.
inline constexpr double kNewtonFrom = 0.3;
inline constexpr double kNewtonAgain = 0.1;
inline constexpr int kIdleNewtonSteps = 2;
inline constexpr int kNewtonFailures = 3;

/// Squared sine of the angle between a direction and an axis below which a rim point is not moved
/// along by Newton steps: there all of the rim is nearly as far, and one point cannot stand for it.
/// No unit.
inline constexpr double kFollowRimSquared = 1e-6;

// Motions of deforming meshes (*_motion.cc)

/// Largest magnitude of a coordinate [m], time [s] or other number that a motion is made from: its
/// bounds multiply and add some of them, and what is larger is a broken file. Any value below 1e60
/// would be right.
inline constexpr double kLargestMotion = 1e15;

/// Rounding of the share of a segment between two keys (key_track.h), in units of kUnitRoundoff.
/// Smaller breaks the guarantee.
inline constexpr double kShareRounding = 16;

/// Largest phase of a wave [rad]: it is added to an angle as it is, and more would only lose
/// digits.
inline constexpr double kLargestPhase = 1e5;

// Time to impact (time_to_impact.cc)

/// A distance that says when to look again is asked to within this [m], or this share of what is
/// known to lie between: a finer one costs more than the later look that it buys.
inline constexpr double kImpactTolerance = 1e-4;
inline constexpr double kImpactShare = 0.1;

/// A pair that coarse bounds put off for this many horizons is not asked exactly. Any value is
/// right; this one asked least.
inline constexpr double kImpactHorizons = 8;

// Time of contact (rigid_motion.cc, time_of_contact.cc)

/// Rounding of a pose on a motion, as a fraction of the coordinates at play: some thirty
/// operations.
inline constexpr double kMotionRounding = 1e-14;

/// What computed bounds of acceleration are multiplied with, for their own rounding: some hundred
/// operations of positive numbers. No unit.
inline constexpr double kGrowthOutwards = 1 + 1e-12;

/// A screw that turns less has no axis that could be told from its travel [rad]; the turn is
/// dropped, which moves nothing by more than this times its distance.
inline constexpr double kLeastScrewTurn = 1e-12;

/// A step by the bound on closing is taken when it is this share of the way to the contact that
/// present velocities predict; else a sweep over the other share of that way is tried, and halved
/// until the step is as long. They change the number of queries, never an answer's truth.
inline constexpr double kContactStepShare = 0.5;
inline constexpr double kContactSweepShare = 0.9;

/// A distance on the way is asked to within this share of what the last one leaves to expect.
inline constexpr double kContactDistanceShare = 0.01;

}  // namespace leeway::collision
