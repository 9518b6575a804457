#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/trajectory.h"

namespace leeway::planner {

/// Assumptions of a Guard, and its limits.
struct GuardOptions {
  double period = 0.02;  ///< from one setpoint to the next [s]
  /// The motion keeps these. Without velocities: motionLimits() of the problem.
  MotionLimits limits;
  /// Tracking error: how far each planned variable is from the motion at most [rad or m]; empty: 0.
  std::vector<double> joint_errors;
  /// How far any point of the robot may be, besides, from where its joints place it [m]. Every pair
  /// keeps twice that, because both of its bodies may be links.
  double point_error = 0;
  int most_setpoints = 64;  ///< of one call
  /// The most that one call may cost, in units of collision::Work (about a thousand a
  /// microsecond). Setpoints that are not decided within it do not pass.
  std::int64_t work = 2'000'000;
  /// For how long after look() obstacles that move are bounded [s]. A chunk with its stop, and the
  /// delay of the next look(), must fit: what comes later does not pass.
  double horizon = 2;
  static constexpr double kLeastPeriod = 1e-4;   ///< [s]
  static constexpr int kMostSetpoints = 10'000;  ///< that `most_setpoints` may be
};

/// Why setpoints do not pass.
enum class GuardReason : unsigned char {
  kPassed,        ///< all do
  kLimit,         ///< a limit on position, velocity, acceleration or jerk; of a request without
                  ///< setpoints, one that is broken where the motion begins
  kNotFree,       ///< a pair comes to its margin
  kNotCertified,  ///< a pair may: neither is proven
  kWork,          ///< the call's work is used up
  kStale,         ///< obstacles that move were seen too long ago
  kJumped,        ///< an obstacle was seen farther away than its speed bound allows
  kInvalid,       ///< the request: another size, too many setpoints, numbers that are not finite, a
                  ///< time before the last one, or one so large that doubles near it are coarse;
                  ///< polynomials of another duration, or that begin elsewhere
};
/// "passed", "limit", "not_free", "not_certified", "work", "stale", "jumped", "invalid"
const char* toString(GuardReason reason);

enum class MotionLimit : unsigned char { kPosition, kVelocity, kAcceleration, kJerk };
const char* toString(MotionLimit limit);  ///< "position", "velocity", "acceleration", "jerk"

/// Where the robot is, and where it should go: by setpoints, or on polynomials.
struct GuardRequest {
  /// Rows of one value a planned variable in group order, one row a period [rad or m].
  std::span<const double> setpoints = {};
  /// One polynomial a planned variable, in group order: where the robot is t seconds after the
  /// motion begins. The coefficients of 1, t, t^2, ... of the first variable, then of the next
  /// ones, as many for each, and at most kMostTerms [rad/s^k or m/s^k]. At t = 0 they are within
  /// 1e-9 of where the motion begins (GuardAnswer::start).
  std::span<const double> polynomials = {};
  double duration =
      0;  ///< of the polynomials: a whole number of periods, at most most_setpoints [s]
  static constexpr int kMostTerms = 8;
  /// Where the robot was measured. Within GuardOptions::joint_errors (and 1e-9) of the motion of
  /// the last answer, that motion goes on from where it is; farther off, and in the first call, the
  /// next motion begins here. Whole turns of a continuous joint do not count: setpoints go on in
  /// the commanded turn or in the measured one, whichever the first of them is nearer to. Empty: on
  /// that motion; in the first call, the problem's start.
  std::span<const double> position = {};
  /// Where the motion begins at `position`: its velocity there [rad/s or m/s]. Empty: that of the
  /// last answer's motion; in the first call, rest. Where the motion begins, and this, or in the
  /// first call `position`, is not readable, nothing is certified until a position is given. The
  /// acceleration where the motion begins counts as 0: the jerk of the first row is counted from
  /// there, also that of a stop.
  std::span<const double> velocity = {};
  /// The time of this call [s]. Default: the robot has gone through what the last answer passed,
  /// and at least one period; in the first call Execution::start. Doubles near it must be at most
  /// 0.001 periods apart: seconds since 1970 serve for periods down to 0.24 ms, nanoseconds do not.
  std::optional<double> time = {};
};

/// The answer of Guard::check(). Spans and names hold until the next call.
struct GuardAnswer {
  /// The first setpoints that may be executed; the first periods of polynomials [count].
  int passed = 0;
  /// `motion` is proven. False where not even a stop is, and from then on, until one is again.
  bool certified = false;
  /// The setpoints that passed, then those of the stop; one row a period, from `time` + period on.
  /// Empty: stay where you are. Where nothing passes, the stop is one from the present state, or
  /// what is left of the last answer's motion. After the last row the robot rests.
  std::span<const double> motion;
  /// The first rows of `motion`, to which the robot follows polynomials: those of this request, or,
  /// where the motion goes on, what is left of those before [count]. To all others, and in the
  /// stop, it goes in straight lines.
  int on_polynomials = 0;
  double time = 0;                ///< of the call [s]
  std::span<const double> start;  ///< where the motion begins
  bool goes_on = false;  ///< the motion is what is left of the last answer's: no new stop is proven

  GuardReason reason = GuardReason::kInvalid;  ///< why the next setpoint does not pass
  /// It concerns the stop that would follow that setpoint, not the way to it.
  bool in_stop = false;
  std::string_view a, b;  ///< the pair's bodies, where known; kJumped: `a` is the obstacle
  int variable = -1;      ///< kLimit: which planned variable, in group order,
  MotionLimit limit = MotionLimit::kPosition;
  double value = 0, allowed = 0;  ///< what it would be, and the limit

  std::uint64_t edges = 0, distance_queries = 0;  ///< asked by this call [count]
  std::int64_t work = 0;                          ///< spent [units of collision::Work]
};

/// The result of an observation.
enum class Observation : unsigned char {
  kTaken,
  kJumped,   ///< taken; but it moved, or turned, faster than a bound that was given before
  kInvalid,  ///< refused: another number of vertices, numbers that are not finite, a pose whose
             ///< matrix is not a rotation, a cloud without balls, a carved cloud elsewhere. The
             ///< last one stays
  kLate,     ///< refused: older than the last one, or its time is not finite
};
const char* toString(Observation observation);  ///< "taken", "jumped", "invalid", "late"

/// Stands between a source of setpoints (a policy, a servo loop, an operator) and the robot's
/// position controller. Of each chunk of setpoints it lets the longest beginning pass that is
/// proven to keep all margins and limits, with a stop at its end that is proven as well.
///
/// The motion. From setpoint to setpoint joints go in straight lines at constant speed, as position
/// controllers interpolate. Acceleration is the change of that velocity over a period, jerk that of
/// acceleration. If a call comes within a period, the acceleration limit applies to the time since
/// that period began. A stop is further setpoints. Without
/// limits on jerk it goes on along the line of the last two setpoints and brakes as hard as the
/// limits allow; with them each joint brakes for itself. Polynomials keep the limits by their
/// derivatives, at every time; where they begin, and where a stop begins, velocity and acceleration
/// may change as from setpoint to setpoint. Straight lines between their places at whole periods
/// are proven with margins that grow by T^2 / 8 times their greatest second derivative: what is
/// nearer than that does not pass (kNotCertified).
///
/// Guarantees, if the robot follows the answer's motion to within the tracking error of the
/// options:
/// - No pair, of world or self, comes to its margin on the motion, at any time: edges are proven as
///   wholes (EdgeCertifier), without sampling.
/// - That holds among obstacles that deform and objects with a motion as well, if their motion, or
///   the bound on their speed, holds, and as long as the robot moves. A robot at rest cannot avoid
///   an obstacle that comes to it.
/// - The motion of the last answer is always a way to come to rest: if the next call comes late, or
///   never, it is safe to execute that motion to its end.
/// Setpoints pass only with a proof. Undecided edges, work that is used up, and obstacles that were
/// not seen stop the robot.
///
/// The cost of a call. Several setpoints are proven by one edge, with a separation that covers how
/// far they are from it; it is divided where it is not free. check() allocates nothing and does not
/// throw. The same calls in the same order give the same answers. One object is for one thread.
class Guard {
 public:
  /// `problem`: its robot, world, margins, and limits of execution; goals are not needed. Throws
  /// robots::InputError as validate() does, and for a problem with steps or constraints, floating
  /// joints, no pair that is checked, and options out of range. Compiles the problem, and looks at
  /// its obstacles at Execution::start.
  explicit Guard(const Problem& problem, const GuardOptions& options = {});
  ~Guard();
  Guard(Guard&&) noexcept;
  Guard& operator=(Guard&&) noexcept;

  /// Returns how many setpoints pass, and the motion through them with the stop after it. Asks
  /// O(setpoints) edges at worst, and those of stops; where there is room, one of each.
  const GuardAnswer& check(const GuardRequest& request) noexcept;

  /// The vertices of a deforming obstacle as seen at `time` [s], in its frame, and a bound on their
  /// speed from then on [m/s]. Both replace its motion for good, and count from the next look() on.
  /// After a jump nothing passes until an observation agrees with the one before. After a jump, a
  /// greater bound, or the end of a motion nothing is proven until the next look(), not even what
  /// was left of the last answer's motion: call both together. Throws
  /// std::invalid_argument for an unknown obstacle, and a speed bound that is not >= 0.
  Observation setVertices(const std::string& object, std::span<const Eigen::Vector3d> vertices,
                          double time, double speed_bound);
  /// The pose of an object that has a motion (Object::motion) as seen at `time` [s], and bounds
  /// from then on, on the speed of its frame's origin [m/s] and on its turning [rad/s]. The rest as
  /// for setVertices().
  Observation setPose(const std::string& object, const robots::Pose& X_WO, double time,
                      double speed_bound, double turn_bound);
  /// All balls of an object with a cloud and a motion, as seen at `time` [s] in the frame X_WO, and
  /// a bound on the speed of their points from then on [m/s]; see Replanner::setCloud(). Clouds
  /// never jump, because their balls do not correspond. But nothing is proven from a new cloud on
  /// until the next look(), not even what was left of the last answer's motion: call both together.
  /// kInvalid: a cloud that is missing, cropped, or that cloudFault() refuses. The rest as for
  /// setPose(). Makes the cloud's hierarchy: O(balls log(balls)).
  Observation setCloud(const std::string& object, std::shared_ptr<const PointCloud> cloud,
                       double time, double speed_bound,
                       const std::optional<robots::Pose>& X_WO = {});
  /// Bounds where obstacles can be from `time` [s] on: by their motions, or by what was seen of
  /// them, grown by their speed bounds times its age (and backwards, by the bound before, for times
  /// between the last two observations; earlier, and before a cloud's time, nothing passes). Costs
  /// the update of their hierarchies; call it before check(). Without obstacles that move it does
  /// nothing. Throws robots::InputError for a motion that fails, std::invalid_argument for a time
  /// that is not finite.
  void look(double time);

  /// The time of a request without one [s].
  double nextTime() const;
  /// Whether the next request may have this time; see GuardRequest::time.
  bool takesTime(double time) const;
  const GuardOptions& options() const;
  /// That margins are taken from; with point errors and joint errors in the margins.
  const std::shared_ptr<const CompiledScene>& scene() const;
  const GuardAnswer& answer() const;  ///< the last one; before the first it is kInvalid

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace leeway::planner
