#pragma once

#include <array>
#include <cstdint>
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
#include "leeway/collision/vertex_motion.h"
#include "leeway/planner/point_cloud.h"
#include "leeway/robots/model.h"
#include "leeway/robots/pose_region.h"

namespace leeway::planner {

/// A named thing with a shape: an obstacle, or what a link holds.
struct Object {
  std::string name;
  /// None: only a name, which margins and contacts may use before CompiledScene::withObjects()
  /// adds the thing itself.
  std::vector<robots::Geometry> geometries;
  robots::Pose X_WO;
  /// Balls that belong to it as well, in its frame; null: none. Only an object of the world has a
  /// cloud: what a link holds has shapes.
  std::shared_ptr<const PointCloud> cloud = nullptr;
};

/// An object held by a link from the start. It moves with the link, and may touch the link and
/// `touch_links` only.
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

/// The robot, and what of it is planned.
struct PlannedRobot {
  std::shared_ptr<const robots::Model> model;
  std::vector<int> variables;  ///< planned ones, in group order
  std::vector<Attachment> attachments;
  std::vector<Frame> frames;
};

/// What a frame F keeps, seen from a reference frame R, on all of a path: proven everywhere, as
/// margins are. Names are those of FramePose.
struct Constraint {
  /// What is kept of F's rotation.
  enum class Turn : unsigned char {
    kAny,    ///< nothing
    kFixed,  ///< `rotation`, to within `angle`
    kAxis,   ///< that `axis` points along `direction`, to within `angle`
  };
  static constexpr std::pair<double, double> kFree{-std::numeric_limits<double>::infinity(),
                                                   std::numeric_limits<double>::infinity()};

  std::string name;         ///< in messages
  std::string frame;        ///< a frame, a link or an attached object
  std::string relative_to;  ///< an object, or a frame or link at rest; empty: the world
  robots::Pose X_SR;        ///< of R in the frame S of that name
  /// Of F's origin in R [m]: a box, or a plane or line where ranges have no width.
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

/// Where a frame F may be in a reference frame R, by names; poseRegion() looks up where they stand.
struct FramePose {
  std::string frame;        ///< a frame, a link or an attached object
  std::string relative_to;  ///< an object, or a frame or link at rest; empty: the world
  std::array<std::pair<double, double>, 3> position;  ///< of F's origin in R [m]
  /// R_RF = Rz(yaw) Ry(pitch) Rx(roll) rotation [rad]. 2 pi wide or more: any angle.
  std::array<std::pair<double, double>, 3> rpy;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double position_tolerance = 1e-9;  ///< how far outside a solution may be [m]
  double angle_tolerance = 1e-9;     ///< [rad]
};

/// A goal: either a range for every planned variable (a single value is a range of no width), or
/// poses of frames, which hold all at once at any value of the variables within the limits.
struct Goal {
  std::string name;                               ///< group state, or "goal", "goal 2", ...
  std::vector<std::pair<double, double>> ranges;  ///< in group order; empty beside poses
  std::vector<robots::PoseRegion> poses = {};
};

/// To a configuration, by whatever path is found.
struct MoveStep {
  Goal goal;                     ///< of joints, or named by:
  std::vector<FramePose> poses;  ///< looked up when the step begins; empty: `goal` holds
};

/// A place on a frame's way.
struct Waypoint {
  Eigen::Vector3d position;  ///< of the frame's origin [m]
  /// The frame's; nothing: as at the place before.
  std::optional<Eigen::Matrix3d> rotation = {};
  /// The origin goes there on the circle's arc through this point; nothing: straight.
  std::optional<Eigen::Vector3d> via = {};
};

/// A frame goes along lines or arcs, and turns about one axis, at a constant rate, on each.
struct LineStep {
  std::string frame;                             ///< a frame, a link or an attached object
  Eigen::Vector3d by = Eigen::Vector3d::Zero();  ///< from where it is [m]; 0 beside `poses`
  /// As in FramePose, or "world": what `by`, `turn` and `poses` are seen from. Empty: for `by` and
  /// `turn` the frame's own axes, for `poses` the world.
  std::string relative_to;
  /// At every time of the motion the origin is as near to its place on the way [m], and the frame
  /// as little turned from its rotation there [rad]: proven.
  double position_tolerance = 1e-3, angle_tolerance = 1e-2;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< beside `by`: how the frame turns
  std::vector<Waypoint> poses = {};  ///< in place of `by`: it goes through all, in their order
};

/// A link takes hold of an object where it stands; see attachObject().
struct AttachStep {
  std::string object, link;
  std::vector<std::string> touch;  ///< links that may touch it, besides
};

/// The object is let go of, and stays where it is; see detachObject().
struct DetachStep {
  std::string object;
};

/// A part of a task (task.h).
struct Step {
  std::string name;  ///< "move", "line 2", ...
  std::variant<MoveStep, LineStep, AttachStep, DetachStep> action;
  /// Pairs that may touch during this step, besides those of the problem.
  std::vector<std::pair<std::string, std::string>> allowed;
};

/// An obstacle whose vertices move. Made by makeDeformingObstacle(). Plans, checks and proofs look
/// at `object`; Replanner follows `motion` from there.
struct DeformingObstacle {
  /// The obstacle at Execution::start: its geometry is a snapshot of `mesh`.
  Object object;
  std::shared_ptr<const collision::DeformableMesh> mesh;
  /// Null: the embedding program says where the vertices are.
  std::shared_ptr<const collision::VertexMotion> motion;
  /// Bound on the vertices' speed where their future is unknown [m/s]. Infinite: the motion's own
  /// bound; without a motion, no bound.
  double speed_bound = std::numeric_limits<double>::infinity();
  collision::DeformOptions options;
};

/// A deforming obstacle as it is at `time` [s], which must be the problem's Execution::start. Its
/// frame stands at X_WO. Throws std::invalid_argument for a missing mesh, a strategy that the
/// motion does not have, a motion with another number of vertices than the mesh, vertices that are
/// not finite, and options or a speed bound that make no sense. O(triangles) and a tree's build.
DeformingObstacle makeDeformingObstacle(
    std::string name, std::shared_ptr<const collision::DeformableMesh> mesh,
    std::shared_ptr<const collision::VertexMotion> motion, const robots::Pose& X_WO,
    double time = 0, const collision::DeformOptions& options = {},
    double speed_bound = std::numeric_limits<double>::infinity());

/// What surrounds the robot. Links, objects, deforming obstacles and attached objects have names of
/// their own.
struct World {
  std::vector<Object> objects;  ///< at rest
  std::vector<DeformingObstacle> deforming;
};

/// Pairs that need no check. Names are those of links, objects and attached objects.
struct Contacts {
  std::vector<std::pair<std::string, std::string>> allowed;  ///< may touch, besides the SRDF's
  /// `allowed` replaces the SRDF's pairs: what it does not name is checked even if the SRDF
  /// disables it. Set by MoveIt's matrix.
  bool replace_srdf = false;
};

/// The margin of one pair. Names as in Contacts; "robot" also stands for all links and what they
/// hold, "world" for all objects and deforming obstacles, those included that come later, unless an
/// object or a link with shapes has that name.
struct PairMargin {
  std::string a, b;
  double margin;  ///< [m]
  /// Pairs that a group's name stands for have one text here, "robot and table": they are warned of
  /// together, when none of them is checked.
  std::string group = {};
};

/// A clearance that pairs keep where that is not too dear. With the objectives length and cost, a
/// path that does not keep it costs more, by
///   weight * integral of max(0, 1 - d / clearance) over the path's length,
/// where d is the least separation of the pairs, and at least 0: with a weight of 1, a stretch that
/// touches costs as if it were twice as long.
struct Wish {
  std::string name;                                        ///< "robot and people"
  std::vector<std::pair<std::string, std::string>> pairs;  ///< names as in Contacts
  double clearance = 0;                                    ///< [m], above 0
  double weight = 1;                                       ///< above 0
};

/// Separation that checked pairs keep: every pair is farther apart than its margin. Below 0, bodies
/// may overlap by that much.
struct Margins {
  double common = 0;              ///< of pairs without one of their own [m]
  std::vector<PairMargin> pairs;  ///< the last one that names a pair holds
  std::vector<Wish> wishes;       ///< each counts, also where two name one pair
};

/// Pairs by what the robot is apart from. What it holds belongs to it, and so do its links that
/// stand still.
enum class Pairs : unsigned char {
  kAll,
  kWorld,  ///< of the robot and something else
  kSelf,   ///< of two parts of the robot
};

/// The shortest path, in the space's distance.
struct MinimumLength {
  /// Pairs with the world keep at least that, besides their margins [m].
  double clearance = -std::numeric_limits<double>::infinity();
};
/// The path whose least clearance is largest.
struct MaximumClearance {
  Pairs of = Pairs::kWorld;  ///< the others keep their margins
  /// How much longer the path may be than the shortest that is found, as a share of that one's
  /// length.
  double at_most_longer = std::numeric_limits<double>::infinity();
};
/// What it costs to be near, from 0 to 1: a function of the clearance d that never rises. Below 0,
/// d counts as 0.
struct Nearness {
  enum class Kind : unsigned char {
    kHinge,    ///< max(0, 1 - d / distance)
    kInverse,  ///< min(1, distance / d)
  };
  Kind kind = Kind::kHinge;
  double distance = 0.1;  ///< [m], above 0
};
/// A part of a path's cost.
struct CostTerm {
  Nearness nearness;
  double weight = 1;  ///< 0 or more
  /// The greatest value that nearness has along the path, in place of its integral over the path's
  /// length (in the space's distance).
  bool worst = false;
  Pairs of = Pairs::kWorld;  ///< whose clearance; the others keep their margins
};
/// The path whose weighted sum is least.
struct MinimumCost {
  double length = 0;  ///< weight of the path's length, 0 or more
  std::vector<CostTerm> terms;
};
/// What the planner optimises.
using Objective = std::variant<MinimumLength, MaximumClearance, MinimumCost>;

/// "length"; "clearance"; of costs "integral" where that is all, else "weighted".
const char* toString(const Objective& objective);
/// Of "length" and "clearance".
std::optional<Objective> objectiveOfName(std::string_view name);

/// Which planner runs, and how.
struct PlannerChoice {
  std::string name = "Connect";                   ///< see planners.h
  std::map<std::string, std::string> parameters;  ///< by OMPL's names
  bool simplify = true;                           ///< the path that it finds
  /// Where length is the objective: a simplified path is pushed off what is near, by up to 8 mm,
  /// and gets at most 3 % longer; where less than 3 mm are left, another path is searched. Where
  /// clearance is the objective: the path is pushed where it keeps more than its least clearance.
  bool push = true;
};

/// When planning and simplification end.
struct PlanningLimits {
  double time = 5;              ///< [s]; 0 or infinity: no limit
  std::int64_t iterations = 0;  ///< of the planner; 0: no limit
};

/// What Replanner assumes of deforming obstacles after it has last seen them.
enum class Foresight : unsigned char {
  kMotion,      ///< their motion is known
  kSpeedBound,  ///< only a bound on their vertices' speed is known
};

/// What a timed path does at its corners.
enum class Corners : unsigned char {
  kStop,   ///< comes to rest
  kBlend,  ///< cuts them where the cut is proven to keep the margins, else comes to rest
};

/// How a path is executed. A trajectory (trajectory.h) keeps all limits. Replanner moves at the
/// velocity limits, in steps, while the scene changes; it ignores accelerations, jerks and corners.
struct Execution {
  double start = 0;      ///< time of the obstacles' motions at which execution begins [s]
  double step = 0.05;    ///< from one look at the world to the next [s]
  double duration = 30;  ///< a goal not reached within this is a failure [s]
  double speed = 1;      ///< share of the velocity limits that is used, in (0, 1]
  std::map<std::string, double> velocities;  ///< by variable; default: the robot's [rad/s or m/s]
  /// By variable [rad/s^2 or m/s^2]; default: the robot's; without one the velocity limit is
  /// reached in half a second.
  std::map<std::string, double> accelerations;
  /// By variable [rad/s^3 or m/s^3]; default: the robot's, or no limit.
  std::map<std::string, double> jerks;
  Corners corners = Corners::kStop;
  Foresight foresight = Foresight::kMotion;
  /// Replanner prefers steps after which this much more motion or rest can be certified [s].
  double look_ahead = 0.2;
  /// Distance that paths keep from deforming obstacles beyond the margin, so that they last. Where
  /// no such path is found, one without it is used [m].
  double buffer = 0.02;
  /// Wait this long for a valid path that cannot be executed now, before planning another [s].
  double patience = 0.5;
};

/// Velocity limit of a joint for which the URDF has none [rad/s or m/s].
inline constexpr double kDefaultVelocity = 1;

/// All that a planner needs to know. Made by a loader below or filled by a program, in any order:
/// every function that takes it calls validate().
struct Problem {
  std::string name;
  PlannedRobot robot;
  std::vector<double> start;  ///< all variables of the model, those not planned included
  /// Where the start is given by poses: placeStart() finds planned variables for them. Empty:
  /// `start` holds as it is.
  std::vector<robots::PoseRegion> start_poses;
  std::vector<Goal> goals;  ///< at least one, or
  std::vector<Step> steps;  ///< a task: planTask() (task.h) instead of plan()
  /// Each holds on all of a path, its start and goal included; beside goals only.
  std::vector<Constraint> constraints;
  World world;
  Contacts contacts;
  Margins margins;
  Objective objective;
  PlannerChoice planner;
  PlanningLimits limits;
  std::uint64_t seed = 1;
  Execution execution;
  /// The loader's, of this problem's own files, each with file and line. The robot's are in
  /// robot.model->warnings.
  std::vector<std::string> warnings;
};

/// Throws robots::InputError, which names the member, its value and what is expected, for the first
/// of these:
/// - no model; planned variables or links that the model does not have; variables planned twice;
/// - a start of another size, or outside the limits of planned variables; goals or poses that
///   nothing can meet; goals beside steps, and steps that name what is not there;
/// - a name that stands for two things, or that is empty; a name in margins, wishes or contacts
/// that
///   stands for nothing; a pair of one name;
/// - constraints of frames that do not move, or of nothing; beside steps, another objective than
///   length, another planner than Connect, or corners that are cut;
/// - poses that are not finite or not rotations; numbers that are not finite or negative where that
///   makes no sense; a planner or parameters that do not exist or do not fit the objective;
/// - deforming obstacles without a snapshot of Execution::start.
///
/// Goals may be missing: a scene can be compiled without. O(things + pairs of names), about a
/// microsecond for a small problem.
void validate(const Problem& problem);

struct ProblemOptions {
  /// Of robots and meshes; `stop` ends reading of all else, too, and `errors` gathers all of it.
  robots::LoadOptions load;
};

/// The project's own YAML (problems/README.md, problems/schema.json). Throws robots::InputError,
/// and robots::Stopped where options.load.stop says so.
Problem loadProblem(const std::string& yaml_path, const ProblemOptions& options = {});

/// Poses of a frame from a file: .csv with columns x, y, z and qx, qy, qz, qw or roll, pitch, yaw;
/// .yaml or .json with a list of poses, or what problem files have under `waypoints`. `frame` may
/// be empty where the file names it. Quaternions that are not quite of unit length add to
/// `warnings`. Throws robots::InputError.
LineStep loadWaypoints(const std::string& file, const std::string& frame,
                       std::vector<std::string>& warnings);

/// MoveIt planning scene and motion plan request, as MotionBenchMaker writes them. Calls may share
/// the model. Throws robots::InputError, robots::Stopped.
Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path, const ProblemOptions& options = {});

/// The world of a scene that MoveIt has saved as text (.scene), without a robot. Adds to
/// `warnings`. Throws robots::InputError, robots::Stopped.
World loadMoveitWorld(const std::string& scene_path, const ProblemOptions& options,
                      std::vector<std::string>& warnings);

/// Returns the robot with the limits of MoveIt's joint_limits.yaml. Velocities, accelerations and
/// jerks replace the robot's own; the lesser of acceleration and deceleration counts. Positions
/// narrow its range (robots::withBounds()); where they are wider, the robot's own hold, with a
/// warning of the model. A limit of a joint that follows another one limits that one. Throws
/// robots::InputError, robots::Stopped. O(file + joints^2).
std::shared_ptr<const robots::Model> withJointLimits(const robots::Model& model,
                                                     const std::string& yaml_path,
                                                     const robots::LoadOptions& options = {});

/// Allows the pairs of links that touch with all joints at zero, or at the nearest limit: those of
/// robots::touchingAtRest(), proven, which include all that touch everywhere. A warning of the
/// problem names them. Throws robots::InputError for a robot that is missing or lacks its meshes,
/// robots::Stopped. One distance query a pair of geometries.
void allowTouching(Problem& problem, const robots::Stop& stop = {});

/// A problem without obstacles, from group states or values of the planned variables: "0, 1.5".
/// Throws robots::InputError (without a file) for unknown names and wrong values.
Problem problemFromStates(std::shared_ptr<const robots::Model> model, const std::string& group,
                          const std::string& start, const std::string& goal);

/// The problem with `object` (one of world.objects) held by `link`, grasped where it stands while
/// the robot is at `configuration` (all variables of the model; empty: the start). It then moves
/// with the link and may touch it and `touch_links`. Contacts and margins keep naming it. Throws
/// robots::InputError as validate(), std::invalid_argument for unknown names and a configuration of
/// another size.
Problem attachObject(const Problem& problem, const std::string& object, const std::string& link,
                     const std::vector<std::string>& touch_links = {},
                     std::span<const double> configuration = {});

/// The problem with an attached object put down where it is while the robot is at `configuration`:
/// the inverse of attachObject(), with the same errors.
Problem detachObject(const Problem& problem, const std::string& object,
                     std::span<const double> configuration = {});

/// The shapes of a link, an object or an attached object, placed in the world by their X_BG, with
/// the robot at `configuration` (all variables of the model; empty: the start); of "robot" those of
/// all links and attached objects. Clouds have none. Throws std::invalid_argument for an unknown
/// name and a configuration of another size.
std::vector<robots::Geometry> shapesOf(const Problem& problem, const std::string& name,
                                       std::span<const double> configuration = {});

/// Balls in the world that contain all that the robot, and what it holds, can reach: planned
/// variables anywhere within their limits, the others as at the start. Radii are infinite behind a
/// prismatic joint without limits. O(links x joints).
std::vector<PointCloud::Ball> reachOf(const Problem& problem);

/// The region of a pose where the names of `problem` stand: links as at its start. Throws
/// robots::InputError for a robot or start that makes no sense, see validate();
/// std::invalid_argument for names that do not exist, a link or attached object as reference that
/// planned variables move, ranges that are not finite or have their upper end first, a `rotation`
/// that is none, and tolerances below robots::kLeastPoseTolerance. O(links).
robots::PoseRegion poseRegion(const Problem& problem, const FramePose& pose);

}  // namespace leeway::planner
