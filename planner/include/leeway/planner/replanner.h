#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// What is done in one step.
enum class Decision : unsigned char {
  kPlan,    ///< a new path is set out on
  kFollow,  ///< the path holds and is followed
  kWait,    ///< the robot stands where it is
  kEvade,   ///< where it is, it cannot stay: it moves off its path to where it can
  kUnsafe,  ///< nothing can be certified, not even standing: it stands
};
const char* toString(Decision decision);  ///< "plan", "follow", "wait", "evade", "unsafe"

/// Where the robot is at a time. Between two of them it moves as the space interpolates, at
/// constant speed.
struct TimedPoint {
  double time = 0;  ///< [s]
  std::vector<double> position;
};

/// What following one obstacle cost in a step.
struct ObstacleUpdate {
  std::string object, strategy;  ///< strategy: what was done, also where `auto` chose it
  std::string reason;            ///< why `auto` chose it, in a few words; else "asked for"
  double update_s = 0;           ///< to have its hierarchy at the step's beginning [s]
};

/// One step: from one look at the world to the next.
struct ReplanStep {
  int index = 0;
  double time = 0;  ///< of the look at the world [s]
  Decision decision = Decision::kUnsafe;
  /// The motion is proven to keep all margins at every moment of the step, whatever the obstacles
  /// do within what is known of them. False only for kUnsafe.
  bool certified = false;
  /// How long the robot is certified to be able to go on, or to stand, beyond the step [s]; at most
  /// Execution::look_ahead.
  double look_ahead = 0;
  /// From the present state to that at the next look, at least two rows; all of them within the
  /// step.
  std::vector<TimedPoint> motion;
  /// The least separation of checked pairs over the whole step [m]; (inf, inf) without pairs.
  Interval clearance;
  std::string closest_a, closest_b;
  /// Whether what was left of the path held in the world as it was seen, and what broke it if not.
  bool path_held = false;
  std::string broken_a, broken_b;
  bool reached = false;       ///< the motion ends in a goal
  double remaining_s = 0;     ///< time that the rest of the path takes [s]; infinite without a path
  double path_clearance = 0;  ///< certified of a new path as planned [m]; infinite otherwise

  double update_s = 0, certify_s = 0, plan_s = 0, clearance_s = 0;  ///< of computing [s]
  std::vector<ObstacleUpdate> obstacles;
  /// `looks`: instants at which obstacles were placed, the present one included.
  std::uint64_t looks = 0, edges = 0, distance_queries = 0, iterations = 0;
};

struct ReplanOptions {
  std::function<bool()> stop;  ///< asked often; true ends planning, and replan()
  std::function<void(const std::string& phase, double elapsed_s)> progress;
  double clearance_tolerance = 1e-3;  ///< of ReplanStep::clearance, as far as obstacles' motion
                                      ///< within the step does not widen it [m]
};

/// Executes a problem among obstacles that deform, step by step. At the beginning of every step it
///
/// 1. brings the obstacles' hierarchies to the present: from their motions, or from the vertices
///    that the program has set;
/// 2. certifies again what is left of the path in the world as it is seen now, edge by edge in the
///    order of travel, up to the first that fails;
/// 3. plans anew from the present state when it does not hold;
/// 4. certifies the motion of the step itself against all that obstacles can do in it: the step is
///    halved in time until the placement at the middle of each part, grown by the vertices' speed
///    bound times half its length, leaves the robot's own motion in that part free (certified as
///    any edge is, without a step size). Where only a speed bound is known, the placement is that
///    of the last look, grown by the bound times its age;
/// 5. follows the path if that can be certified, else waits if standing can be, else evades: back
///    along its trail, or to a random neighbour. What cannot be certified is never called free.
///
/// Computing is taken to fit into a step: its cost is told, not simulated. Deterministic: the same
/// problem, seed and iteration limit give the same steps, costs apart, unless the time limit cuts a
/// search short. Each (re)planning has the problem's limits. One object is for one thread;
/// scenes that it hands out are constant and may be read by any thread meanwhile.
class Replanner {
 public:
  /// Throws robots::InputError for what a problem file can get wrong.
  explicit Replanner(const Problem& problem, const ReplanOptions& options = {});
  ~Replanner();
  Replanner(Replanner&&) noexcept;
  Replanner& operator=(Replanner&&) noexcept;

  /// Decides the next step, and takes it: afterwards time() is that of the next look and state()
  /// the end of the motion. Costs as planning does. When it throws (InputError, for what only
  /// planning finds), time, state and path are what they were.
  ReplanStep step();

  double time() const;
  std::span<const double> state() const;
  /// What is left of the path, from state() on; empty without one.
  const std::vector<std::vector<double>>& path() const;
  bool reached() const;  ///< state() is in a goal, and the path is used up
  int replans() const;   ///< paths planned besides the first

  /// Where the robot really is now. Throws std::invalid_argument for another size, or what is not
  /// finite or outside the limits.
  void setState(std::span<const double> point);
  /// Where the vertices of an obstacle were seen at `time` <= time(), in its frame, and how fast
  /// any of them may move from then on [m/s] (from now on in place of its motion). Throws
  /// std::invalid_argument for an unknown obstacle, another number of vertices, NaN, a time later
  /// than time(), or a speed bound that is not >= 0: then all stays as it was.
  void setVertices(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                   double time, double speed_bound);

  /// The scene as it was at the last look: constant, for any thread.
  std::shared_ptr<const CompiledScene> scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

enum class ReplanStatus : unsigned char {
  kReached,  ///< in a goal, every step certified
  kUnsafe,   ///< at some step nothing could be certified: the robot stands there
  kTimeout,  ///< Execution::duration has passed
  kStopped,  ///< by the caller, or the number of steps
};
const char* toString(ReplanStatus status);  ///< "reached", "unsafe", "timeout", "stopped"

/// A whole execution.
struct ReplanResult {
  ReplanStatus status = ReplanStatus::kStopped;
  std::uint64_t seed = 0;
  std::vector<std::string> names;      ///< of the planned variables
  std::vector<TimedPoint> trajectory;  ///< what was executed
  int steps = 0, plans = 0, follows = 0, waits = 0, evasions = 0;
  int replans = 0;                           ///< plans besides the first
  Interval clearance;                        ///< the least of all steps [m]
  bool certified = false;                    ///< every step was
  double compute_s = 0, longest_step_s = 0;  ///< of computing [s]
};

/// Steps until a goal is reached, a step cannot be certified, or the execution's time is up.
/// `on_step`, if any, is told of every step; `steps` > 0 limits their number.
ReplanResult replan(const Problem& problem, const ReplanOptions& options = {},
                    const std::function<void(const ReplanStep&)>& on_step = {}, int steps = 0);

/// An executed trajectory as CSV: a header of `time` and the joints' names, 17 digits. Written
/// whole or not at all; throws robots::InputError.
void writeTrajectory(const std::string& file, const Problem& problem,
                     std::span<const TimedPoint> trajectory);

}  // namespace leeway::planner
