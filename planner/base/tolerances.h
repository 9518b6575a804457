#pragma once

// Every tolerance of planner/: its unit, its reason, and the effect of changing it. The rule for
// which constants are here and which are next to their algorithm is in collision/base/tolerances.h.

#include <cstddef>
#include <cstdint>

namespace leeway::planner {

// ========================== 1. Constants that guarantees depend on ==========================
// With another value, a proof, an accepted input or a written file would be wrong.

// Angles and rotations

/// Below this angle [rad] sin x = x and atan x = x to the last bit (x^2 / 3 is under half an ulp).
/// A larger value costs accuracy; below 1e-150 squares underflow to zero and lose the direction.
constexpr double kTinyAngle = 1e-8;

/// A turn below this [rad] has no axis, because the square of its length loses digits. Any axis is
/// then acceptable.
constexpr double kLeastTurn = 1e-150;

/// A quaternion whose length is this near to 1 is unit to rounding. Normalising it again would only
/// perturb it.
constexpr double kUnitToRounding = 1e-15;

/// Squared part of a unit normal across the z axis up to which the verifier treats it as that axis
/// or its opposite. Below this value, squares lose digits.
constexpr double kVerifyAcross = 1e-300;

// Range and rounding of poses

/// Joint angles farther from zero than this [rad] are not certified, and files with such angles are
/// refused, because kInterpolationRounding would not hold.
constexpr double kLargestAngle = 1e3;

/// A circle that turns by more than half a turn on a straight line is split into edges on which it
/// turns by at most this [rad]. It is below half a turn, so that rounding cannot reverse the
/// direction.
constexpr double kLongestLineTurn = 3;

/// How far the rounding of a + t dq (three operations) moves a joint within kLargestAngle [rad], or
/// the orientation of a free body. A length rounds by less than 1e-15 of itself, which
/// robots::kinematicsRounding() covers by its share of the joint's limits.
constexpr double kInterpolationRounding = 1e-12;

/// Bodies behind unlimited joints are certified up to this distance from the world's origin [m],
/// and prismatic, planar and floating joints up to this far along an axis. Files with larger
/// lengths are refused. Farther out, the rounding of kinematics (1e-16 of the distance and more)
/// would consume margins of micrometres.
constexpr double kLargestReach = 1e4;

/// A length outside of its joint's limits is certified up to this [m], because
/// robots::kinematicsRounding() counts lengths within limits only.
constexpr double kLargestLengthOutside = 1e3;

/// The product of a vertex's speed bound and a time is rounded up by this share, because two
/// products and a sum err by less than 1e-15.
constexpr double kGrowthRounding = 1e-14;

/// How far the verifier's poses may be from the exact ones, for each joint, relative to the reach
/// and in metres. At the verifier's angles of up to 1e4 rad and lengths of up to 1e4 m,
/// interpolation rounds by at most 2e-12 rad or m, and sines and products by 1e-14.
constexpr double kVerifyRounding = 4e-12;

// Costs of nearness

/// The sum of at most kEdgeSlots means, each at most 1, rounds by less than this.
constexpr double kCostRounding = 1e-12;

/// How far rounding moves the nearest points of a distance, in the frames of their bodies [m].
constexpr double kWitness = 1e-9;

/// A sum of products with lengths and weights rounds by less than this share of itself.
constexpr double kSumRounding = 1e-13;

// Blended corners

/// Phases of a timed motion are at least this long [s] where there is room. Positions in files have
/// 17 digits: accelerations of a cubic over this time are then exact to 1e-7 rad/s^2, jerks to 1e-3
/// rad/s^3.
constexpr double kLeastPhase = 1e-4;
/// Speeds that differ by at most this share count as one.
constexpr double kSameSpeed = 1e-11;
/// Rows of a timed motion are at least this far apart [s].
constexpr double kLeastRow = 2e-5;

/// The verifier lets a cubic exceed limits on its derivatives by this share: its rows have times in
/// whole nanoseconds, but phases do not begin at them. Of a motion at rest, velocity is at most the
/// square of this share.
constexpr double kVerifyLimit = 1e-3;
/// The joints' share of their way between two rows is taken as the line's if it leaves [0, 1] by no
/// more than this.
constexpr double kVerifyShare = 1e-9;
/// Rounding of positions and times in files, for the same comparison.
constexpr double kVerifyDigits = 4e-15;
/// Rounding of this size is allowed whatever the limits are [rad/s^2 and rad/s^3, or m].
constexpr double kVerifyLeastAcceleration = 1e-4, kVerifyLeastJerk = 10;
/// A third derivative enlarges it by this factor more.
constexpr double kVerifyJerkDigits = 5;

/// A blend is proven as chords. Between any two points of the robot, the relative motion departs
/// from the chords by at most this [m]; the margins include it.
constexpr double kBlendDeviation = 5e-5;

/// On either side of a blended corner a circle turns by less than this [rad]. The total, including
/// the rounding of a chord's ends, is below half a turn, so the chord turns in the same direction.
constexpr double kBlendReach = 1.5;

/// Consecutive edges whose unit directions differ by at most this in each component are traversed
/// without a stop. Cutting an edge rounds by less. The velocity jumps by this share at such a
/// corner.
constexpr double kInLine = 1e-12;

/// Reading and compiling a problem may take as long as planning may, and at least this [s], because
/// a limit of milliseconds is meant for planning.
constexpr double kLeastReading = 10;

// The guard

/// Setpoints keep a limit on velocity, acceleration or jerk if they exceed it by no more than this
/// share: files and their readers round setpoints.
constexpr double kGuardLimitSlack = 1e-6;
/// And rounding of differences of setpoints, relative to the setpoints themselves.
constexpr double kGuardDifference = 1e-15;

/// Rounding that a chord of setpoints is charged: relative to how far setpoints are from it, and
/// [m]. Both are sums of some dozen products of numbers below kGuardLongestChord and kLargestReach.
constexpr double kGuardChordShare = 1e-12;
constexpr double kGuardChordRounding = 1e-11;
/// A longer chord of setpoints is halved, because it would round by more [rad or m].
constexpr double kGuardLongestChord = 2e3;

/// A vertex that is seen this much farther away than its speed bound allows has jumped [m]: more is
/// no rounding of programs that see.
constexpr double kGuardJump = 1e-9;

/// A sight this much later than a time is of that time: a few ulps of sums of periods [relative to
/// 1 s and the time].
constexpr double kSightTime = 1e-14;

/// Two times of a guard this near are one [periods].
constexpr double kGuardSameTime = 1e-6;
/// A guard refuses times whose neighbouring doubles are farther apart than this [periods]. Seconds
/// since 1970 are 2.4e-7 s apart: periods down to 0.24 ms pass.
constexpr double kGuardCoarsestTime = 1e-3;

// Accepted input, and values in it that count as equal

/// How far from 1 the length of a planned body's quaternion may be to count as a rotation. Rounding
/// leaves 1e-15, and loaders normalise anything within kMendableQuaternion. A quaternion that is
/// farther off comes from a program that did not normalise it.
constexpr double kUnitQuaternion = 1e-6;

/// A quaternion in a file that is this near to unit length is meant to be a rotation (three or four
/// written digits). It is normalised, with a warning above kSilentQuaternion; a larger error is
/// refused.
constexpr double kMendableQuaternion = 1e-3;
constexpr double kSilentQuaternion = 1e-8;

/// A start or goal of MoveIt's that is this far outside a limit [rad or m] is the limit itself,
/// written with fewer digits (3.14159 for pi). It is moved onto the limit, with a warning. A larger
/// value would move a robot without being asked to.
constexpr double kLimitSlack = 1e-5;

/// A column of a path file that is not planned must agree with the problem within this [rad or m],
/// because logs have six digits.
constexpr double kPassiveJointSlack = 1e-5;

/// The meaning of `any` for a pose's position [m]: no robot reaches as far.
constexpr double kAnyPosition = 1e6;

/// Goals from MoveIt's constraints are shrunk by this [m, rad], because solutions are within 1e-9
/// of them and angles may be that far from their turns about the axes. Smaller goals are refused.
constexpr double kConstraintSlack = 2e-8;

/// How near a verified path's ends must be to start and goal, and how far outside its limits a
/// waypoint may be [rad or m]. It covers the rounding of files and of whole turns, and is too small
/// to matter to a robot.
constexpr double kVerifyWaypoint = 1e-9;

/// The verifier treats links that meet at a joint as touching up to this distance [m]. It exceeds
/// kTouch of robots/, so that the rounding of two kinematics cannot make the verifier check pairs
/// that the planner leaves out.
constexpr double kVerifyTouch = 2e-6;
/// The number of steps of the joint that the verifier samples, equal to kTouchLooks.
constexpr int kVerifyTouchLooks = 128;

/// OMPL writes parameters with six digits. A parameter that reads back within this share was
/// accepted.
constexpr double kParameterDigits = 1e-5;

/// Bounds on the limits on velocity, acceleration and jerk in a problem, and the least share of
/// them. They are far beyond all machines, and products and quotients of limits do not overflow. A
/// velocity in a URDF above the largest means no limit.
constexpr double kLeastLimit = 1e-9;
constexpr double kMostLimit = 1e9;

/// The latest time [s] that the stamps of trajectory_msgs/JointTrajectory can hold.
constexpr double kLatestStamp = 2147483647;

// ================================ 2. Constants that only tune ================================
// They change time, memory, or the quality of an answer, but never its correctness.

// Edges: what ends a proof

/// An interval of an edge in which no point of a pair moves farther than this [m] is not split
/// again. A pair that is still open there comes within about this distance of its margin, and is
/// undecided. A smaller value only delays that answer.
constexpr double kSmallestMotion = 1e-6;

/// Maximum number of halvings of an interval: 2^-30 of an edge of one metre is a nanometre.
constexpr int kDeepestLevel = 30;

/// Work limit of an edge before it is left undecided [units of collision::Work, about a nanosecond
/// each]. Without it, an edge that grazes an obstacle can cost fifty times the usual work. Of the
/// edges that planning and simplifying check in 14 MotionBenchMaker problems with four seeds each,
/// it leaves 17 of ur5's 20,100 open and 0 of panda's 32,000. Four fifths of it leave 48 of ur5's.
constexpr std::int64_t kEdgeWork = 100'000;

/// kEdgeWork for a body that flies freely among triangles. Its surfaces are followed through the
/// whole edge at once, and kEdgeWork would leave one in thirty of such edges undecided.
constexpr std::int64_t kFlightWork = 500'000;

/// kEdgeWork for edges that no other edge can replace: certificates of paths and of steps.
constexpr std::int64_t kPersistentWork = 10'000'000;

/// Number of undecided edges in a search after which its edges may cost twice as much. The search
/// has lost 6 ms to them at the first doubling, and 0.8 s by kPersistentWork.
constexpr std::uint64_t kEscalation = 64;

/// The last valid place of an edge is found to 2^-12 of the edge. Planners return there and need no
/// more accuracy.
constexpr int kLastValidLevel = 12;

/// Tries at a last valid state nearer to the start, each half as far. The edge is certified up to
/// the first one, but its end is a rounded point, which may not be valid near contact.
constexpr int kLastValidTries = 4;

// Edges: lanes

/// Finer passes of lanes over the parts that the pass over a whole edge left open [count], and the
/// smallest part of an edge for such a pass. Pairs that are open in smaller parts nearly touch, and
/// exact sweeps decide them. Measured.
constexpr int kLanePasses = 24;
constexpr double kFinestPart = 0x1p-10;

/// Several open intervals are swept exactly as one while the sweep's growth stays below this
/// [m]. Bodies that are always near each other have little relative motion, and one sweep of meshes
/// costs as much over a long interval as over a short one. Measured.
constexpr double kMergedGrowth = 2e-3;

/// Intervals that remain after finer passes are merged, pair by pair, up to this growth [m]. The
/// remaining pairs are near and move little in one interval. Measured.
constexpr double kMergedAgainGrowth = 2e-4;

// Edges: exact sweeps

/// A sweep is tried only if the growth of its hull is below this [m]; wider sweeps seldom prove
/// anything that their halves would not. Measured.
constexpr double kSweepGrowth = 0.02;

/// Each pair has its own limit below that, because pairs of one robot stay at about the same
/// distance from edge to edge. Without the least limit, an edge that grazed an obstacle once would
/// slow down the next.
constexpr double kGrowthLimitFall = 0.7;    ///< after a failed sweep, as a share of its growth
constexpr double kGrowthLimitRise = 1.1;    ///< factor after a successful sweep
constexpr double kLeastGrowthLimit = 2e-4;  ///< the least limit [m]

/// A sweep of meshes with more growth than this [m] visits at most this number of pairs of nodes.
/// Halves of the interval, which the hulls alone often decide, are cheaper than a deep descent.
/// Measured.
constexpr double kDeepSweepGrowth = 1e-3;
constexpr int kShallowNodes = 12;

/// Pairs of nodes that a search for a contact in the middle of an interval visits [count]. Nearly
/// all searches that find a contact have found it by then. Measured.
constexpr int kContactNodes = 200;

// Edges: the least clearance

/// Distance queries for the clearance of one edge before its interval is left wider than the
/// tolerance, and their work limit [units of collision::Work]. Depths of meshes take up to
/// milliseconds each.
constexpr int kClearanceQueries = 100'000;
constexpr std::int64_t kClearanceWork = 100'000'000;

/// Passes of lanes after the first, as long as each finds a nearer pair, and the pairs that are
/// measured after each pass [count]. Measured.
constexpr int kClearancePasses = 3;
constexpr int kClearanceLooks = 2;

// Edges: the cost of nearness (edge_cost.cc, path_cost.cc)

/// Width of the first cost interval of an edge, as a share, relative to the other edges of a path.
constexpr double kFirstCostTolerance = 0.3;

/// Tolerance of the least clearance, as a share of the distance of nearness: for the worst place of
/// a path, and for its gradient.
constexpr double kWorstCostShare = 5e-3;
constexpr double kGradientShare = 1e-3;

/// Tolerance of distances, as a share of the distance at which nearness ends or begins to fall.
constexpr double kCostDistance = 1e-5;
/// Work limit for the cost of an edge that names none [units of Work].
constexpr std::int64_t kCostWork = 20'000'000;

/// The same limit for an edge of a search. If it is not enough, the interval stays wider.
constexpr std::int64_t kSearchCostWork = 1'000'000;

/// How far below a pair's distance its planes may be, as a share of the distance of nearness,
/// before nodes of its mesh get their own planes; and how many nodes may be visited [count].
constexpr double kPlaneSlack = 3e-4;
constexpr int kPlaneNodes = 300;

/// Descent along an edge from a place that is too near.
constexpr double kDescentStep = 1.0 / 16;        ///< first step, in t
constexpr double kLeastDescentStep = 1.0 / 512;  ///< last step, in t
constexpr std::int64_t kDescentWork = 50'000;    ///< work limit [units of Work]

/// With more pairs [count] an edge or a state visits only those that are near; with fewer, it
/// visits all. Measured: a search for each of a robot's links costs more than the balls of this
/// number of pairs.
constexpr std::size_t kManyPairs = 512;

// Goals

/// Valid points drawn from a goal range [count]: enough for a planner to find an easy one, and few
/// enough that checking them takes little time.
constexpr int kGoalSamples = 16;
/// Tries before a goal range is treated as invalid [count].
constexpr int kGoalAttempts = 1000;

/// Inverse kinematics for a goal of poses [count]. Most goals need only one start. A second search,
/// and a third search with a proof, have more starts and solutions.
constexpr int kFirstPoseStarts = 24;    ///< second search
constexpr int kFirstPoseSolutions = 8;  ///< second search
constexpr int kPoseStarts = 200;        ///< third search
constexpr int kPoseSolutions = 64;      ///< third search

/// Further solutions of a goal of poses [count].
constexpr int kPoseDraws = 1;   ///< solutions per draw
constexpr int kIdleDraws = 32;  ///< draws without a new one that end it: six joints have 16
constexpr std::size_t kMostPoseSolutions = 256;  ///< solutions kept

/// Positions of a pose are drawn uniformly from ranges up to this width [m]. Most positions in a
/// wider range are out of reach of any robot.
constexpr double kWidestDraw = 10;

/// Connect starts with the first valid solution of a goal of poses, and requests more after this
/// number of iterations [count]: a goal costs about the same as one iteration.
constexpr std::uint64_t kGoalTurn = 32;

/// Solutions that differ by less than this in every joint are the same solution [rad or m].
constexpr double kSameSolution = 1e-4;

/// Points of an invalid goal range among which the least deep one is chosen for the report.
constexpr int kGoalReports = 16;

/// Tolerance of the reported clearance of an invalid start or goal [m].
constexpr double kReportTolerance = 1e-6;

// Searches

/// The weight of a radian of a turn, as a share of the distance by which it moves the farthest
/// point. This is about the root mean square over a bar's or a box's points. 0.3 to 0.7 plan
/// equally well.
constexpr double kTurnShare = 0.5;

/// Default range of RRTConnect (Kuffner, LaValle 2000), as a fraction of the space's extent (joints
/// counted up to half a turn). Longer certified edges cost more and mostly fail: OMPL's 0.2 of the
/// whole extent took three to six times as long on arms of six and seven joints.
constexpr double kConnectRange = 0.08;

/// Connect restarts with another seed after this many iterations, times a term of Luby's series.
constexpr std::uint64_t kConnectRun = 20000;
/// Iterations, or edges, between two looks of Connect at the clock.
constexpr std::uint64_t kConnectTurn = 16;

/// An arm's first run continues until it reaches one of these limits (0.1 to 0.2 s). The slowest of
/// twenty problems of fetch then take a third of the time, those of baxter a tenth less.
constexpr std::uint64_t kLongestFirstRun = 5;          ///< as a multiple of its length
constexpr std::uint64_t kFirstRunEdges = 50'000;       ///< edges checked
constexpr std::uint64_t kFirstRunScans = 100'000'000;  ///< nodes searched, over all iterations

/// Connect's default range. Measured on arms: 0.12 to 0.16 of the space's extent suit six and seven
/// joints, 0.04 suits fourteen.
constexpr double kRangeShare = 7;       ///< share of the extent over the squared degrees of freedom
constexpr double kLongestRange = 0.14;  ///< greatest share of the extent
constexpr double kShortestRange = 1e-4;  ///< least share of the extent
/// A free body's range is at most the distance by which this turn moves it [rad]. The reason is
/// that doors are as large as the bodies that pass through them, and rooms are not. Of 0.25 to 1.2,
/// values of 0.75 and above did best; the share of the extent alone took several times the
/// iterations.
constexpr double kBodyTurn = 1;
/// It is at least this share of the extent; otherwise a small body would need too many steps.
constexpr double kLeastBodyRange = 0.03;

/// The dynamic domain of Connect (4, 1 and 1e-4 as in VAMP). The unit of radii is the range, for
/// joints at least kLongestRange of the extent.
constexpr float kDomainRadius = 4;    ///< a node's radius after its first failure
constexpr float kLeastDomain = 1;     ///< the least radius
constexpr float kDomainRate = 1e-4F;  ///< share by which the radius shrinks and grows

/// A search with slides draws this share of its samples from the region of both trees, because a
/// trap or a door is a small part of its world. The region is enlarged by this number of ranges on
/// each side.
constexpr double kBetweenShare = 0.5;
constexpr double kBetweenMore = 0.1;

/// Edges that a slide tries in total, and in a row without success; each failure halves the step.
constexpr int kSlideEdges = 40;
constexpr int kSlideMisses = 5;
/// The largest number of contacts stored at a time, and sweeps over them for each step.
constexpr std::size_t kSlideContacts = 6;
constexpr int kSlideSweeps = 12;
/// Halvings of the way to a contact in the search for a place just before it.
constexpr int kSlideHalvings = 6;
/// Clearance that is kept from contacts [m], as a share of the range: less makes edges expensive,
/// more blocks narrow passages.
constexpr double kSlideRoom = 0.01;
/// A slide ends when a step gains less than this share of its length.
constexpr double kSlideGain = 0.02;

/// Number of goals from which Connect's second tree grows when OMPL samples them.
constexpr int kConnectGoals = 16;

/// SST's default step and radii, as fractions of the space's extent. Its steps have random
/// directions, and long ones end in obstacles.
constexpr double kStepRange = 0.1;
constexpr double kSelectionRadius = 0.04;
constexpr double kPruningRadius = 0.02;

/// How near a planner that cannot reach a goal exactly must come, as a fraction of the space's
/// extent. It is near enough that the edge from there is mostly free, and far enough to be found by
/// chance.
constexpr double kNearGoal = 0.05;

/// Number of runs without an iteration after which a planner is not restarted.
constexpr int kIdleRuns = 3;

/// Tolerance of clearances in a search [m]: a gain of less than the thickness of paint is not worth
/// a longer search. The certificate has its own tolerance.
constexpr double kClearanceTolerance = 1e-3;

/// Tolerance of the two ends of a search for clearance [m]: the clearance of its path, and that of
/// any path. Their sum is less than kClearanceTolerance; otherwise the search could not detect that
/// it is done.
constexpr double kBoundTolerance = 2.5e-4;

/// First estimate of an edge's clearance. Most paths come within kRoughFirst of an obstacle.
constexpr double kRoughClearance = 1e-4;     ///< width of its distances [m]
constexpr double kRoughFirst = 0.03;         ///< first reach [m]
constexpr double kRoughMost = 0.1;           ///< reach if no pair is found in the first [m]
constexpr double kRoughBeyondGuess = 1.6;    ///< first reach over a known clearance
constexpr int kRoughPasses = 6;              ///< passes of lanes, each at half the last clearance
constexpr std::int64_t kRoughWork = 30'000;  ///< work limit [units of Work, a thousand a us]

/// How a certificate encloses a path's least clearance. Enclosing the clearance of a path close to
/// an obstacle to 0.1 mm would take tens of milliseconds.
constexpr double kLeastShare = 0.3;               ///< relative width of the interval
constexpr int kProofTries = 4;                    ///< proofs of smaller clearances after a failure
constexpr double kProofFall = 0.5;                ///< factor of each such clearance
constexpr std::int64_t kProofWork = 100'000;      ///< work limit of a proof [units of Work]
constexpr std::int64_t kAllProofsWork = 400'000;  ///< of a path's proofs with world or self

/// Iterations of the first search with raised margins: a fraction of a second. They are doubled if
/// they are too few.
constexpr unsigned long long kFirstBudget = 1000;

/// Pushes towards the bound after each search [count], and the work limit of one [units of Work].
constexpr int kClearancePushes = 6;
constexpr std::int64_t kClearancePushWork = 2'000'000;

/// The fraction of the time limit that an optimising planner leaves for simplification.
constexpr double kSimplifyShare = 0.05;

/// Time between two calls of a progress callback [s], slow enough for an eye to follow.
constexpr double kProgressPeriod = 0.1;

// Simplification

/// A shortcut that starts or ends this near to a waypoint, as a fraction of the path's length,
/// starts or ends at the waypoint. Smaller pieces multiply edges and gain nothing.
constexpr double kShortcutSnap = 5e-3;

/// Minimum gain of a shortcut or a pulled waypoint, as a fraction of the path's length. Without it,
/// simplification would spend its attempts on the last millionth.
constexpr double kShortcutGain = 1e-4;

/// One attempt at a shortcut in this many straightens a single joint.
constexpr int kPartEvery = 3;

/// Sweeps of pulled waypoints, and the fraction of the length that a sweep must gain for another.
constexpr int kPullSweeps = 4;
constexpr double kPullGain = 3e-2;

// Pushing a path off nearby obstacles

/// Clearances of a push, and how much longer it may make the path.
constexpr double kPushClearance = 0.008;  ///< target of a plain plan [m]
constexpr double kPushEnough = 0.003;     ///< the clearance that it keeps where it can [m]
constexpr double kPushLeast = 1e-3;       ///< the least that is worth a push [m]
constexpr double kPushLonger = 0.03;      ///< greatest relative increase of the length

/// Work of a push: the greater one of the first two limits, because edges of some robots cost ten
/// times those of others.
constexpr std::int64_t kPushWork = 250'000;       ///< a quarter of a millisecond [units of Work]
constexpr std::int64_t kPushSimplifications = 3;  ///< multiple of the simplification's work
constexpr std::int64_t kPushProofWork = 25'000;   ///< least limit of a proof [units of Work]
constexpr std::int64_t kPushProofs = 16;          ///< proofs that share the remaining work
constexpr double kPushKept = 0.5;  ///< share of it that a place leaves to other targets and places

/// If the push is not enough, another path is searched for this multiple of the iterations of the
/// first search, and at least for this number of iterations.
constexpr std::uint64_t kRoomierShare = 2;
constexpr std::uint64_t kRoomierBudget = 500;

/// Moves of waypoints around one place.
constexpr int kMostPushes = 8;       ///< moves [count]
constexpr int kIdlePushes = 2;       ///< moves in a row [count] that may gain too little
constexpr double kPushGain = 0.1;    ///< sufficient gain, as a share of the missing clearance
constexpr double kPushBeyond = 1.3;  ///< factor beyond the target, because gradients turn
constexpr double kPushSnap =
    0.75;  ///< share of an edge within which its end moves, not a new point
constexpr double kPushEnds = 0.95;    ///< target as a share of the clearance of a limiting end
constexpr double kLongestPush = 0.2;  ///< longest move

/// Gradients of distances.
constexpr double kPushGap = 1e-7;            ///< witness points nearer than this give none [m]
constexpr double kLeastPushGradient = 1e-8;  ///< no move below this squared gradient [m^2]
constexpr double kPushDifference = 1e-6;     ///< step of the differences [rad or m]

/// A place beyond this fraction of an edge counts as the edge's end. If this is an end of the path,
/// it limits the path.
constexpr double kAtEnd = 0.98;

// Searching for clearance

/// A search for clearance ends at this share of the bound below the bound, at most
/// kClearanceTolerance: if the ends leave 7 mm, 1 mm is much.
constexpr double kNearBound = 0.02;
/// The search ends at least this far below the bound [m].
constexpr double kNearestBound = 5e-5;

/// The end of a search for clearance.
constexpr double kClimbShare = 0.85;   ///< share of the limits; the rest is for shorter paths
constexpr double kShorterGain = 2e-3;  ///< gain of a shorter path, as a share of the length
constexpr int kShorterFailures = 12;   ///< paths in a row without it that end the search [count]

/// Number of paths whose shortest one limits the length of a safer path [count].
constexpr int kShortestRuns = 8;

/// Tolerance of the greatest clearance that start and goals allow [m].
constexpr double kEndTolerance = 1e-5;
/// Greatest relative increase of the length by pushes, for a path for clearance without a limit.
constexpr double kElsewhereLonger = 0.1;

// Pushing the parts that do not limit a path's least clearance

/// Samples of a part [count], and the tolerance of their clearance [m].
constexpr int kElsewhereSamples = 48;
constexpr double kElsewhereTolerance = 2e-4;
/// Targets of a part.
constexpr double kElsewhereGrowth = 1.5;  ///< target over the clearance so far, at most
constexpr double kElsewhereEnds = 0.95;   ///< target over the clearance of its ends, at most
constexpr int kElsewhereTries = 4;        ///< tries [count], each with half of the last gain
constexpr double kElsewhereGain = 0.05;   ///< relative gain that a try must have
/// Ends of parts are sampled if they are longer than this share of the path.
constexpr double kElsewhereShort = 0.05;
/// Limits of these pushes [count].
constexpr int kMostDivisions = 3;        ///< divisions of a part
constexpr int kMostElsewhere = 60;       ///< pushes in total
constexpr int kElsewhereShortcuts = 30;  ///< shortcuts after a push
/// Proofs of edges that only rounding has moved allow for this rounding [m].
constexpr double kElsewhereRounding = 1e-7;

// Lowering the cost of a path

/// Relative width of cost intervals.
constexpr double kRoughCostTolerance = 0.1;  ///< of a candidate at first
constexpr double kCostTolerance = 0.01;      ///< of undecided candidates, and of reported costs
/// Work limit of all intervals of a reported path [units of Work].
constexpr std::int64_t kCostReportWork = 1'000'000'000;
/// Rounds of moves [count], and relative gains.
constexpr int kCostRounds = 200;         ///< maximum number of rounds
constexpr int kIdleCostRounds = 3;       ///< rounds in a row without a sufficient gain
constexpr double kCostRoundGain = 2e-3;  ///< sufficient gain of a round
constexpr double kCostGain = 1e-4;       ///< least gain of a move
/// First step of a move, as a share of the shorter edge, and the number of steps tried [count].
constexpr double kCostStep = 0.2;
constexpr int kCostSteps = 4;
/// Moves of a round [count].
constexpr int kCostCuts = 6;                    ///< cuts
constexpr std::size_t kCostBends = 4;           ///< bent edges
constexpr std::size_t kMostCostWaypoints = 48;  ///< waypoints beyond which no edge is bent
/// Paths in a row that end a search, if none of them gains kCheaperGain [count].
constexpr int kCheaperFailures = 8;
constexpr double kCheaperGain = 2e-3;

// Improving a path once there is one

/// How long the best path so far is simplified after the caller has ended a run [s], short enough
/// that a waiting caller does not notice.
constexpr double kLastSimplification = 0.2;

/// Minimum gain in a search for a shorter path, as a share of the length.
constexpr double kImprovement = 1e-3;

/// Bounds of such searches, used in turns, as multiples of the length that the path must reach.
/// Simplifying shortens paths, and a path through another passage may be longer before it. Measured
/// on the MotionBenchMaker problems of panda and ur5: any value from 1.2 to 4 gains 1 to 2 % of the
/// mean length compared with 1.
constexpr double kImproveSlack[] = {1.1, 2};

/// Difference between the seeds of two searches for shorter paths, in runs.
constexpr std::uint64_t kImproveRuns = 1ULL << 20;

// Streams of random numbers, far from each other and beyond any number of samplers

constexpr unsigned long long kGoalStream = 1ULL << 40;      ///< goals, one each
constexpr unsigned long long kRunStream = 1ULL << 41;       ///< seeds of a plan's planner runs
constexpr unsigned long long kSimplifyStream = 1ULL << 42;  ///< simplification
constexpr unsigned long long kReplanStream = 1ULL << 43;    ///< seeds of replanning
constexpr unsigned long long kEvasionStream = 1ULL << 44;   ///< evasions
constexpr unsigned long long kTaskStream = 1ULL << 45;      ///< steps of a task, one each
constexpr unsigned long long kLineStream = 1ULL << 46;      ///< joints that a line leaves free

// Tasks

/// Configurations that a step to poses tries, and the total for all such steps of a task [count].
/// Each costs at most one search for a path.
constexpr std::size_t kStepSolutions = 32;
constexpr int kTaskTries = 500;

/// Iterations of a step's search if the problem has no limit [count]: half a second. After that,
/// another configuration is more likely to succeed.
constexpr int kStepIterations = 20'000;

/// The first piece of a line that is tried, and the shortest, as shares of the way to the next
/// pose. In a shorter piece the joints would have to move faster than any joint does.
constexpr double kFirstLinePiece = 0.25;
constexpr double kShortestLinePiece = 1.0 / 4096;

/// A line is tried again with other motions of the joints that it leaves free, until this number of
/// tries in a row has gained nothing [count].
constexpr int kLineTries = 48;
/// The largest extra motion of a joint in such a try, from one pose to the next [rad or m].
constexpr double kMostDrift = 6;

/// Parts of an edge over which the speed of a line's frame is bounded, each by itself [count].
constexpr int kSpeedParts = 16;

/// Joint values from which a line is followed where its start is given by poses [count], and of
/// these the ones from which it goes on longest that are tried with other motions.
constexpr std::size_t kLineStarts = 64;
constexpr std::size_t kLongestLines = 4;

/// A joint is at its limit where it ends a line so near to it [rad or m].
constexpr double kNearLimit = 1e-2;

/// The step of differences that tell how a joint moves a frame [rad or m], and the least effect of
/// one that does, as a share of the largest or per unit.
constexpr double kDifferenceStep = 1e-5;
constexpr double kLeastEffect = 1e-6;

/// Turns as near as that to half a turn may go either way round [rad]; the least area between the
/// chords of an arc, by the square of the longest: the radius is at most a million times as long.
constexpr double kHalfTurnSlack = 1e-6;
constexpr double kLeastArc = 1e-6;

/// The least tolerance of a line [m, rad]. Its pieces are at least kShortestLinePiece long.
constexpr double kLeastLineTolerance = 1e-7;

/// Rounding of a line's departure, from poses and bounds of a few dozen operations each [relative
/// to a robot's reach and to one radian].
constexpr double kLineRounding = 1e-13;

// Constraints

/// The least tolerance of a constraint [m, rad]. It is far above rounding, and edges can satisfy it
/// with a few thousand pieces.
constexpr double kLeastConstraintTolerance = 1e-6;

/// The least length of an axis or direction. The digits of a shorter one are rounding.
constexpr double kLeastAxis = 1e-6;
/// And the greatest: squares of longer ones could overflow.
constexpr double kMostAxis = 1e6;

/// Share of its tolerance that a constraint or a line may use on a path. The rest lets the
/// verifier's first-order bounds prove the same.
constexpr double kConstraintShare = 0.999;

/// How often an edge is halved to prove its constraints. Beyond that, shorter edges are cheaper.
constexpr int kConstraintHalvings = 5;

/// Configurations are projected onto constraints this closely; the rest of the tolerance is for
/// edges.
constexpr double kProjectionShare = 0.1;  ///< error, as a share of the tolerance
constexpr double kTiltShare = 0.8;        ///< greatest tilt, as a share of the tolerance
constexpr double kMostTilt = 1.2;         ///< greatest tilt [rad], below a right angle

/// States that a condition is given at once.
constexpr double kConditionStates = 256;

/// Edges of one way along constraints, and its shortest step as a share of its longest.
constexpr int kWayEdges = 100;
constexpr double kShortestWayStep = 1.0 / 256;
/// Least gain of a step of a way, as a share of its length.
constexpr double kWayGain = 0.1;
/// Greatest length of a step after its end was projected, as a multiple of its length before.
constexpr double kWayDetour = 2;

/// Cuts between two places of a constrained path that are tried, and in a row without success.
constexpr int kWayCuts = 100;
constexpr int kWayCutsInVain = 40;
/// A cut must save at least this share of the part that it replaces.
constexpr double kWayCutGain = 1e-3;

/// The verifier halves an edge until its constraints are decided, down to this share of the edge.
constexpr double kVerifyConstraintPiece = 1.0 / (1 << 22);

// Replanning

/// A part of a step in which no obstacle's vertex moves farther than this [m] is not halved again.
/// The gain would be too small to matter to a robot.
constexpr double kLeastGrowth = 1e-5;

/// Maximum halvings of a step in time: a vertex at 1 m/s moves 0.2 mm in half of 0.05 s / 2^7.
constexpr int kMustHalvings = 7;
/// The longest part of a time that is tried at once [s], or a step: longer ones are rarely free.
constexpr double kLongestPart = 0.4;
/// Maximum halvings of the time ahead of a step, which is checked again when it comes.
constexpr int kAheadHalvings = 3;

/// Places that are tried if a robot cannot stay [count], and how many of them, those with the
/// greatest clearance, are certified.
constexpr int kEvasions = 32;
constexpr int kEvasionsAsked = 8;

/// Steps of the trail that are kept for going back [count].
constexpr int kTrail = 400;

/// Failed planning is repeated after 1, 2, 4, ... steps, at most this number.
constexpr int kLongestPause = 8;

/// Maximum steps of look-ahead [count]. Each costs the same as a step.
constexpr double kLongestLookAhead = 1000;

// The guard

/// The largest departure of setpoints from a chord for which it is tried at first, and at most [m].
/// It falls by half of what failed, and rises by half of what was proven.
constexpr double kGuardFirstGrowth = 0.05;
constexpr double kGuardMostGrowth = 0.2;
constexpr double kGuardLeastGrowth = 1e-4;
/// A chord whose setpoints are nearer [m] is not divided to find out whether all of it is free:
/// that has been asked already.
constexpr double kGuardOnLine = 1e-9;

/// The work of a chord, and the least that an edge is charged [units of Work]: placing the robot is
/// not counted.
constexpr std::int64_t kGuardChordWork = 50'000;
constexpr std::int64_t kGuardLeastWork = 1'000;

/// Bounds by which one derivative of a polynomial is proven to keep its limit, at most, parts in
/// which its curvature is bounded, and the work of one bound [units of Work].
constexpr int kGuardPolynomialSteps = 200;
constexpr int kGuardPolynomialParts = 16;
constexpr std::int64_t kGuardPolynomialWork = 50;

/// Parts of the horizon for which it is bounded where obstacles are [count].
constexpr int kGuardSlices = 16;

/// Rows of the longest stop, and rows more for a robot that is faster than its limits [count].
constexpr double kMostStopRows = 1e5;
constexpr int kSpareStopRows = 16;

// Trajectories

/// Joints without a limit on acceleration reach their limit on velocity from rest in this time [s],
/// a typical value of arm controllers.
constexpr double kTimeToVelocityLimit = 0.5;

/// Maximum number of chords that prove a blend [power of two]. A blend that would need more is not
/// tried.
constexpr int kBlendChords = 128;

/// The search for blends: speeds that are tried at a corner, each 0.71 of the one before; rounds
/// over all corners [count]; and the share of its time by which a blend must be better.
constexpr int kBlendSpeeds = 16;
constexpr int kBlendRounds = 6;
constexpr double kBlendGain = 1e-3;
/// And the speed of two corners that become faster at once, as a share of the limit.
constexpr double kBlendStart = 0.3;

/// Waypoints of a motion are left out up to this distance from the line between those beside them
/// [rad or m].
constexpr double kStraightening = 0.1;

/// Cuts keep this share of a path's clearance above the margins, which is known this well [m].
constexpr double kCutShare = 0.5;
constexpr double kCutClearance = 1e-3;

/// A blend without a proof is made shorter by this share, this often [count]; then the motion
/// stops.
constexpr double kBlendShrink = 0.6;
constexpr int kBlendTries = 7;

/// A crop's reach grows by this share of its distance from the world's origin. So it still covers a
/// robot whose base was written as a quaternion and read again.
constexpr double kCropGrowth = 1e-12;

/// The latest time of a row that is read [s], about 30,000 years: differences are exact to 0.1 ms.
constexpr double kLatestTime = 1e12;

/// Quintics through the rows of a file are its cubics to within this [rad or m]; rows that depart
/// farther are named.
constexpr double kQuinticSlack = 1e-6;

/// Maximum number of rows of a sampled trajectory [count]: a few hundred megabytes.
constexpr double kMostRows = 1e6;

// Execution along a path

/// The longest period of an executed motion's rows [s]: those of common controllers are shorter.
constexpr double kLongestPeriod = 0.02;

/// Stops along a path that are tried: the periods for which the robot goes on at first, because it
/// cannot slow down where it brakes or turns already [count]; and their times as multiples of the
/// least at the velocity there. More find shorter stops, and take longer.
constexpr int kStopWaits[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 14, 16,
                              18, 20, 22, 24, 27, 30, 33, 36, 40, 44, 48, 53, 58, 64};
constexpr double kStopTimes[] = {1, 1.15, 1.35, 1.6, 1.9, 2.3, 2.8, 3.5};

/// Steps that are shorter share a stop for this long [s]: proofs and logs of stops cost more than
/// the rest of such steps. A longer time stops later.
constexpr double kStopEvery = 0.05;

/// The largest share of a clearance's tolerance that a chord's departure takes.
constexpr double kDepartureShare = 0.1;

/// The longest time that an evasion would take at the velocity limits [s]. From rest to rest it
/// takes about three times that.
constexpr double kEvasionTime = 0.4;

// Verification

/// Rows may exceed limits by this share: far above kGuardLimitSlack.
constexpr double kVerifyRowLimit = 1e-5;
/// Rounding of a log's numbers, which are written to the bit: of places that are sums of a few
/// products, relative to 1 + their size; and of times, a start plus a product, relative to the
/// larger of both.
constexpr double kLogPlaceDigits = 1e-15;
constexpr double kLogTimeDigits = 4e-16;
/// The share of a limit that rounding may hide. If it could hide more, the log is undecided.
constexpr double kLogLimitShare = 0.05;

/// How far beyond its tolerance a verified pose may be [m, rad]. It covers the rounding of the
/// verifier's own kinematics, and of angles in a file that are whole turns away.
constexpr double kVerifyPose = 1e-12;

/// The largest coefficient of a cubic between rows that is verified [rad or m]. A sum of three of
/// them rounds by less than kVerifyRounding allows for.
constexpr double kVerifyCubic = 100;

/// Tolerance of a distance that alone decides [m].
constexpr double kVerifyTolerance = 1e-9;

/// Relative tolerance of the distance in a span that is only partly free. A finer one costs much
/// more than the larger step saves.
constexpr double kVerifyFraction = 0.4;

/// A span in which the pair moves by at most this [m] is not split further and stays undecided.
constexpr double kVerifySmallestMotion = 1e-9;

/// Limits on looks [count]. They take about 10 s and several minutes.
constexpr long kVerifyPairWork = 500'000;  ///< at one pair of shapes on one edge
constexpr long kVerifyOpenWork = 20'000;   ///< at the pair once part of it is undecided
constexpr long kVerifyWork = 10'000'000;   ///< on a whole path
/// Additional looks for each pair of shapes on each edge; most pairs need one.
constexpr double kVerifyLooks = 4;

/// The widths [m] that the interval of a clearance is narrowed to in turn where a narrower one is
/// asked for, each a tenth of the one before.
constexpr double kVerifyWidest = 1e-3;
constexpr double kVerifyNarrowest = 1e-8;
/// And the looks and the cost that this may take, about 5 s.
constexpr long kVerifyRefineWork = 1'000'000;
constexpr std::int64_t kVerifyRefineCost = 5'000'000'000;

/// The verifier replaces a ball around a part of a cloud by its parts if its radius exceeds this
/// share of its distance, and the certified clearance would depend on the ball. Smaller bounds are
/// tighter and slower.
constexpr double kVerifyCoarse = 0.1;

/// Limits on the work of the distances in these looks [units of collision::Work]. They take as long
/// as the looks if each look is a depth of meshes that takes milliseconds.
constexpr std::int64_t kVerifyPairCost = 4'000'000'000;
constexpr std::int64_t kVerifyOpenCost = 160'000'000;
constexpr std::int64_t kVerifyCost = 80'000'000'000;

}  // namespace leeway::planner
