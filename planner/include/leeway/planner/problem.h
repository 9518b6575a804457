#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/vertex_motion.h"
#include "leeway/robots/model.h"

namespace leeway::planner {

/// A thing in the world that does not move, or that is attached to a link.
struct Object {
  std::string name;
  std::vector<robots::Geometry> geometries;
  robots::Pose X_WO;
};

/// An object held by a link from the start: it moves with the link and may touch only `touch_links`
/// (and the link itself).
struct Attachment {
  Object object;  ///< X_WO is unused
  int link = -1;
  robots::Pose X_LO;
  std::vector<int> touch_links;
};

/// A goal: a range for every planned variable; a single value is a range of no width.
struct Goal {
  std::string name;                               ///< group state, or "goal", "goal 2", ...
  std::vector<std::pair<double, double>> ranges;  ///< in group order
};

/// An object of the world whose vertices move. It stands in Problem::objects under its name, with
/// one geometry: the mesh as it is at Execution::start. That is what planning, checks and proofs
/// look at; Replanner follows it from there.
struct DeformingObstacle {
  std::string object;
  std::shared_ptr<const collision::DeformableMesh> mesh;
  /// Null: the embedding program says where the vertices are.
  std::shared_ptr<const collision::VertexMotion> motion;
  /// What is known of the vertices' speed when their future is not [m/s]; infinite: the motion's
  /// own bound, and without a motion nothing.
  double speed_bound = std::numeric_limits<double>::infinity();
  collision::DeformOptions options;
};

/// What is assumed of obstacles that deform beyond the moment at which they were seen.
enum class Foresight : unsigned char {
  kMotion,      ///< their motion is known
  kSpeedBound,  ///< no more than a bound on the speed of their vertices
};

/// What a timed path does at the corners of its path.
enum class Corners : unsigned char {
  kStop,   ///< comes to rest
  kBlend,  ///< cuts them where the cut is proven to keep the margins, else comes to rest
};

/// How a path is executed. A trajectory (see trajectory.h) keeps all limits. Replanner goes step by
/// step, while the scene changes, at the velocity limits; accelerations, jerks and corners are not
/// for it.
struct Execution {
  double start = 0;      ///< time of the obstacles' motions at which everything begins [s]
  double step = 0.05;    ///< from one look at the world to the next [s]
  double duration = 30;  ///< what does not reach a goal within this has failed [s]
  double speed = 1;      ///< share of the velocity limits that is used, in (0, 1]
  std::map<std::string, double> velocities;  ///< in place of the URDF's, by variable [rad/s or m/s]
  /// By variable [rad/s^2 or m/s^2]; elsewhere what reaches the velocity limit in half a second.
  std::map<std::string, double> accelerations;
  std::map<std::string, double> jerks;  ///< by variable [rad/s^3 or m/s^3]; elsewhere no limit
  Corners corners = Corners::kStop;
  Foresight foresight = Foresight::kMotion;
  /// A step is preferred after which so much more time can be certified, going on or standing [s].
  double look_ahead = 0.2;
  /// Paths are planned to keep this besides the margin from what deforms, so that they last; where
  /// there is none, without [m].
  double buffer = 0.02;
  /// A path that holds but cannot be executed is waited for this long before another is planned
  /// [s].
  double patience = 0.5;
};

/// Velocity limit of a joint that has none, as everywhere in this library [rad/s or m/s].
inline constexpr double kDefaultVelocity = 1;

/// Everything that a planner needs to know, checked and complete. Made by a loader below or by a
/// program.
struct Problem {
  std::string name;
  std::shared_ptr<const robots::Model> model;
  std::vector<int> variables;  ///< planned variables, in group order
  std::vector<double>
      configuration;        ///< all variables of the model: the start, passive ones included
  std::vector<Goal> goals;  ///< at least one
  std::vector<Object> objects;
  std::vector<DeformingObstacle> deforming;
  std::vector<Attachment> attachments;
  /// Names (links, objects, attached objects) that may touch, beyond what the SRDF disables.
  std::vector<std::pair<std::string, std::string>> allowed;
  /// True: `allowed` stands in for the SRDF's pairs; what it leaves out is checked although the
  /// SRDF disables it (MoveIt's matrix: false).
  bool replace_srdf_pairs = false;
  double margin = 0;  ///< [m]
  struct PairMargin {
    std::string a, b;
    double margin;
  };
  std::vector<PairMargin> margins;

  std::string planner = "RRTConnect";
  std::map<std::string, std::string> planner_parameters;  ///< by OMPL's names
  std::string objective = "length";                       ///< "length" or "clearance"
  bool simplify = true;
  double time_limit = 5;             ///< [s]
  std::int64_t iteration_limit = 0;  ///< 0: none
  std::uint64_t seed = 1;
  Execution execution;
  std::vector<std::string> warnings;  ///< of this problem's own files, each with file and line; the
                                      ///< robot's are in model->warnings
};

struct ProblemOptions {
  robots::LoadOptions load;
};

/// The project's own YAML (problems/README.md, problems/schema.json). Throws robots::InputError.
Problem loadProblem(const std::string& yaml_path, const ProblemOptions& options = {});

/// MoveIt planning scene and motion plan request, as MotionBenchMaker writes them. The model may be
/// shared between calls.
Problem loadMoveit(std::shared_ptr<const robots::Model> model, const std::string& scene_path,
                   const std::string& request_path);

/// A problem without a YAML file: start and goal are group states. Throws robots::InputError
/// (without a file) for unknown names.
Problem problemFromStates(std::shared_ptr<const robots::Model> model, const std::string& group,
                          const std::string& start, const std::string& goal);

/// Adds an obstacle that deforms, as it is at problem.execution.start: to problem.objects and
/// problem.deforming. Throws std::invalid_argument for a strategy that the motion does not have, a
/// motion with another number of vertices than the mesh, vertices that are not finite, options or a
/// speed bound that make no sense, or a name that another object or a link has.
void addDeforming(Problem& problem, const std::string& name,
                  std::shared_ptr<const collision::DeformableMesh> mesh,
                  std::shared_ptr<const collision::VertexMotion> motion, const robots::Pose& X_WO,
                  const collision::DeformOptions& options = {},
                  double speed_bound = std::numeric_limits<double>::infinity());

/// The problem with `object` (one of problem.objects) held by `link` from now on, where it is while
/// the robot stands at `configuration` (all variables of the model; empty: the problem's start). It
/// then moves with the link and may touch it and `touch_links`. Names in `allowed` and `margins` go
/// on to mean it. Throws std::invalid_argument for unknown names.
Problem attachObject(const Problem& problem, const std::string& object, const std::string& link,
                     const std::vector<std::string>& touch_links = {},
                     std::span<const double> configuration = {});

/// The problem with an attached object put down where it is while the robot stands at
/// `configuration`: attachObject() undone.
Problem detachObject(const Problem& problem, const std::string& object,
                     std::span<const double> configuration = {});

}  // namespace leeway::planner
