#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/constraint_result.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/wish_result.h"

namespace leeway::planner {

enum class PlanStatus : unsigned char {
  kSolved,
  kUnsolved,
  kPartial,  ///< a line of a task ends early: the path is what there is of the task until then
  kInvalidStart,
  kInvalidGoal,
  kNothingChecked,  ///< no pair of shapes is checked: no path could be proven
  kNotCompiled,  ///< compiling took longer than the time limit, or was stopped: nothing was tried
};
/// "solved", "unsolved", "partial", "invalid_start", "invalid_goal", "nothing_checked",
/// "not_compiled"
const char* toString(PlanStatus status);

/// The stretch of a task's path that is one of Problem::steps.
struct PathStep {
  std::string name;
  int first = 0, last = 0;  ///< waypoints; the same where nothing moves
  /// Lines: proven bounds, at any time, on the distance of the frame's origin from its place on the
  /// line [m], and on the angle between the frame and its rotation there [rad].
  double deviation = 0, turn = 0;
  /// Lines: the place of each of the step's waypoints on the line. The line begins at place 0; its
  /// pose number k, from 1, is at place k. Between waypoints the place moves at a constant rate.
  std::vector<double> places = {};
};

/// Where a line ends early, and why.
struct LineEnd {
  enum class Why : unsigned char {
    kLimit,        ///< a joint is at its limit
    kSingularity,  ///< the joints would have to jump, or the frame is out of reach
    kCollision,    ///< margins are not kept, or not proven to be
  };
  int step = 0;      ///< of Problem::steps
  int waypoint = 0;  ///< the first of the line's poses that is not reached
  double share = 0;  ///< of the way to that one, how much is left behind, in [0, 1)
  Why why = Why::kLimit;
  std::string
      text;  ///< "after 0.31 of the way to pose 2 of 5 (...): joint 'elbow' is at its limit"
};
/// "limit", "singularity", "collision"
const char* toString(LineEnd::Why why);

/// A path in the space of a group: rows of planned variables, with straight lines between them. A
/// continuous joint that goes from 3 to -3 turns by 6 rad, through 0; where it is to go the shorter
/// way, unwrapped() (configuration_space.h) gives rows that say so. Orientations turn at a constant
/// rate.
struct Path {
  std::vector<std::string> names;              ///< variable names, in group order
  std::vector<std::vector<double>> positions;  ///< one row a waypoint
  std::vector<PathStep> steps = {};            ///< of a task, in their order; else empty
};

/// A path whose every edge is one of the space, on which circles go the shorter way.
struct PathEdges {
  /// Those of the path with points added where a line is longer than an edge.
  Path path;
  struct Place {
    int segment;    ///< of the path
    double t0, t1;  ///< of that segment, in [0, 1]
    double along(double t) const { return t0 + t * (t1 - t0); }
  };
  std::vector<Place> places;  ///< one an edge
};
/// The edges that go along a path's lines. Throws std::invalid_argument for rows that are not as
/// long as the space, and for continuous joints beyond 1000 rad that turn by more than half a turn.
/// O(edges).
PathEdges edgesOf(const ConfigurationSpace& space, const Path& path);

/// The clearance of a whole path from something, and where it is least.
struct PathClearance {
  Interval clearance;  ///< [m]; (inf, inf) where there is nothing to be near
  std::string closest_a, closest_b;
  int closest_segment = -1;  ///< -1: nothing is near
  double closest_t = 0;
  Eigen::Vector3d closest_point_a = Eigen::Vector3d::Zero();  ///< on closest_a, world [m]
  Eigen::Vector3d closest_point_b = Eigen::Vector3d::Zero();
};

/// The proof that comes with a path: an interval of the clearance for every edge. Clearances are
/// over the pairs that are checked, see CompiledScene: of all pairs, of those with the world, and
/// of those of the robot with itself and what it holds.
struct Certificate : PathClearance {
  PathClearance world, self;
  /// One an edge [m]. Under CertificateDetail::kPath an upper end may be infinity: not looked for.
  std::vector<Interval> segments;
  bool certified = false;                     ///< every edge proven to keep its margins
  std::vector<UncheckedPairs> unchecked;      ///< pairs that it does not speak of
  std::vector<ConstraintResult> constraints;  ///< one each, in the problem's order
};

/// kPath: the path's clearance to three tenths of itself, or as near as a millisecond of counted
/// work allows. kEveryEdge: each edge's to within the tolerance, whatever it takes; always so where
/// clearance is the objective.
enum class CertificateDetail : unsigned char { kPath, kEveryEdge };

struct PlanOptions {
  std::function<bool()> stop;  ///< called often; true ends the run
  std::function<void(const std::string& phase, double elapsed_s)> progress;
  double clearance_tolerance = 1e-4;  ///< of the certificate [m], above 0
  CertificateDetail detail = CertificateDetail::kPath;
  /// Called with both ends of every edge that Connect finds free while it searches (of several
  /// searches side by side: the first), or that is in the graph of an OMPL planner when a run of it
  /// ends. From one thread at a time.
  std::function<void(std::span<const double>, std::span<const double>)> on_edge;
  /// Called with the waypoints and the length of each better path while Connect improves one, the
  /// first included. Its edges are certified; it is not pushed yet, and has no certificate.
  std::function<void(const std::vector<std::vector<double>>&, double)> on_path;
};

/// A pair of bodies that was in the way of edges.
struct BlockedPair {
  std::string a, b;
  std::uint64_t edges = 0;  ///< that were not proven free because of it
};

/// Two points that a search could not join: of what is reached from the start, and of what reaches
/// a goal.
struct SearchGap {
  double distance = std::numeric_limits<double>::infinity();  ///< in the space's distance
  std::vector<double> from, to;  ///< one number a planned variable; empty: nothing is known
};

struct PlanResult {
  PlanStatus status = PlanStatus::kUnsolved;
  std::uint64_t seed = 0;
  std::string planner;
  bool deterministic = true;  ///< false for planners with threads or clocks of their own
  double compile_s = 0, plan_s = 0, simplify_s = 0, improve_s = 0, push_s = 0, certify_s = 0;
  /// `iterations`: calls of the planner's termination condition, one a turn of its main loop; an
  /// iteration limit counts these.
  std::uint64_t iterations = 0, states = 0, edges = 0, distance_queries = 0;
  /// Edges that were neither proven free nor in contact, mostly for their work limit; the search
  /// goes without them.
  std::uint64_t undecided_edges = 0;
  Path path;                        ///< empty unless solved or partial
  std::optional<LineEnd> line_end;  ///< why a task failed, where a line ends early
  int goal = -1;                    ///< index of the goal reached
  double length = 0;                ///< in the space's distance
  /// MaximumClearance::at_most_longer: length of the shortest path that was found; otherwise
  /// infinity.
  double shortest_length = std::numeric_limits<double>::infinity();
  /// MaximumClearance: no path has more than that, because its start or its goals have not [m].
  double clearance_bound = std::numeric_limits<double>::infinity();
  /// What the path costs where the problem has a MinimumCost or wishes, weights included: an
  /// interval that holds it, 1 % of its upper end wide, or 1e-5 of the length times weights, where
  /// a second of counted work is enough for that. Otherwise of infinities.
  Interval cost{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::vector<WishResult> wishes;  ///< one each, in their order; empty unless solved
  Certificate certificate;
  StateCheck offending;  ///< for an invalid start or goal: pair, depth, place
  std::string offending_a, offending_b;
  /// For an invalid goal of poses that no configuration was found for, a task that failed,
  /// kNothingChecked and kNotCompiled: so in words. `offending` then says nothing.
  std::string reason;
  bool unreachable = false;  ///< that there is none is proven
  /// Unsolved: the pairs that were in the way of most edges, in falling order, kMostBlocked at
  /// most; of a task in the step that failed.
  std::vector<BlockedPair> blocked;
  static constexpr std::size_t kMostBlocked = 10;
  /// Unsolved, by Connect: how near its two trees came, of the points that it tried to join.
  SearchGap gap;
  /// Unsolved: planned revolute joints whose limits bar the shorter turn from the start to every
  /// goal that is given by joints.
  std::vector<std::string> long_turns;
  /// Margins and objects that have no effect; goals left out.
  std::vector<std::string> warnings;
};

/// Compiles, plans, simplifies, certifies. Throws robots::InputError as validate() does, and for a
/// problem without goals, with steps, or with a planned variable that has no limits.
///
/// Solved means that every edge of the path as returned is proven to keep its margins. The limits
/// hold for planning and simplification together, counted from the end of compilation; that may
/// take as long as the time limit, and ten seconds at least. Once options.stop says so, either
/// ends. A planner that gives up early is started again with other seeds, until the limits.
///
/// Where no pair of shapes is checked nothing is planned (CompiledScene::nothingChecked()).
/// A start that is not proven valid, or no valid goal, ends the call; the result says what is in
/// the way. Of several goals the invalid ones are left out with a warning. Of a goal range points
/// are drawn; it counts as invalid when a thousand of them are. Of a goal of poses configurations
/// are drawn, nearest to the start first; where no straight edge leads to the first valid ones,
/// more are drawn, and the search goes to any of them.
///
/// MinimumLength: a free straight edge to the nearest goal is the answer, without a planner.
/// Planners that optimise run until the limits, others stop at their first path.
/// MaximumClearance: planners that optimise maximise the least clearance along the path, their
/// edges' costs being certified bounds; the others, Connect among them, are run again and again
/// with rising margins, which climbs faster. Both end early when start or goal have no more
/// clearance than the path. Simplification keeps the clearance that was reached.
/// MinimumCost, and MinimumLength with wishes: planners that optimise minimise certified upper ends
/// of their edges' costs; of the others first paths are taken again and again. All paths are then
/// moved and cut as long as that lowers the cost that is proven. Refused are wishes beside
/// MaximumClearance, and planners that cannot minimise such costs, see PlannerTraits::costs.
///
/// The same problem, seed and iteration limit give the same bytes, except for times. This holds for
/// deterministic planners (see PlannerTraits), and while no other thread makes generators of OMPL
/// outside this library. A time limit only cuts such a run short.
PlanResult plan(const Problem& problem, const PlanOptions& options = {});
/// plan() in a scene that is already compiled from `problem`, or in a variant of it. Refuses
/// (robots::InputError) a problem that has changed since in what was compiled, naming what differs:
/// CompiledScene::differenceFrom(), O(things of the world). Start, goals, objective, planner,
/// limits and seed may be others.
PlanResult plan(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
                const PlanOptions& options = {});

/// The problem with a start for its start_poses: of the configurations that inverse kinematics
/// finds for them the valid one nearest to `start` in the space's distance, and of a task that
/// begins with a line, the one from which it goes on longest; without a valid one the nearest, and
/// without any the problem is refused (robots::InputError), as by validate(). Deterministic. The
/// problem itself without start_poses. Compiles the problem.
Problem placeStart(const Problem& problem);

/// The certificate of any path, its clearances to within tolerance [m]. `world_guess`: a clearance
/// from the world that the path is likely to keep [m]; asked for first, believed only when proven.
Certificate certify(EdgeCertifier& certifier, const Path& path, double tolerance,
                    CertificateDetail detail = CertificateDetail::kEveryEdge,
                    double world_guess = 0);

/// Returns what is proven about each constraint of a problem along a path; nothing if one of them
/// is not proven everywhere. `scene`: the problem's, or a variant. Errors as edgesOf(). O(edges *
/// constraints * joints), more where an edge is long.
std::optional<std::vector<ConstraintResult>> proveConstraints(const CompiledScene& scene,
                                                              const Problem& problem,
                                                              const Path& path);

}  // namespace leeway::planner
