#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// The decision of one step.
enum class Decision : unsigned char {
  kPlan,    ///< follow a new path
  kFollow,  ///< follow the path, which holds
  kWait,    ///< come to rest by the stop of the step before, or stand
  kEvade,   ///< leave the path for a place that is certified, because standing is not
  kUnsafe,  ///< as kWait, but the step is not certified (see ReplanStep::exposed)
};
const char* toString(Decision decision);  ///< "plan", "follow", "wait", "evade", "unsafe"

/// The robot's place at a time. Between two of them it moves as the space interpolates, at constant
/// speed.
struct TimedPoint {
  double time = 0;  ///< [s]
  std::vector<double> position;

  bool operator==(const TimedPoint&) const = default;
};

/// The cost of following one obstacle in a step.
struct ObstacleUpdate {
  std::string object;
  /// The one that ran, by choice of `auto` or not; "pose": it is rigid; "cloud": it is a cloud.
  std::string strategy;
  /// Why `auto` chose it, in a few words; else "asked for", "it is rigid", "it is a cloud".
  std::string reason;
  double update_s = 0;     ///< of its hierarchy, to the step's beginning [s]
  double seen = 0;         ///< when it was last seen, at or before the step's beginning [s]
  bool predicted = false;  ///< the step was proven against its motion, not against a bound on it
};

/// A cloud that was seen, in the frame X_WO.
struct SeenCloud {
  std::shared_ptr<const PointCloud> cloud;
  robots::Pose X_WO;
};

/// An observation of one obstacle by the program: see Replanner::setVertices(), setPose() and
/// setCloud().
struct ObstacleSight {
  std::string object;
  double time = 0;  ///< [s]
  /// The vertices in its frame [m], the pose X_WO, or all balls of a cloud.
  std::variant<std::vector<Eigen::Vector3d>, robots::Pose, SeenCloud> seen;
  double speed_bound = 0;  ///< from then on [m/s]
  double turn_bound = 0;   ///< of a pose [rad/s]
};

/// One step: from one look at the world to the next.
struct ReplanStep {
  int index = 0;
  double time = 0;  ///< of the look at the world [s]
  Decision decision = Decision::kUnsafe;
  /// The motion and the stop are proven to keep all margins at every time, for any motion of the
  /// obstacles within their known motions or speed bounds. False only for kUnsafe, which includes
  /// that no pair is checked at all (CompiledScene::nothingChecked()).
  bool certified = false;
  /// Not certified, because an obstacle may reach the robot where it stands: the motion is proven
  /// until the robot rests, and the rest is proven against all that stands still.
  bool exposed = false;
  /// Why it waits, evades, or is unsafe, in a few words; empty where it goes along a path.
  std::string why;
  /// Time after the step for which going on, coming to rest, or standing is certified [s]; at most
  /// Execution::look_ahead.
  double look_ahead = 0;
  /// From the present state to that of the next look: rows one period apart, of which each step has
  /// as many.
  std::vector<TimedPoint> motion;
  /// Rows after the motion in which the robot comes to rest, should no other step be taken. Empty
  /// where it rests already.
  std::vector<TimedPoint> stop;
  /// The motion and the stop are what the step before stated as its stop.
  bool keeps_stop = false;
  /// Bounds on the least separation over the step [m], maybe below a margin; (inf, inf): no pairs.
  Interval clearance;
  std::string closest_a, closest_b;
  /// The rest of the path is certified in the world as seen; if not, the bodies that broke it.
  bool path_held = false;
  std::string broken_a, broken_b;
  bool reached = false;  ///< the motion ends in a goal
  /// Duration of the rest of the path [s], at least; infinite without a path.
  double remaining_s = 0;
  double path_clearance = 0;  ///< certified for a new path [m]; infinite without one

  double update_s = 0, certify_s = 0, plan_s = 0, clearance_s = 0;  ///< of computing [s]
  std::vector<ObstacleUpdate> obstacles;
  /// Observations by the program since the step before: obstacles in the order of the calls, and
  /// the state that Replanner::setState() changed.
  std::vector<ObstacleSight> observed;
  std::optional<std::vector<double>> measured;
  /// `looks`: instants at which obstacles were placed, the present one included.
  std::uint64_t looks = 0, edges = 0, distance_queries = 0, iterations = 0;
};

struct ReplanOptions {
  std::function<bool()> stop;  ///< asked often; true ends planning, and replan()
  std::function<void(const std::string& phase, double elapsed_s)> progress;
  /// Width of ReplanStep::clearance [m], to which the obstacles' motion within the step is added.
  double clearance_tolerance = 1e-3;
  /// The cost that proofs of a step may have, in units of collision::Work (about a thousand a
  /// microsecond): once each for the path, what the robot may do, its way to rest, and the
  /// clearance. What is not proven within it is not done.
  std::int64_t work = 500'000'000;
  /// Tracking error: how far each planned variable is from the motion at most [rad or m]; empty: 0.
  /// All is proven for any place within it, and clearances are those of the motion. A state that
  /// setState() is given within it (and 1e-9) changes nothing.
  std::vector<double> joint_errors = {};
};

struct ReplanResult;

/// Executes a problem among obstacles that move, step by step: those that deform, and objects with
/// a motion. At the beginning of a step it
///
/// 1. moves the obstacles to the present: by their motions, or to the vertices and poses that the
///    program has set;
/// 2. certifies the rest of the path in the world as seen now, edge by edge in the order of travel,
///    up to the first that fails;
/// 3. plans if one fails and the robot is at rest. The path gets times within the limits on
///    velocity, acceleration and jerk, and cut corners, as by trajectoryOf();
/// 4. certifies the motion of the step, and a stop after it, against all that obstacles can do
///    until then. Time is halved until the robot's motion in each part is free (certified as edges,
///    without a step size) of the obstacles at the part's middle, grown by their speed bound times
///    half its length. With only a speed bound known, the obstacles are those of the last look,
///    grown by the bound times its age;
/// 5. follows the path if that is certified, else comes to rest by the stop of the step before. At
///    rest it waits if standing is certified, else evades: back along its trail, or to a random
///    neighbour. What is not certified is never called free. Where all knowledge is true, a robot
///    that moves touches nothing: what was proven holds until what is observed contradicts it. A
///    robot that stands can still be reached by an obstacle that it cannot evade.
///
/// The motion. Rows of steps and stops are one period apart; the robot passes them in straight
/// lines at constant speed, as position controllers interpolate. The change of that velocity over a
/// period keeps motionLimits() on acceleration, the change of acceleration those on jerk. A stop
/// brakes along the path, so that it is free where the path is and nothing moves. Steps shorter
/// than 50 ms share a stop for that long.
///
/// Computing is assumed to fit into a step: its cost is reported, not simulated. Deterministic: the
/// same problem, seed and iteration limit give the same steps, costs apart, unless the time limit
/// cuts a search short. Each planning has the problem's limits. One object is for one thread; its
/// scenes are constant, for any thread.
class Replanner {
 public:
  /// Throws robots::InputError as validate() does, and for a problem without goals or with steps, a
  /// look-ahead of more than 1,000 steps, a bound on an obstacle's speed that its own motion
  /// exceeds, and joint errors as a Guard does.
  explicit Replanner(const Problem& problem, const ReplanOptions& options = {});
  ~Replanner();
  Replanner(Replanner&&) noexcept;
  Replanner& operator=(Replanner&&) noexcept;

  /// Decides and takes the next step: afterwards time() is that of the next look, and state() the
  /// end of the motion. It plans, and costs that. Throws InputError for a planned variable without
  /// limits, and for a motion that fails;
  /// time, state and path then are as before.
  ReplanStep step();

  double time() const;
  std::span<const double> state() const;
  /// The rest of the path, from state() on; empty without one.
  const std::vector<std::vector<double>>& path() const;
  bool reached() const;  ///< at rest in a goal, and the path is used up
  int replans() const;   ///< paths planned besides the first
  /// The steps so far, without their trajectory. The status is that of the last step: kReached,
  /// kExposed, kUnsafe, kNothingChecked or kStopped; `certified` says whether every step was.
  ReplanResult executed() const;

  /// The robot's true state now; continuous joints need not count their turns. Within
  /// ReplanOptions::joint_errors of the motion, that goes on. Farther off, it goes on from there
  /// with its velocity beside the path (bodies that turn freely are taken to rest), and is only
  /// proven where the path has room beside it. Throws std::invalid_argument for another size, and
  /// for numbers that are not finite or outside the limits.
  void setState(std::span<const double> point);
  /// The vertices of an obstacle as seen at `time` <= time() [s], in its frame, and a bound on
  /// their speed from then on [m/s]. Both replace its motion for good. Throws
  /// std::invalid_argument, and changes nothing, for an unknown obstacle, another number of
  /// vertices, NaN, a time after time(), or a speed bound that is not >= 0.
  void setVertices(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                   double time, double speed_bound);
  /// The pose of an object that has a motion (Object::motion) as seen at `time` <= time() [s], and
  /// bounds from then on, on the speed of its frame's origin [m/s] and on its turning [rad/s]. They
  /// replace its motion for good. Throws std::invalid_argument, and changes nothing, for another
  /// object, a pose that is not finite or not a rotation, a time after time(), or bounds below 0.
  void setPose(const std::string& object, const robots::Pose& X_WO, double time, double speed_bound,
               double turn_bound);
  /// All balls of an object with a cloud and a motion (Object::motion), as seen at `time` <= time()
  /// [s] in the frame X_WO, and a bound on the speed of their points from then on [m/s]. Without
  /// X_WO the frame stays where it was. The balls replace those before and the object's motion for
  /// good: nothing of the old cloud stays, and what the new one lacks counts as free. Throws
  /// std::invalid_argument, and changes nothing, for another object, a cloud that is older than the
  /// last one, cropped, carved elsewhere or that cloudFault() refuses, and as setPose().
  /// O(balls log(balls)).
  void setCloud(const std::string& object, std::shared_ptr<const PointCloud> cloud, double time,
                double speed_bound, const std::optional<robots::Pose>& X_WO = {});

  /// The scene as it was at the last look: constant, for any thread.
  std::shared_ptr<const CompiledScene> scene() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

enum class ReplanStatus : unsigned char {
  kReached,         ///< in a goal; ReplanResult::certified: whether every step was certified
  kExposed,         ///< an obstacle may reach the robot, which stands (ReplanStep::exposed)
  kUnsafe,          ///< at the last step nothing could be certified
  kTimeout,         ///< Execution::duration has passed
  kStopped,         ///< by the caller, or the number of steps
  kNothingChecked,  ///< no pair of shapes is checked: no step is taken
};
/// "reached", "exposed", "unsafe", "timeout", "stopped", "nothing_checked"
const char* toString(ReplanStatus status);

/// A whole execution.
struct ReplanResult {
  ReplanStatus status = ReplanStatus::kStopped;
  std::uint64_t seed = 0;
  std::vector<std::string> names;      ///< of the planned variables
  std::vector<TimedPoint> trajectory;  ///< what was executed
  double duration = 0;                 ///< of that [s]
  int steps = 0, plans = 0, follows = 0, waits = 0, evasions = 0;
  int replans = 0;                           ///< plans besides the first
  Interval clearance;                        ///< the least of all steps [m]
  bool certified = false;                    ///< every step was
  std::vector<UncheckedPairs> unchecked;     ///< pairs that the certificate does not cover
  double compute_s = 0, longest_step_s = 0;  ///< of computing [s]
};

/// Takes steps until a goal is reached, a step is not certified, or the execution's time is up.
/// Calls `on_step`, unless empty, after every step; `steps` > 0 limits their number.
ReplanResult replan(const Problem& problem, const ReplanOptions& options = {},
                    const std::function<void(const ReplanStep&)>& on_step = {}, int steps = 0);

/// A line of an execution's log, without the line's end: one JSON document a step, and one of the
/// whole execution as the last line. `leeway replan --help` lists the keys. Numbers read back to
/// the bit. The log states what was observed and the motion that was executed, for verifyLog(). The
/// key `sum` at the end of a line shows that the line was not changed by accident (lineSum()).
/// `load_s`: the time in which the problem was read [s].
std::string logLine(const Problem& problem, const ReplanStep& step);
std::string logLine(const Problem& problem, const ReplanResult& result, double load_s = 0);

/// Writes an executed trajectory as CSV: a header of `time` and the joints' names, 17 digits. Whole
/// or not at all; throws robots::InputError.
void writeTrajectory(const std::string& file, const Problem& problem,
                     std::span<const TimedPoint> trajectory);

}  // namespace leeway::planner
