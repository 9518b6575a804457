#pragma once

// Every tolerance of planner/: unit, reason, and what goes wrong when it is changed. What stands
// here and what beside its algorithm is decided as in collision/base/tolerances.h.

#include <cstddef>
#include <cstdint>

namespace leeway::planner {

// ============================== 1. What guarantees rest on ==============================
// A proof, an accepted input or a written file would be wrong with another value.

// Angles and rotations

/// Below this angle [rad] sin x = x and atan x = x to the last bit (x^2 / 3 is under half an ulp).
/// Larger costs accuracy; below 1e-150 squares underflow to zero and lose the direction.
constexpr double kTinyAngle = 1e-8;

/// Below this [rad] a turn has no axis, because the square of its length loses digits; any axis
/// will do then.
constexpr double kLeastTurn = 1e-150;

/// A quaternion whose length is this near to 1 is unit to rounding: dividing by it again would only
/// move it.
constexpr double kUnitToRounding = 1e-15;

/// Squared part of a unit normal across the z axis up to which the verifier takes it for that axis
/// or its opposite: below, squares lose digits.
constexpr double kVerifyAcross = 1e-300;

// Range and rounding of poses

/// Joint angles farther from zero than this [rad] are not certified, and files that name one are
/// refused: kInterpolationRounding would not hold.
constexpr double kLargestAngle = 1e3;

/// A circle that turns by more than half a turn on a straight line goes along edges on which it
/// turns by no more than this [rad]: below half a turn, so that rounding sends none the other way.
constexpr double kLongestLineTurn = 3;

/// How far rounding of a + t dq (three operations) moves a joint within kLargestAngle [rad], and a
/// free body's orientation.
constexpr double kInterpolationRounding = 1e-12;

/// Bodies behind unlimited joints are certified up to this distance from the world's origin [m];
/// farther out rounding of kinematics (1e-16 of it and more) would eat margins of micrometres.
constexpr double kLargestReach = 1e4;

/// The product of a vertex's speed bound and a time is rounded up by this share: two products and a
/// sum err by less than 1e-15.
constexpr double kGrowthRounding = 1e-14;

/// How far the verifier's poses may be from the exact ones, for each joint, relative to the reach
/// and as metres. At its angles of up to 1e4 rad interpolation rounds by 2e-12 rad at the most;
/// sines and products by 1e-14.
constexpr double kVerifyRounding = 4e-12;

// Costs of being near

/// A sum of at most kEdgeSlots means of at most 1 rounds by less than this.
constexpr double kCostRounding = 1e-12;

/// How far rounding moves the nearest points of a distance, in the frames of their bodies [m].
constexpr double kWitness = 1e-9;

/// A sum of products with lengths and weights rounds by less than this share of itself.
constexpr double kSumRounding = 1e-13;

// Blended corners

/// A blend is proven as chords from which any point of the robot, seen from any other, departs by
/// at most this [m]; it is charged to the margins.
constexpr double kBlendDeviation = 5e-5;

/// On either side of a blended corner a circle turns by less than this [rad]: with the rounding of
/// a chord's ends less than half a turn in all, so that the chord goes the same way.
constexpr double kBlendReach = 1.5;

/// Edges whose unit directions differ by no more than this in each number are run through without a
/// stop. Cutting an edge rounds by less; velocity jumps by that share at such a corner.
constexpr double kInLine = 1e-12;

/// Reading a problem, and compiling it, may take as long as planning may, and this at least [s]: a
/// limit of milliseconds is meant for planning.
constexpr double kLeastReading = 10;

// What input is accepted, and what counts as equal in it

/// How far from 1 the length of a planned body's quaternion may be to count as a rotation. Rounding
/// leaves 1e-15, and loaders normalise anything within kMendableQuaternion: what is farther off
/// comes from a program that did not normalise.
constexpr double kUnitQuaternion = 1e-6;

/// A quaternion in a file this near to unit length was meant to be one (three or four written
/// digits). It is normalised, with a warning above kSilentQuaternion; farther off it is an error.
constexpr double kMendableQuaternion = 1e-3;
constexpr double kSilentQuaternion = 1e-8;

/// A start or goal of MoveIt's this far outside a limit [rad or m] is the limit itself, written
/// with fewer digits (3.14159 for pi): it is moved onto it, with a warning. Larger would move a
/// robot unasked.
constexpr double kLimitSlack = 1e-5;

/// A column of a path file that is not planned agrees with the problem within this [rad or m]: logs
/// have six digits.
constexpr double kPassiveJointSlack = 1e-5;

/// What `any` means of a pose's position [m]: no robot reaches as far.
constexpr double kAnyPosition = 1e6;

/// Goals that MoveIt's constraints allow are taken smaller by this [m, rad]: solutions are within
/// 1e-9 of them, and angles may be that far from their turns about the axes. Smaller ones are
/// refused.
constexpr double kConstraintSlack = 2e-8;

/// How near a verified path's ends must be to start and goal, and how far outside its limits a
/// waypoint may be [rad or m]: rounding of files and of whole turns, nothing that a robot could
/// feel.
constexpr double kVerifyWaypoint = 1e-9;

/// When the verifier takes links that meet at a joint for touching [m]. It is more than robots'
/// kTouch: rounding of two kinematics must not make it check what the planner leaves out.
constexpr double kVerifyTouch = 2e-6;
/// And the steps of the joint after which it looks: those of kTouchLooks.
constexpr int kVerifyTouchLooks = 128;

/// OMPL writes parameters with six digits: one that reads back within this share was kept.
constexpr double kParameterDigits = 1e-5;

/// Limits on velocity, acceleration and jerk that a problem may name, and the least share of them:
/// far beyond all machines, and no product or quotient of them overflows. A URDF's velocity above
/// the largest means that there is no limit.
constexpr double kLeastLimit = 1e-9;
constexpr double kMostLimit = 1e9;

/// The latest time [s] that the stamps of trajectory_msgs/JointTrajectory can hold.
constexpr double kLatestStamp = 2147483647;

// ================================= 2. What only tunes ===================================
// Time, memory, or how good an answer is; never whether it is true.

// Edges: what ends a proof

/// An interval of an edge in which no point of a pair moves farther than this [m] is not split
/// again: what is still open there comes within about as much of its margin, and is undecided.
/// Smaller only delays that answer.
constexpr double kSmallestMotion = 1e-6;

/// Intervals are not halved more often than this: 2^-30 of the longest edge of a metre is a
/// nanometre.
constexpr int kDeepestLevel = 30;

/// What an edge may cost before it is left undecided [units of collision::Work, about a nanosecond
/// each], so that an edge that grazes something does not cost as much as fifty others. Of the edges
/// that planning and simplifying ask for in 14 MotionBenchMaker problems with four seeds each it
/// leaves 17 of ur5's 20,100 open and none of panda's 32,000. Four fifths of it leave 48 of ur5's.
constexpr std::int64_t kEdgeWork = 100'000;

/// kEdgeWork where a body flies freely among triangles: its surfaces are followed through all of
/// the edge at once, and kEdgeWork would leave one in thirty of such edges undecided.
constexpr std::int64_t kFlightWork = 500'000;

/// kEdgeWork where no other edge can take this one's place: certificates of paths and of steps.
constexpr std::int64_t kPersistentWork = 10'000'000;

/// Undecided edges of a search after which its edges may cost twice as much: before its first
/// doubling it has lost 6 ms to them, by kPersistentWork 0.8 s.
constexpr std::uint64_t kEscalation = 64;

/// The last valid place of an edge is found to 2^-12 of it: planners go back there and need no
/// more.
constexpr int kLastValidLevel = 12;

/// Tries at a last valid state nearer to the start, each half as far. The edge up to the first is
/// certified, but its end is a rounded point beside it, which near contact may not be.
constexpr int kLastValidTries = 4;

// Edges: lanes

/// Finer passes of lanes over what the pass over a whole edge left open [count], and the part of
/// the edge below which none is made: what is open there nearly touches, and exact sweeps decide
/// it. Measured.
constexpr int kLanePasses = 24;
constexpr double kFinestPart = 0x1p-10;

/// Several open lanes are swept exactly as one interval while the sweep's growth stays below this
/// [m]: things that are always near each other move little against each other, and one sweep of
/// meshes costs as much over a long interval as over a short one. Measured.
constexpr double kMergedGrowth = 2e-3;

/// Intervals that remain after finer passes are merged, pair by pair, up to this growth [m]: what
/// is left is near, and moves little in one of them. Measured.
constexpr double kMergedAgainGrowth = 2e-4;

// Edges: exact sweeps

/// A sweep is tried only where the growth of its hull is below this [m]; wider ones seldom prove
/// anything that their halves would not. Measured.
constexpr double kSweepGrowth = 0.02;

/// Each pair has a limit of its own below that, since pairs of one robot stay about as near to each
/// other from edge to edge. A sweep that fails lowers it to the first share of its growth, one that
/// succeeds raises it by the second. It is never lowered below the third [m], or an edge that once
/// grazed something would spoil the next.
constexpr double kGrowthLimitFall = 0.7;
constexpr double kGrowthLimitRise = 1.1;
constexpr double kLeastGrowthLimit = 2e-4;

/// A sweep of meshes with more growth than this [m] looks at no more than so many pairs of nodes:
/// halves of the interval, which the hulls alone often decide, are cheaper than a deep descent.
/// Measured.
constexpr double kDeepSweepGrowth = 1e-3;
constexpr int kShallowNodes = 12;

/// Pairs of nodes that a look for a contact in the middle of an interval visits [count]: of those
/// that find one nearly all have done so by then. Measured.
constexpr int kContactNodes = 200;

// Edges: the least clearance

/// Distance queries for the clearance of one edge before its interval is left wider than asked, and
/// what they may cost [units of collision::Work]: depths of meshes take up to milliseconds each.
constexpr int kClearanceQueries = 100'000;
constexpr std::int64_t kClearanceWork = 100'000'000;

/// Passes of lanes after the first, as long as each finds something nearer, and the pairs that are
/// looked at after each [count]. Measured.
constexpr int kClearancePasses = 3;
constexpr int kClearanceLooks = 2;

// Edges: what it costs to be near (edge_cost.cc, path_cost.cc)

/// How narrow the interval of an edge is at first, beside those of a path's others, as a share.
constexpr double kFirstCostTolerance = 0.3;

/// How near the least clearance is known, as a share of the distance of nearness, where the worst
/// place of a path counts; and where its gradient is asked for.
constexpr double kWorstCostShare = 5e-3;
constexpr double kGradientShare = 1e-3;

/// How near distances are known, as a share of the distance at which nearness ends, or begins to
/// fall; what the cost of an edge may cost that names no limit [units of Work].
constexpr double kCostDistance = 1e-5;
constexpr std::int64_t kCostWork = 20'000'000;

/// The same of an edge that a search asks for: the interval is wider where that is not enough.
constexpr std::int64_t kSearchCostWork = 1'000'000;

/// How far below a pair's distance its planes may be, as a share of the distance of nearness,
/// before nodes of its mesh get planes of their own; and how many of these may be looked at
/// [count].
constexpr double kPlaneSlack = 3e-4;
constexpr int kPlaneNodes = 300;

/// Downhill along an edge from a place that is too near: first and last step, in t, and what it may
/// cost [units of Work].
constexpr double kDescentStep = 1.0 / 16;
constexpr double kLeastDescentStep = 1.0 / 512;
constexpr std::int64_t kDescentWork = 50'000;

/// With more pairs [count] an edge or a state looks only at those that are near; with fewer, at
/// all. Measured: a robot's links cost more than that many balls.
constexpr std::size_t kManyPairs = 512;
/// What counts as near for a clearance at first [m], and the factor by which that grows as long as
/// nothing is found.
constexpr double kFirstReach = 0.1;
constexpr double kReachGrowth = 4;

// Goals

/// Valid points drawn from a goal range [count]: enough that a planner finds an easy one, few
/// enough that checking them is not felt. Tries before a range is taken for invalid.
constexpr int kGoalSamples = 16;
constexpr int kGoalAttempts = 1000;

/// Inverse kinematics for a goal of poses [count]: after one start, which most goals need no more
/// than, starts and solutions of a second search, and of a third one, with a proof.
constexpr int kFirstPoseStarts = 24;
constexpr int kFirstPoseSolutions = 8;
constexpr int kPoseStarts = 200;
constexpr int kPoseSolutions = 64;

/// More solutions are drawn so many at a time [count]; after so many draws without a new one there
/// seem to be no others (six joints have 16 at most); and so many are kept.
constexpr int kPoseDraws = 1;
constexpr int kIdleDraws = 32;
constexpr std::size_t kMostPoseSolutions = 256;

/// Positions of a pose are drawn evenly from ranges up to this width [m]: of wider ones most are
/// out of any robot's reach.
constexpr double kWidestDraw = 10;

/// Connect begins with the first valid solution of a goal of poses, and asks for more after every
/// so many iterations [count]: a goal costs about as much as one of them.
constexpr std::uint64_t kGoalTurn = 32;

/// Solutions that differ by less in every joint are one [rad or m].
constexpr double kSameSolution = 1e-4;

/// Points of an invalid goal range that are compared for the least deep one, which is reported.
constexpr int kGoalReports = 16;

/// How near the reported clearance of an invalid start or goal is to the truth [m].
constexpr double kReportTolerance = 1e-6;

// Searches

/// A radian of a turn weighs as much as this share of the way that it takes the farthest point:
/// about the root mean square of a bar's or a box's points. 0.3 to 0.7 plan alike.
constexpr double kTurnShare = 0.5;

/// RRTConnect's (Kuffner, LaValle 2000) range when a problem names none, as a fraction of the
/// space's extent (joints counted up to half a turn). Certified edges cost more the longer they
/// are, and long ones mostly fail: OMPL's 0.2 of the whole extent took three to six times as long
/// on arms of six and seven joints.
constexpr double kConnectRange = 0.08;

/// Connect starts again with another seed after this many iterations, times a term of Luby's
/// series; and looks at the clock after so many iterations, or edges.
constexpr std::uint64_t kConnectRun = 20000;
constexpr std::uint64_t kConnectTurn = 16;

/// An arm's first run goes on, to so many times its length at most, until it has asked so many
/// edges or has searched among so many nodes, all iterations taken together: 0.1 s or two. The
/// slowest of twenty problems of fetch take a third of the time that they take without, baxter's a
/// tenth less.
constexpr std::uint64_t kLongestFirstRun = 5;
constexpr std::uint64_t kFirstRunEdges = 50'000;
constexpr std::uint64_t kFirstRunScans = 100'000'000;

/// Connect's range when a problem names none: this share of the space's extent over the squared
/// degrees of freedom, and at most the second. Measured on arms: 0.12 to 0.16 of the extent suit
/// six and seven joints, 0.04 suits fourteen.
constexpr double kRangeShare = 7;
constexpr double kLongestRange = 0.14;
constexpr double kShortestRange = 1e-4;
/// A free body's range is at most what this turn moves it by [rad]: doors are as large as what goes
/// through them, rooms are not. Of 0.25 to 1.2 those of 0.75 and above did best; the share of the
/// extent alone took several times the iterations.
constexpr double kBodyTurn = 1;
/// But at least this share of the extent, or a small body would take too many steps to get
/// anywhere.
constexpr double kLeastBodyRange = 0.03;

/// The dynamic domain of Connect: a node's radius after its first failure and the least one, and
/// the share by which it shrinks and grows (4, 1 and 1e-4 as in VAMP's). The first two are in
/// ranges, of joints at least in kLongestRange of the extent.
constexpr float kDomainRadius = 4;
constexpr float kLeastDomain = 1;
constexpr float kDomainRate = 1e-4F;

/// Of the samples of a search with slides that share is drawn from where both trees are: a trap is
/// a small part of its world, and so is a door. The part is larger by so many ranges on either
/// side.
constexpr double kBetweenShare = 0.5;
constexpr double kBetweenMore = 0.1;

/// Edges that a slide tries in all, and in a row without success; each of these halves the step.
constexpr int kSlideEdges = 40;
constexpr int kSlideMisses = 5;
/// Contacts that are known at a time, and sweeps over them when a step is made.
constexpr std::size_t kSlideContacts = 6;
constexpr int kSlideSweeps = 12;
/// How often the way to a contact is halved in search of a place just before it.
constexpr int kSlideHalvings = 6;
/// The room that is kept from contacts [m], as a share of the range: less makes edges dear, more
/// keeps out of narrow places.
constexpr double kSlideRoom = 0.01;
/// What a step must gain, as a share of its length, or the slide is at its end.
constexpr double kSlideGain = 0.02;

/// Goals from which Connect's second tree grows when OMPL samples them.
constexpr int kConnectGoals = 16;

/// SST's step and radii when a problem names none, as fractions of the space's extent: its steps go
/// anywhere, and long ones end in obstacles.
constexpr double kStepRange = 0.1;
constexpr double kSelectionRadius = 0.04;
constexpr double kPruningRadius = 0.02;

/// How near a planner must come that cannot reach a goal exactly, as a fraction of the space's
/// extent: near enough that the edge from there is mostly free, far enough to be found by chance.
constexpr double kNearGoal = 0.05;

/// Runs without a single iteration after which a planner is not started again.
constexpr int kIdleRuns = 3;

/// How near clearances are known to a search [m]: beyond the thickness of paint no path is worth a
/// longer search. The certificate has a tolerance of its own.
constexpr double kClearanceTolerance = 1e-3;

/// How near the two ends of a search for clearance are known [m]: what its path has, and what any
/// path can have. Together less than kClearanceTolerance, or it would not see that it has arrived.
constexpr double kBoundTolerance = 2.5e-4;

/// A first look at an edge's clearance: how wide the distances may be, how far it looks first, as
/// most paths come as near as that to something, and if nothing is there [m], the passes of lanes,
/// each at half the clearance of the one before, and what it may cost [units of Work, about a
/// thousand a microsecond].
constexpr double kRoughClearance = 1e-4;
constexpr double kRoughFirst = 0.03;
constexpr double kRoughMost = 0.1;
constexpr double kRoughBeyondGuess = 1.6;
constexpr int kRoughPasses = 6;
constexpr std::int64_t kRoughWork = 30'000;

/// How closely a certificate then knows a path's least clearance, as a share of it. Where a proof
/// fails, less is tried, so often [count], each time so much of it. What a proof may cost, and all
/// of a path's with the world or with itself [units of Work]: to know a path that hugs an obstacle
/// to 0.1 mm takes tens of milliseconds.
constexpr double kLeastShare = 0.3;
constexpr int kProofTries = 4;
constexpr double kProofFall = 0.5;
constexpr std::int64_t kProofWork = 100'000;
constexpr std::int64_t kAllProofsWork = 400'000;

/// Iterations of the first search with raised margins: a fraction of a second, and doubled when it
/// proves too few.
constexpr unsigned long long kFirstBudget = 1000;

/// Pushes towards the bound after each search [count], and what one may cost [units of Work].
constexpr int kClearancePushes = 6;
constexpr std::int64_t kClearancePushWork = 2'000'000;

/// What an optimising planner leaves of the time limit to simplification, as a fraction.
constexpr double kSimplifyShare = 0.05;

/// Time between two calls of a progress callback [s]: what an eye can follow.
constexpr double kProgressPeriod = 0.1;

// Simplification

/// A shortcut that starts or ends this near to a waypoint, as a fraction of the path's length,
/// starts or ends at the waypoint: smaller pieces multiply edges and gain nothing.
constexpr double kShortcutSnap = 5e-3;

/// What a shortcut or a pulled waypoint must gain, as a fraction of the path's length; without it
/// simplification would spend its attempts on the last millionth.
constexpr double kShortcutGain = 1e-4;

/// Every so many attempts at a shortcut, one straightens a single joint.
constexpr int kPartEvery = 3;

/// Sweeps of pulled waypoints, and the fraction of the length that one must gain for another.
constexpr int kPullSweeps = 4;
constexpr double kPullGain = 3e-2;

// Pushing a path off what is near

/// Clearance that a plain plan is pushed to, the one that it keeps where it can, and the least that
/// is worth a push [m]; how much longer the path may get.
constexpr double kPushClearance = 0.008;
constexpr double kPushEnough = 0.003;
constexpr double kPushLeast = 1e-3;
constexpr double kPushLonger = 0.03;

/// What a push may cost [units of Work]: a quarter of a millisecond, or so many times what the
/// simplification before it did, since edges of some robots cost ten times those of others; what
/// each of its proofs may cost at least; how many proofs share the work that is left [count]; the
/// share of that which one place leaves to lesser targets and to other places.
constexpr std::int64_t kPushWork = 250'000;
constexpr std::int64_t kPushSimplifications = 3;
constexpr std::int64_t kPushProofWork = 25'000;
constexpr std::int64_t kPushProofs = 16;
constexpr double kPushKept = 0.5;

/// Where that is not enough, another path is searched for so many times the iterations of the
/// first, and at least for so many.
constexpr std::uint64_t kRoomierShare = 2;
constexpr std::uint64_t kRoomierBudget = 500;

/// Moves of waypoints around one place [count]; of these so many in a row [count] may gain less
/// than a share of what is missing; how far beyond the target they aim, as a factor, because
/// gradients turn; the share of an edge up to which its end is moved in place of a new waypoint;
/// the share of an end's clearance that is aimed at where that limits; the longest move.
constexpr int kMostPushes = 8;
constexpr int kIdlePushes = 2;
constexpr double kPushGain = 0.1;
constexpr double kPushBeyond = 1.3;
constexpr double kPushSnap = 0.75;
constexpr double kPushEnds = 0.95;
constexpr double kLongestPush = 0.2;

/// Witness points nearer than this [m] give no direction; squared gradients [m^2] below which
/// nothing is moved; step of the differences [rad or m].
constexpr double kPushGap = 1e-7;
constexpr double kLeastPushGradient = 1e-8;
constexpr double kPushDifference = 1e-6;

/// A place with more of an edge than this on one side is at its other end: that limits the path
/// where it is an end of the path.
constexpr double kAtEnd = 0.98;

// Searching for clearance

/// A search for clearance ends this share of the bound below it, at most kClearanceTolerance and
/// not nearer than the second [m]: where ends leave 7 mm, 1 mm is much.
constexpr double kNearBound = 0.02;
constexpr double kNearestBound = 5e-5;

/// The share of the limits after which the rest is left to shorter paths of the same clearance;
/// what one of these must gain, as a share of the length, and how many in a row may fail to
/// [count].
constexpr double kClimbShare = 0.85;
constexpr double kShorterGain = 2e-3;
constexpr int kShorterFailures = 12;

/// Paths of which the shortest says how long a safer one may be [count].
constexpr int kShortestRuns = 8;

/// How near the most that start and goals leave is known [m], and how much longer a path for
/// clearance may get by pushes where it is not limited.
constexpr double kEndTolerance = 1e-5;
constexpr double kElsewhereLonger = 0.1;

// Pushing what does not limit a path's least clearance

/// Places of a part that are looked at [count], and how near their clearance is known [m].
constexpr int kElsewhereSamples = 48;
constexpr double kElsewhereTolerance = 2e-4;
/// Targets grow by the first factor, as long as the ends of what is pushed have them, times the
/// second; tries of one target [count], each less by half, and what one must gain, as a share.
constexpr double kElsewhereGrowth = 1.5;
constexpr double kElsewhereEnds = 0.95;
constexpr int kElsewhereTries = 4;
constexpr double kElsewhereGain = 0.05;
/// Ends of parts are looked at when they are longer than this share of the path.
constexpr double kElsewhereShort = 0.05;
/// How often a part is divided, and pushes in all [count]; shortcuts after one.
constexpr int kMostDivisions = 3;
constexpr int kMostElsewhere = 60;
constexpr int kElsewhereShortcuts = 30;
/// Proofs of edges that only rounding has moved allow for that [m].
constexpr double kElsewhereRounding = 1e-7;

// Lowering what a path costs

/// How narrow intervals of costs are, as a share: of a candidate at first, then where the two do
/// not decide, and of what is told.
constexpr double kRoughCostTolerance = 0.1;
constexpr double kCostTolerance = 0.01;
/// The work of all intervals of a path that is told [units of Work].
constexpr std::int64_t kCostReportWork = 1'000'000'000;
/// Rounds of moves, those in a row that gain less than the share before they end, and what a move
/// must gain.
constexpr int kCostRounds = 200;
constexpr int kIdleCostRounds = 3;
constexpr double kCostRoundGain = 2e-3;
constexpr double kCostGain = 1e-4;
/// First step of a move, as a share of the shorter edge; steps that are tried [count].
constexpr double kCostStep = 0.2;
constexpr int kCostSteps = 4;
/// Cuts, and edges that are bent, in a round; waypoints beyond which none is bent [count].
constexpr int kCostCuts = 6;
constexpr std::size_t kCostBends = 4;
constexpr std::size_t kMostCostWaypoints = 48;
/// Paths in a row that may be no cheaper by the share before a search ends [count].
constexpr int kCheaperFailures = 8;
constexpr double kCheaperGain = 2e-3;

// Improving a path once there is one

/// How long the best path so far is simplified once the caller has ended a run [s]: who waits for
/// the end does not notice.
constexpr double kLastSimplification = 0.2;

/// What a search for a shorter path must gain at least, as a share of the length.
constexpr double kImprovement = 1e-3;

/// Such a search's bound, in turns, as a multiple of what the path must become: simplifying makes
/// paths shorter, and what goes another way may be the longer one before. Measured on panda's and
/// ur5's problems of MotionBenchMaker: any from 1.2 to 4 gains 1 to 2 % of the mean length over 1.
constexpr double kImproveSlack[] = {1.1, 2};

/// Between the seeds of two searches for shorter paths, in runs.
constexpr std::uint64_t kImproveRuns = 1ULL << 20;

// Streams of random numbers, far from each other and beyond any number of samplers

constexpr unsigned long long kGoalStream = 1ULL << 40;      ///< goals, one each
constexpr unsigned long long kRunStream = 1ULL << 41;       ///< seeds of a plan's planner runs
constexpr unsigned long long kSimplifyStream = 1ULL << 42;  ///< simplification
constexpr unsigned long long kReplanStream = 1ULL << 43;    ///< seeds of replanning
constexpr unsigned long long kEvasionStream = 1ULL << 44;   ///< evasions
constexpr unsigned long long kTaskStream = 1ULL << 45;      ///< steps of a task, one each

// Tasks

/// Configurations that a step to poses tries, and all such steps of a task together [count]: each
/// costs a search for a path at most.
constexpr std::size_t kStepSolutions = 32;
constexpr int kTaskTries = 500;

/// Iterations of a step's search where the problem has no limit [count]: half a second, and then
/// another configuration is more promising.
constexpr int kStepIterations = 20'000;

/// The first piece of a line that is tried, and the shortest, as shares of the line: the joints
/// would have to move faster there than any does.
constexpr double kFirstLinePiece = 0.25;
constexpr double kShortestLinePiece = 1.0 / 4096;

/// The least tolerance of a line [m, rad]: its pieces are as short as kShortestLinePiece at most.
constexpr double kLeastLineTolerance = 1e-7;

/// Rounding of a line's departure: of poses and bounds, each a few dozen operations [relative to a
/// robot's reach and to one radian].
constexpr double kLineRounding = 1e-13;

// Constraints

/// The least tolerance of a constraint [m, rad]: far above rounding, and what edges can keep in a
/// few thousand pieces.
constexpr double kLeastConstraintTolerance = 1e-6;

/// The least length of an axis or direction: below, its digits are rounding.
constexpr double kLeastAxis = 1e-6;

/// Share of its tolerance that a constraint may use on a path: what is left lets the verifier's
/// first-order bounds prove the same.
constexpr double kConstraintShare = 0.999;

/// How often an edge is halved to prove its constraints: more, and shorter edges are cheaper.
constexpr int kConstraintHalvings = 5;

/// Configurations are brought this near to a constraint, as a share of its tolerance, and tilted by
/// that share of it at most, and of a right angle: the rest is for edges.
constexpr double kProjectionShare = 0.1;
constexpr double kTiltShare = 0.8;
constexpr double kMostTilt = 1.2;

/// Edges of one way along constraints, and its shortest step as a share of its longest.
constexpr int kWayEdges = 100;
constexpr double kShortestWayStep = 1.0 / 256;
/// A step of a way gains at least that share of its length, and is at most so many times as long
/// after its end was brought back.
constexpr double kWayGain = 0.1;
constexpr double kWayDetour = 2;

/// Cuts between two places of a constrained path that are tried, and in a row without success.
constexpr int kWayCuts = 100;
constexpr int kWayCutsInVain = 40;
/// A cut saves at least that share of what it replaces.
constexpr double kWayCutGain = 1e-3;

/// The verifier halves an edge until its constraints are decided, down to that share of it.
constexpr double kVerifyConstraintPiece = 1.0 / (1 << 22);

// Replanning

/// A part of a step in which no obstacle's vertex moves farther than this [m] is not halved again:
/// halving it gains nothing that a robot could feel.
constexpr double kLeastGrowth = 1e-5;

/// How often a step is halved in time: a vertex at 1 m/s moves 0.2 mm in half of 0.05 s / 2^7.
constexpr int kMustHalvings = 7;
/// How often what lies ahead of a step is halved; it is asked again when it comes.
constexpr int kAheadHalvings = 3;

/// Places that are tried when a robot cannot stay [count], and how many of those with the most room
/// are asked for a certificate.
constexpr int kEvasions = 32;
constexpr int kEvasionsAsked = 8;

/// Steps of the trail that are kept for going back [count].
constexpr int kTrail = 400;

/// Planning that failed is tried again after 1, 2, 4, ... steps, at most so many.
constexpr int kLongestPause = 8;

/// Steps that may be looked ahead [count]: each costs what a step costs.
constexpr double kLongestLookAhead = 1000;

// Trajectories

/// Joints without a limit on acceleration reach their limit on velocity from rest in this time [s]:
/// what arms' controllers commonly take.
constexpr double kTimeToVelocityLimit = 0.5;

/// A blended corner is divided into so many parts of constant acceleration along it: twice as many
/// gain less than 1 % of its time.
constexpr int kBendCells = 16;

/// The chords that prove a blend [count, power of two]; one that would need more is not tried.
constexpr int kBlendChords = 128;

/// Cuts of half the shorter edge are tried, then halves of that, so often [count].
constexpr int kBlendTries = 7;

/// Rows that a period may ask for [count]: some hundred megabytes.
constexpr double kMostRows = 1e6;

// Verification

/// How far beyond its tolerance a verified pose may be [m, rad]: rounding of the verifier's own
/// kinematics, and of angles that are whole turns away in a file.
constexpr double kVerifyPose = 1e-12;

/// Where a distance alone decides, it is asked for to this [m].
constexpr double kVerifyTolerance = 1e-9;

/// Where a span is only partly free, its distance is asked for to this fraction: finer costs much
/// more than the larger step saves.
constexpr double kVerifyFraction = 0.4;

/// A span in which the pair can move by no more than this [m] is not split further and stays
/// undecided.
constexpr double kVerifySmallestMotion = 1e-9;

/// Looks [count] before something is left undecided: at one pair of shapes on one edge, at it once
/// part of it is left undecided, and on a whole path. About 10 s and some minutes.
constexpr long kVerifyPairWork = 500'000;
constexpr long kVerifyOpenWork = 20'000;
constexpr long kVerifyWork = 10'000'000;
/// And so many more for each pair of shapes on each edge: most pairs take one.
constexpr double kVerifyLooks = 4;

/// A ball around a part of a cloud whose radius is above this share of its distance is looked at in
/// parts where the certified clearance would rest on it. Smaller bounds are tighter and slower.
constexpr double kVerifyCoarse = 0.1;

/// What the distances of these looks may cost [units of collision::Work]: as long, where each is a
/// depth of meshes that takes milliseconds.
constexpr std::int64_t kVerifyPairCost = 4'000'000'000;
constexpr std::int64_t kVerifyOpenCost = 160'000'000;
constexpr std::int64_t kVerifyCost = 80'000'000'000;

}  // namespace leeway::planner
