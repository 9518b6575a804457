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
  kPartial,  ///< a line of a task ends early: the path has the task up to there
  kInvalidStart,
  kInvalidGoal,
  kNothingChecked,  ///< no pair of shapes is checked: no path could be proven
  kNotCompiled,     ///< compiling exceeded the time limit, or was stopped: nothing was planned
};
/// "solved", "unsolved", "partial", "invalid_start", "invalid_goal", "nothing_checked",
/// "not_compiled"
const char* toString(PlanStatus status);

/// The stretch of a task's path for one of Problem::steps.
struct PathStep {
  std::string name;
  int first = 0, last = 0;  ///< waypoints; the same if nothing moves
  /// For lines: bounds that are proven for any time, on the distance of the frame's origin from its
  /// place on the line [m], and on the angle between the frame and its rotation there [rad].
  double deviation = 0, turn = 0;
  /// For lines: the place of each of the step's waypoints on the line. The line begins at place 0,
  /// and its pose number k, from 1, is at place k. Between waypoints the place changes at a
  /// constant rate.
  std::vector<double> places = {};
};

/// Where a line ends early, and why.
struct LineEnd {
  enum class Why : unsigned char {
    kLimit,        ///< a joint is at its limit
    kSingularity,  ///< the joints would have to jump, or the frame is out of reach
    kCollision,    ///< margins are broken, or not proven to be kept
    kStopped,      ///< the time limit was reached, or the caller ended it
  };
  int step = 0;      ///< of Problem::steps
  int waypoint = 0;  ///< the first of the line's poses that is not reached
  double share = 0;  ///< share of the way to that pose that was completed, in [0, 1)
  Why why = Why::kLimit;
  std::string
      text;  ///< "after 0.31 of the way to pose 2 of 5 (...): joint 'elbow' is at its limit"
};
/// "limit", "singularity", "collision", "stopped"
const char* toString(LineEnd::Why why);

/// A path in the space of a group: rows of planned variables, with straight lines between them. A
/// continuous joint that goes from 3 to -3 turns by 6 rad, through 0. To go the shorter way, use
/// the rows of unwrapped() (configuration_space.h). Orientations turn at a constant rate.
struct Path {
  std::vector<std::string> names;              ///< variable names, in group order
  std::vector<std::vector<double>> positions;  ///< one row per waypoint
  std::vector<PathStep> steps = {};            ///< of a task, in their order; else empty
  /// Empty: lines between rows. Otherwise a timed motion, which blends corners: each row's time,
  /// rising [s], and velocity. Between two rows each variable moves on the cubic polynomial through
  /// its positions and velocities at both. verify() proves these cubics; nothing else accepts them.
  std::vector<double> times = {};
  std::vector<std::vector<double>> velocities = {};  ///< as `times`
};

/// A path that consists of edges of the space, in which circles go the shorter way.
struct PathEdges {
  /// The points of the path, with more points where a line is longer than an edge.
  Path path;
  struct Place {
    int segment;    ///< of the path
    double t0, t1;  ///< of that segment, in [0, 1]
    double along(double t) const { return t0 + t * (t1 - t0); }
  };
  std::vector<Place> places;  ///< one per edge
};
/// Returns the edges along a path's lines. Throws std::invalid_argument for a path with times, for
/// columns with other names than the space's variables, steps without rows, rows whose length is
/// not that of the space, and for continuous joints beyond 1000 rad that turn by more than half a
/// turn. O(edges).
PathEdges edgesOf(const ConfigurationSpace& space, const Path& path);

/// The clearance of a whole path for some pairs, and the place where it is least.
struct PathClearance {
  Interval clearance;  ///< [m]; (inf, inf) if nothing is near
  std::string closest_a, closest_b;
  int closest_segment = -1;  ///< -1: nothing is near
  double closest_t = 0;
  Eigen::Vector3d closest_point_a = Eigen::Vector3d::Zero();  ///< on closest_a, world [m]
  Eigen::Vector3d closest_point_b = Eigen::Vector3d::Zero();
};

/// The proof that comes with a path: an interval of the clearance for every edge. Clearances cover
/// the checked pairs (see CompiledScene): all of them, those with the world, and those of the robot
/// with itself, including attached objects.
struct Certificate : PathClearance {
  PathClearance world, self;
  /// One per edge [m]. With CertificateDetail::kPath, an upper bound may be infinity: not computed.
  std::vector<Interval> segments;
  bool certified = false;                     ///< every edge proven to keep its margins
  std::vector<UncheckedPairs> unchecked;      ///< pairs that it does not cover
  std::vector<ConstraintResult> constraints;  ///< one per constraint, in the problem's order
  Margins margins;                            ///< of the problem, which the edges keep
  /// "sampled": Problem::condition holds at the sampled states, and is not proven between them.
  /// Empty if the problem has no condition.
  std::string conditions;
};

/// kPath: the path's clearance to within three tenths of its value, or as well as about a
/// millisecond of counted work allows. kEveryEdge: the clearance of each edge to within the
/// tolerance, with any amount of work. The objective clearance always uses kEveryEdge.
enum class CertificateDetail : unsigned char { kPath, kEveryEdge };

struct PlanOptions {
  std::function<bool()> stop;  ///< called often; true ends the run
  std::function<void(const std::string& phase, double elapsed_s)> progress;
  double clearance_tolerance = 1e-4;  ///< of the certificate [m], above 0
  CertificateDetail detail = CertificateDetail::kPath;
  /// Called with both ends of every edge that Connect finds free during its search (only for the
  /// first of several parallel searches), or that is in the graph of an OMPL planner when its run
  /// ends. Only one thread calls it at a time.
  std::function<void(std::span<const double>, std::span<const double>)> on_edge;
  /// Called with the waypoints and the length of the first path and of each better one while
  /// Connect improves it. Its edges are certified, but it is not pushed and has no certificate yet.
  std::function<void(const std::vector<std::vector<double>>&, double)> on_path;
};

/// A pair of bodies that blocked edges.
struct BlockedPair {
  std::string a, b;
  std::uint64_t edges = 0;  ///< edges that were not proven free because of it
};

/// Two points that a search could not join: one is reached from the start, a goal is reached from
/// the other.
struct SearchGap {
  double distance = std::numeric_limits<double>::infinity();  ///< in the space's distance
  std::vector<double> from, to;  ///< one number per planned variable; empty if unknown
};

struct PlanResult {
  PlanStatus status = PlanStatus::kUnsolved;
  std::uint64_t seed = 0;
  std::string planner;
  bool deterministic = true;  ///< false for planners with their own threads or clocks
  double compile_s = 0, plan_s = 0, simplify_s = 0, improve_s = 0, push_s = 0, certify_s = 0;
  /// `iterations` counts calls of the planner's termination condition, one per turn of its main
  /// loop. The iteration limit refers to this count.
  std::uint64_t iterations = 0, states = 0, edges = 0, distance_queries = 0;
  /// Edges that were neither proven free nor found in contact, usually because of their work limit.
  /// The search does not use them.
  std::uint64_t undecided_edges = 0;
  Path path;                        ///< empty unless solved or partial
  std::optional<LineEnd> line_end;  ///< why a task failed, if a line ends early
  int goal = -1;                    ///< index of the goal reached
  double length = 0;                ///< in the space's distance
  /// With MaximumClearance::at_most_longer: the length of the shortest path that was found;
  /// otherwise infinity.
  double shortest_length = std::numeric_limits<double>::infinity();
  /// With MaximumClearance: no path has more clearance, because its start or its goals do not [m].
  double clearance_bound = std::numeric_limits<double>::infinity();
  /// The path's cost, including weights, if the problem has a MinimumCost or wishes. The interval
  /// contains the true cost. Its width is 1 % of its upper bound, or 1e-5 of the length times the
  /// weights, if a second of counted work suffices for that. Without a cost, both bounds are
  /// infinite.
  Interval cost{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::vector<WishResult> wishes;  ///< one per wish, in their order; empty unless solved
  Certificate certificate;
  StateCheck offending;  ///< for an invalid start or goal: pair, depth, place
  std::string offending_a, offending_b;
  /// The fault in words for an invalid goal of poses without a configuration, a task that failed,
  /// kNothingChecked and kNotCompiled. `offending` is then empty.
  std::string reason;
  bool unreachable = false;  ///< it is proven that no configuration exists
  /// Unsolved: the pairs that blocked most edges, in falling order, at most kMostBlocked of them.
  /// For a task, those of the step that failed.
  std::vector<BlockedPair> blocked;
  static constexpr std::size_t kMostBlocked = 10;
  /// Unsolved by Connect: how near its two trees came, of all points that it tried to join.
  SearchGap gap;
  /// Unsolved: planned revolute joints whose limits block the shorter turn from the start to every
  /// goal that is given by joints.
  std::vector<std::string> long_turns;
  /// Warnings of the loaders of robot and problem; margins and objects that have no effect; goals
  /// left out.
  std::vector<std::string> warnings;
};

/// Compiles, plans, simplifies and certifies. Throws robots::InputError as validate(), and for a
/// problem without goals, with steps, or with a planned variable without limits.
///
/// Solved means that every edge of the returned path is proven to keep its margins. The limits
/// apply to planning and simplification together, counted from the end of compilation. Compilation
/// may take the time limit, but at least ten seconds. options.stop ends either. A planner that
/// gives up early is started again with other seeds until the limits are reached.
///
/// If no pair of shapes is checked, nothing is planned (CompiledScene::nothingChecked()). If the
/// start is not proven valid or no goal is valid, the call ends, and the result names the obstacle.
/// Invalid goals among several are left out with a warning. For a goal range, points are drawn;
/// the range counts as invalid if a thousand of them are. For a goal of poses, configurations are
/// drawn, nearest to the start first. If no straight edge leads to the first valid ones, more are
/// drawn, and the search may reach any of them.
///
/// MinimumLength: a free straight edge to the nearest goal is the answer, without a planner.
/// Planners that optimise run until the limits; others stop at their first path.
/// MaximumClearance: planners that optimise maximise the least clearance along the path, with
/// certified bounds as costs of edges. Other planners, Connect among them, run repeatedly with
/// rising margins, which is faster. Both end early if start or goal have no more clearance than the
/// path. Simplification keeps the clearance that was reached.
/// MinimumCost, and MinimumLength with wishes: planners that optimise minimise certified upper
/// bounds of the costs of edges. Other planners find first paths repeatedly. All paths are then
/// moved and cut as long as this lowers the proven cost. Wishes together with MaximumClearance are
/// refused, and so are planners that cannot minimise such costs, see PlannerTraits::costs.
///
/// The same problem, seed and iteration limit give the same bytes, except for times. This holds for
/// deterministic planners (see PlannerTraits), and if no other thread makes generators of OMPL
/// outside this library. A time limit only ends such a run earlier.
PlanResult plan(const Problem& problem, const PlanOptions& options = {});
/// plan() in a scene that was already compiled from `problem`, or in a variant of it. Throws
/// robots::InputError, with the difference, if the compiled parts of the problem have changed since
/// (CompiledScene::differenceFrom()). O(things of the world). Start, goals, objective, planner,
/// limits and seed may differ.
PlanResult plan(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
                const PlanOptions& options = {});

/// Returns the problem with a start for its start_poses. It is the valid one of the configurations
/// from inverse kinematics that is nearest to `start` in the space's distance. If a task begins
/// with a line, it is the one from which the line can be followed farthest. Without a valid one, it
/// is the nearest one. Throws robots::InputError if inverse kinematics finds none, and as
/// validate() does. Without start_poses, returns the problem itself. Deterministic, unless the
/// search for the longest line is cut short: after half of the problem's time limit, or once
/// `stop`, which may be empty, returns true. Compiles the problem.
Problem placeStart(const Problem& problem, const std::function<bool()>& stop = {});

/// Returns the certificate of any path, with clearances to within the tolerance [m]. `world_guess`:
/// a clearance from the world that the path probably keeps [m]; it is tried first, and counts only
/// if proven.
Certificate certify(EdgeCertifier& certifier, const Path& path, double tolerance,
                    CertificateDetail detail = CertificateDetail::kEveryEdge,
                    double world_guess = 0);

/// Returns the proven bounds of each constraint of a problem along a path; nothing if one of them
/// is not proven everywhere, or the condition does not hold at a state that is looked at. `scene`:
/// the problem's, or a variant. Errors as edgesOf(). O(edges * constraints * joints), more for long
/// edges.
std::optional<std::vector<ConstraintResult>> proveConstraints(const CompiledScene& scene,
                                                              const Problem& problem,
                                                              const Path& path);

/// Returns in words which constraint of a problem does not hold at a point, or that its condition
/// does not: "constraint 'upright': 'glass' is turned by 0.3 rad, at most ..."; empty where all
/// hold. `scene` as above. O(constraints * joints).
std::string brokenConstraint(const CompiledScene& scene, const Problem& problem,
                             std::span<const double> point);

}  // namespace leeway::planner
