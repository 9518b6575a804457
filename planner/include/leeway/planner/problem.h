#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/pose_motion.h"
#include "leeway/collision/vertex_motion.h"
#include "leeway/planner/point_cloud.h"
#include "leeway/robots/model.h"
#include "leeway/robots/pose_region.h"

namespace leeway::planner {

/// How an object of the world moves, as far as that is known.
struct ObjectMotion {
  /// Its poses at all times; null: it was only seen, at Object::X_WO.
  std::shared_ptr<const collision::PoseMotion> poses = nullptr;
  /// Bounds on the speed of its frame's origin [m/s] and on its turning [rad/s] after it was seen.
  /// For a cloud, speed_bound bounds the speed of its points, and turn_bound may be left out.
  double speed_bound = std::numeric_limits<double>::infinity();
  double turn_bound = std::numeric_limits<double>::infinity();
  /// How long before Execution::start it was seen at X_WO [s]; 0 with `poses`.
  double age = 0;
  /// The Execution::start that `age` counts back from [s], which movingObject() sets; empty: that
  /// of any problem.
  std::optional<double> start = {};
};

/// A named body with a shape: an obstacle, or an object that a link holds.
struct Object {
  std::string name;
  /// Empty: only a name, which margins and contacts may use before CompiledScene::withObjects()
  /// adds the object itself.
  std::vector<robots::Geometry> geometries;
  robots::Pose X_WO;
  /// Balls that also belong to it, in its frame; null without a cloud. Only objects of the world
  /// may have a cloud, attached objects have shapes.
  std::shared_ptr<const PointCloud> cloud = nullptr;
  /// Null: it stands still. Only an object of the world moves; see movingObject(). Replanner and
  /// Guard follow it. Everything else takes it as it stands at Execution::start, or where it was
  /// seen last before that.
  std::shared_ptr<const ObjectMotion> motion = nullptr;
  /// Red, green and blue, 0 to 1, in pages and pictures. Without a color, these choose one.
  std::optional<std::array<double, 3>> color = {};
};

/// Returns the object with a motion from `time` [s] on, which must be the problem's
/// Execution::start. With `motion.poses` it stands where these have it then. Throws
/// std::invalid_argument for an object without shapes, with a half-space, or with a cloud that was
/// cropped or carved for its place, and for numbers that make no sense.
Object movingObject(Object object, const ObjectMotion& motion, double time = 0);

/// An object held by a link from the start. It moves with the link, and may touch only the link and
/// `touch_links`.
struct Attachment {
  Object object;  ///< X_WO is unused
  int link = -1;
  robots::Pose X_LO;
  std::vector<int> touch_links;
};

/// A named frame fixed to a link, for poses: a tool's tip.
struct Frame {
  std::string name;
  int link = -1;
  robots::Pose X_LF;
};

/// The robot, and its planned variables.
struct PlannedRobot {
  std::shared_ptr<const robots::Model> model;
  std::vector<int> variables;  ///< planned ones, in group order
  std::vector<Attachment> attachments;
  std::vector<Frame> frames;
};

/// A condition on the pose of a frame F in a reference frame R. It is proven everywhere on a path,
/// as margins are. Names are those of FramePose.
struct Constraint {
  /// The condition on F's rotation.
  enum class Turn : unsigned char {
    kAny,    ///< none
    kFixed,  ///< `rotation`, to within `angle`
    kAxis,   ///< `axis` points along `direction`, to within `angle`
  };
  static constexpr std::pair<double, double> kFree{-std::numeric_limits<double>::infinity(),
                                                   std::numeric_limits<double>::infinity()};

  std::string name;   ///< in messages
  std::string frame;  ///< a frame, a link or an attached object
  /// An object, a frame, a link or an attached object; empty: the world. It may move with the
  /// planned joints, too: what one hand holds is seen from the other one.
  std::string relative_to;
  robots::Pose X_SR;  ///< of R in the frame S of that name
  /// F's origin in R [m]: a box, or a plane or line if ranges have no width.
  std::array<std::pair<double, double>, 3> position{kFree, kFree, kFree};
  double position_tolerance = 1e-3;  ///< how far outside of the box the origin may be [m]
  Turn turn = Turn::kAny;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R_RF
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();         ///< in F, of any length
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();    ///< in R, of any length
  double angle = 1e-2;                                     ///< [rad]
};

/// Keeps a frame upright: the constraint that `axis` of the frame points along the world's z to
/// within `angle` [rad].
Constraint upright(const std::string& frame, const Eigen::Vector3d& axis, double angle);

/// A condition of your own on the states of a path: looked at, not proven.
struct Condition {
  /// Returns whether all of these states are accepted: one row of the planned variables after the
  /// other, 256 rows at most. The same answer for the same states is expected. Called from several
  /// threads if Connect has several workers. Empty if the problem has no condition.
  std::function<bool(std::span<const double> states)> accept;
  /// From one state that is sampled on an edge, its ends included, to the next no variable changes
  /// by more, and no orientation turns by more [rad or m]. Above 0.
  double resolution = 0.05;
};

/// The places where a frame F may be in a reference frame R. poseRegion() resolves the names.
struct FramePose {
  std::string frame;        ///< a frame, a link or an attached object
  std::string relative_to;  ///< an object, or a frame or link at rest; empty, "world": the world
  std::array<std::pair<double, double>, 3> position;  ///< of F's origin in R [m]
  /// R_RF = Rz(yaw) Ry(pitch) Rx(roll) rotation [rad]. 2 pi wide or more: any angle.
  std::array<std::pair<double, double>, 3> rpy;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double position_tolerance = 1e-9;  ///< how far outside a solution may be [m]
  double angle_tolerance = 1e-9;     ///< [rad]
};

/// A goal: either a range for every planned variable (a single value is a range without width), or
/// poses of frames. The poses must hold together, with all variables within their limits.
struct Goal {
  std::string name;                               ///< group state, or "goal", "goal 2", ...
  std::vector<std::pair<double, double>> ranges;  ///< in group order; empty with poses
  std::vector<robots::PoseRegion> poses = {};
};

/// Moves to a goal on any path.
struct MoveStep {
  Goal goal;                     ///< of joints, or given by:
  std::vector<FramePose> poses;  ///< resolved when the step begins; empty: use `goal`
};

/// A place on a frame's way.
struct Waypoint {
  Eigen::Vector3d position;  ///< of the frame's origin [m]
  /// The frame's rotation; nothing: as at the place before.
  std::optional<Eigen::Matrix3d> rotation = {};
  /// The origin moves there on the circle's arc through this point; nothing: on a straight line.
  std::optional<Eigen::Vector3d> via = {};
};

/// Moves a frame along lines or arcs. On each, it turns about one axis, and both at a constant
/// rate.
struct LineStep {
  std::string frame;                             ///< a frame, a link or an attached object
  Eigen::Vector3d by = Eigen::Vector3d::Zero();  ///< from where it is [m]; 0 with `poses`
  /// The frame in which `by`, `turn` and `poses` are given: a name as in FramePose, or "world".
  /// Empty: the frame's own axes for `by` and `turn`, the world for `poses`.
  std::string relative_to;
  /// Proven for every time of the motion: the greatest distance of the origin from its place on the
  /// line [m], and the greatest angle between the frame and its rotation there [rad].
  double position_tolerance = 1e-3, angle_tolerance = 1e-2;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< in addition to `by`: how the frame turns
  std::vector<Waypoint> poses = {};  ///< instead of `by`: the places to pass, in order
  /// The greatest speed of the frame's origin on the trajectory, proven [m/s]. Limits of joints
  /// hold as well.
  double speed = std::numeric_limits<double>::infinity();
};

/// Attaches an object to a link where it is; see attachObject().
struct AttachStep {
  std::string object, link;
  std::vector<std::string> touch;  ///< other links that may touch it
};

/// Detaches an object, which stays where it is; see detachObject().
struct DetachStep {
  std::string object;
};

/// A part of a task (task.h).
struct Step {
  std::string name;  ///< "move", "line 2", ...
  std::variant<MoveStep, LineStep, AttachStep, DetachStep> action;
  /// Pairs that may touch during this step, in addition to those of the problem.
  std::vector<std::pair<std::string, std::string>> allowed;
};

/// An obstacle whose vertices move. Made by makeDeformingObstacle(). Plans, checks and proofs use
/// `object`; Replanner follows `motion` from there.
struct DeformingObstacle {
  /// The obstacle at Execution::start: its geometry is a snapshot of `mesh`.
  Object object;
  std::shared_ptr<const collision::DeformableMesh> mesh;
  /// Null: the embedding program gives the vertices.
  std::shared_ptr<const collision::VertexMotion> motion;
  /// Bound on the vertices' speed when their future is unknown [m/s]. Infinite: the motion's own
  /// bound; without a motion, no bound.
  double speed_bound = std::numeric_limits<double>::infinity();
  collision::DeformOptions options;
};

/// Returns a deforming obstacle as it is at `time` [s], which must be the problem's
/// Execution::start, with its frame at X_WO. Throws std::invalid_argument for a missing mesh, a
/// strategy that the motion does not support, a motion with another number of vertices than the
/// mesh, vertices that are not finite, and invalid options or speed bounds. O(triangles) and the
/// build of a tree.
DeformingObstacle makeDeformingObstacle(
    std::string name, std::shared_ptr<const collision::DeformableMesh> mesh,
    std::shared_ptr<const collision::VertexMotion> motion, const robots::Pose& X_WO,
    double time = 0, const collision::DeformOptions& options = {},
    double speed_bound = std::numeric_limits<double>::infinity());

/// The robot's surroundings. Links, objects, deforming obstacles and attached objects must have
/// different names.
struct World {
  std::vector<Object> objects;  ///< rigid
  std::vector<DeformingObstacle> deforming;
};

/// Pairs that need no check, and links that do. Names are those of links, objects and attached
/// objects.
struct Contacts {
  std::vector<std::pair<std::string, std::string>> allowed;  ///< may touch; adds to the SRDF's
  /// `allowed` replaces the SRDF's pairs: all other pairs are checked even if the SRDF disables
  /// them. Set by MoveIt's matrix.
  bool replace_srdf = false;
  /// Pairs of links that are checked although a joint connects them, the SRDF disables them or they
  /// touch in every configuration. Not also in `allowed`.
  std::vector<std::pair<std::string, std::string>> checked = {};
};

/// The margin of one pair. Names as in Contacts. "robot" also stands for all links and attached
/// objects, and "world" for all objects and deforming obstacles, including those added later. The
/// words lose this meaning if a link with shapes has such a name; objects and frames may not.
struct PairMargin {
  std::string a, b;
  double margin;  ///< [m]
  /// Pairs from one group have the same text here, such as "robot and table". If none of them is
  /// checked, there is one warning for all.
  std::string group = {};
};

/// A clearance that pairs keep if it does not cost too much. With the objectives length and cost, a
/// path that does not keep it has an additional cost of
///   weight * integral of max(0, 1 - d / clearance) over the path's length,
/// where d is the least separation of the pairs, or 0 if that is negative. With a weight of 1, the
/// cost of a stretch doubles at contact.
struct Wish {
  std::string name;                                        ///< "robot and people"
  std::vector<std::pair<std::string, std::string>> pairs;  ///< names as in Contacts
  double clearance = 0;                                    ///< [m], above 0
  double weight = 1;                                       ///< above 0
};

/// The separation that checked pairs keep: every pair is farther apart than its margin. A negative
/// margin lets bodies overlap by its size.
struct Margins {
  double common = 0;              ///< of pairs without their own margin [m]
  std::vector<PairMargin> pairs;  ///< for a pair, the last entry with it wins
  std::vector<Wish> wishes;       ///< all count, even for the same pair
};

/// Which pairs count for a clearance. Attached objects and links at rest belong to the robot.
enum class Pairs : unsigned char {
  kAll,
  kWorld,  ///< of the robot and something else
  kSelf,   ///< of two parts of the robot
};

/// The shortest path, in the space's distance.
struct MinimumLength {
  /// The clearance of pairs with the world, in addition to their margins [m].
  double clearance = -std::numeric_limits<double>::infinity();
};
/// The path with the largest least clearance.
struct MaximumClearance {
  Pairs of = Pairs::kWorld;  ///< the others keep their margins
  /// How much longer the path may be than the shortest path that is found, as a share of its
  /// length.
  double at_most_longer = std::numeric_limits<double>::infinity();
};
/// The cost of nearness, from 0 to 1. It never increases with the clearance d. A negative d counts
/// as 0.
struct Nearness {
  enum class Kind : unsigned char {
    kHinge,    ///< max(0, 1 - d / distance)
    kInverse,  ///< min(1, distance / d)
  };
  Kind kind = Kind::kHinge;
  double distance = 0.1;  ///< [m], above 0
};
/// One term of a path's cost.
struct CostTerm {
  Nearness nearness;
  double weight = 1;  ///< 0 or more
  /// Use the greatest nearness along the path instead of its integral over the path's length (in
  /// the space's distance).
  bool worst = false;
  Pairs of = Pairs::kWorld;  ///< the pairs that count; the others keep their margins
};
/// The path with the least weighted sum of its length and terms.
struct MinimumCost {
  double length = 0;  ///< weight of the path's length, 0 or more
  std::vector<CostTerm> terms;
};
/// The planner's objective.
using Objective = std::variant<MinimumLength, MaximumClearance, MinimumCost>;

/// "length", "clearance", "integral" (a cost with integrals only), or "weighted" (other costs).
const char* toString(const Objective& objective);
/// Returns the objective "length" or "clearance"; nothing for other names.
std::optional<Objective> objectiveOfName(std::string_view name);

/// The planner and its settings.
struct PlannerChoice {
  std::string name = "Connect";                   ///< see planners.h
  std::map<std::string, std::string> parameters;  ///< by OMPL's names
  bool simplify = true;                           ///< the path that it finds
  /// With the objective length, pushes a simplified path away from bodies, by up to 8 mm, which
  /// makes it at most 3 % longer. If less than 3 mm are left, searches for another path. With the
  /// objective clearance, pushes the path where it has more than its least clearance.
  bool push = true;
};

/// Limits on planning and simplification together.
struct PlanningLimits {
  double time = 5;              ///< [s]; 0 or infinity: no limit
  std::int64_t iterations = 0;  ///< of the planner; 0: no limit
};

/// What Replanner may assume about deforming obstacles after it last saw them.
enum class Foresight : unsigned char {
  kMotion,      ///< their motion is known
  kSpeedBound,  ///< only a bound on their vertices' speed is known
};

/// The behaviour of a timed path at its corners.
enum class Corners : unsigned char {
  kStop,  ///< comes to rest
  /// Cuts a corner if the cut is proven to keep the margins and what is constrained, else stops.
  /// Always stops where bodies turn freely, between steps, and with a condition.
  kBlend,
};

/// How a path is executed. A trajectory (trajectory.h) and a Replanner, which goes in steps while
/// the scene changes, keep all limits.
struct Execution {
  double start = 0;      ///< time of the obstacles' motions at which execution begins [s]
  double step = 0.05;    ///< between two looks at the world [s]
  double duration = 30;  ///< the execution fails if it reaches no goal within this time [s]
  double speed = 1;      ///< share of the velocity limits that is used, in (0, 1]
  std::map<std::string, double> velocities;  ///< by variable; default: the robot's [rad/s or m/s]
  /// By variable [rad/s^2 or m/s^2]. Default: the robot's own limit, or one that reaches the
  /// velocity limit in half a second.
  std::map<std::string, double> accelerations;
  /// By variable [rad/s^3 or m/s^3]. Default: the robot's own limit, or no limit.
  std::map<std::string, double> jerks;
  double acceleration_scale = 1;  ///< share of the acceleration limits that is used, in (0, 1]
  double jerk_scale = 1;          ///< share of the jerk limits that is used, in (0, 1]
  Corners corners = Corners::kBlend;
  Foresight foresight = Foresight::kMotion;
  /// Replanner prefers steps after which this much more motion or rest can be certified [s].
  double look_ahead = 0.2;
  /// The distance beyond the margin that paths keep from deforming obstacles, so that they stay
  /// valid longer. If no such path is found, a path without it is used [m].
  double buffer = 0.02;
  /// The time to wait with a valid path that cannot be executed now, before planning another one
  /// [s].
  double patience = 0.5;
};

/// Velocity limit of a joint for which the URDF has none [rad/s or m/s].
inline constexpr double kDefaultVelocity = 1;

/// The whole input of a planner. Made by a loader below, or filled by a program in any order,
/// because every function that takes it calls validate().
struct Problem {
  std::string name;
  PlannedRobot robot;
  std::vector<double> start;  ///< all variables of the model, planned or not
  /// A start that is given by poses. placeStart() finds planned variables for them. Empty: use
  /// `start`.
  std::vector<robots::PoseRegion> start_poses;
  std::vector<Goal> goals;  ///< at least one, or
  std::vector<Step> steps;  ///< a task: planTask() (task.h) instead of plan()
  /// Each holds on the whole path, including start and goal. Only with goals, not with steps.
  std::vector<Constraint> constraints;
  Condition condition;  ///< likewise
  World world;
  Contacts contacts;
  Margins margins;
  Objective objective;
  PlannerChoice planner;
  PlanningLimits limits;
  std::uint64_t seed = 1;
  Execution execution;
  /// Warnings of the loader about this problem's own files, each with file and line. Those about
  /// the robot are in robot.model->warnings.
  std::vector<std::string> warnings;
};

/// Throws robots::InputError for the first of these faults. The message has the member, its value
/// and what is expected.
/// - no model; planned variables or links that the model does not have; variables planned twice;
/// - a start of another size, or outside the limits of planned variables; goals or poses that
///   nothing can meet; goals together with steps; steps with names that do not exist;
/// - a name of two things, or an empty name; a name in margins, wishes or contacts that does not
///   exist; a pair that has the same name twice;
/// - constraints of frames that do not move, or that constrain nothing; they or a condition
///   together with steps, another objective than length, or another planner than Connect;
/// - poses that are not finite or not rotations; numbers that are not finite or out of range; a
///   planner or parameters that do not exist or do not fit the objective;
/// - deforming obstacles without a snapshot of Execution::start, objects that do not stand where
///   their motion has them then.
///
/// Goals may be missing, because a scene can be compiled without goals. O(things + pairs of names),
/// about a microsecond for a small problem.
void validate(const Problem& problem);

/// Returns the warnings of the loaders of the robot and of the problem, and those about what a
/// program has added since: meshes that are not closed, joints that are not planned and stand
/// outside their limits. O(warnings * (variables + open meshes)).
std::vector<std::string> problemWarnings(const Problem& problem);

struct ProblemOptions {
  /// Options of robots and meshes. `stop` also ends reading of everything else, and `errors`
  /// collects all errors.
  robots::LoadOptions load;
  /// Whether a file must have a goal, steps or waypoints.
  bool needs_goal = true;
};

/// Reads the project's own YAML (problems/README.md, problems/schema.json). Throws
/// robots::InputError, and robots::Stopped if options.load.stop returns true.
Problem loadProblem(const std::string& yaml_path, const ProblemOptions& options = {});

/// Reads poses of a frame from a file: .csv with columns x, y, z and qx, qy, qz, qw or roll, pitch,
/// yaw; .yaml or .json with a list of poses, or with the contents of `waypoints` in problem files.
/// `frame` may be empty if the file names it. Adds to `warnings` for quaternions that are slightly
/// off unit length. Throws robots::InputError.
LineStep loadWaypoints(const std::string& file, const std::string& frame,
                       std::vector<std::string>& warnings);

/// Reads MoveIt's planning scene and motion plan request, as MotionBenchMaker writes them. Calls
/// may share the model. Throws robots::InputError, robots::Stopped.
Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path, const ProblemOptions& options = {});

/// Reads the world of a scene that MoveIt has saved as text (.scene), without a robot. Adds to
/// `warnings`. Throws robots::InputError, robots::Stopped.
World loadMoveitWorld(const std::string& scene_path, const ProblemOptions& options,
                      std::vector<std::string>& warnings);

/// Returns the robot with the limits of MoveIt's joint_limits.yaml. Velocities, accelerations and
/// jerks replace the robot's own; the lesser of acceleration and deceleration counts. Positions
/// narrow its range (robots::withBounds()). If they are wider, the robot's own range stays, and the
/// model has a warning. A limit of a joint that follows another one limits that one. Throws
/// robots::InputError, robots::Stopped. O(file + joints^2).
std::shared_ptr<const robots::Model> withJointLimits(const robots::Model& model,
                                                     const std::string& yaml_path,
                                                     const robots::LoadOptions& options = {});

/// Allows the pairs of links that are proven to touch with all joints at rest, or at the nearest
/// limit (robots::touchingAtRest(), Variable::rest). They include all pairs that touch everywhere.
/// A warning of the problem names them. Throws robots::InputError for a robot that is missing or
/// lacks its meshes, and robots::Stopped. One distance query per pair of geometries.
void allowTouching(Problem& problem, const robots::Stop& stop = {});

/// Returns a problem without obstacles, from group states or from values of the planned variables
/// such as "0, 1.5". For several groups, "left, right", also from "left=up, right=0 1.5". Throws
/// robots::InputError (without a file) for unknown names and invalid values.
Problem problemFromStates(std::shared_ptr<const robots::Model> model, const std::string& group,
                          const std::string& start, const std::string& goal);

/// Returns the problem with `object` (one of world.objects) attached to `link`, grasped where it is
/// with the robot at `configuration` (all variables of the model; empty: the start). It then moves
/// with the link and may touch it and `touch_links`. Contacts and margins keep its name. Throws
/// robots::InputError as validate(), and std::invalid_argument for unknown names and a
/// configuration of another size.
Problem attachObject(const Problem& problem, const std::string& object, const std::string& link,
                     const std::vector<std::string>& touch_links = {},
                     std::span<const double> configuration = {});

/// Returns the problem with an attached object detached where it is with the robot at
/// `configuration`. The inverse of attachObject(), with the same errors.
Problem detachObject(const Problem& problem, const std::string& object,
                     std::span<const double> configuration = {});

/// Returns the shapes of a link, an object or an attached object, placed in the world by their
/// X_BG, with the robot at `configuration` (all variables of the model; empty: the start). "robot"
/// means all links and attached objects. Clouds have no shapes. Throws std::invalid_argument for an
/// unknown name and a configuration of another size.
std::vector<robots::Geometry> shapesOf(const Problem& problem, const std::string& name,
                                       std::span<const double> configuration = {});

/// Returns the shapes of all of these names for carved(), as shapesOf() does. Throws
/// std::invalid_argument also for no name and for a cloud, and with a configuration, which is that
/// of a later time than the start, for what has moved since (deforming obstacles and objects with a
/// motion), and for a planned variable beyond its limits.
std::vector<robots::Geometry> shapesToCarve(const Problem& problem,
                                            std::span<const std::string> names,
                                            std::span<const double> configuration = {});

/// Filters of a scan that was taken while the robot moved, in the order in which they are applied.
struct ScanFilters {
  /// Names for shapesToCarve(): what the scan shows of these, to within carve_margin [m].
  std::optional<std::vector<std::string>> carve = std::nullopt;
  double carve_margin = 0;
  std::vector<double> state = {};  ///< for carve: the planned variables when the scan was taken
  std::optional<double> thin = std::nullopt;             ///< see thinned() [m]
  std::optional<std::size_t> most_balls = std::nullopt;  ///< see thinnedTo()
};
/// Returns a scan after its filters; X_WC is the pose of its frame, which carve needs. Throws
/// std::invalid_argument for carve without a pose or a state within the limits, for carve_margin
/// without carve, and as carved(), thinned(), thinnedTo() and shapesToCarve() do.
PointCloud filteredScan(const Problem& problem, PointCloud scan,
                        const std::optional<robots::Pose>& X_WC, const ScanFilters& filters);

/// Returns balls in the world that contain everything that the robot and its attached objects can
/// reach, with planned variables within their limits and the others as at the start. Radii are
/// infinite behind a prismatic joint without limits. O(links x joints).
std::vector<PointCloud::Ball> reachOf(const Problem& problem);

/// Returns the planned variables of the start, in the group's order.
std::vector<double> startPoint(const Problem& problem);

/// Returns the middle of the goal's ranges; where a range has none, its finite end, else the
/// start's value. With poses, use placeStart().
std::vector<double> goalPoint(const Problem& problem, const Goal& goal);

/// Returns the region of a pose, with the names resolved in `problem` and the links as at its
/// start. Throws robots::InputError for an invalid robot or start, see validate(). Throws
/// std::invalid_argument for names that do not exist, a reference frame that planned variables
/// move, ranges that are not finite or have their upper end first, a `rotation` that is not a
/// rotation, and tolerances below robots::kLeastPoseTolerance. O(links).
robots::PoseRegion poseRegion(const Problem& problem, const FramePose& pose);

}  // namespace leeway::planner
