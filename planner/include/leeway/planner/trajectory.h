#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"

namespace leeway::planner {

/// Limits on the motion of planned variables, one number per variable in group order. The
/// orientation of a floating joint has four numbers; the first is the limit of the angle of
/// rotation.
struct MotionLimits {
  std::vector<double> velocity;      // [rad/s or m/s], positive and finite
  std::vector<double> acceleration;  // [rad/s^2 or m/s^2], positive and finite
  std::vector<double> jerk;          // [rad/s^3 or m/s^3], positive; infinite or empty: no limit
};

/// The limits of a problem's execution: its velocities, accelerations and jerks, by default those
/// of defaultMotionLimits(), times its speed, acceleration_scale and jerk_scale. O(variables).
MotionLimits motionLimits(const Problem& problem);

/// The robot's own limits. By default, the velocity is at most kDefaultVelocity and is reached in
/// half a second, and jerk is unlimited. O(variables).
MotionLimits defaultMotionLimits(const ConfigurationSpace& space);

/// Limits on a motion along a line, in its units of length: positive. An infinite jerk: no limit.
struct LineLimits {
  double speed, acceleration;
  double jerk = std::numeric_limits<double>::infinity();
};

/// A speed that rises from `from` to `to` within `time`: with constant acceleration, except that
/// acceleration rises linearly over the first `ramp` of the time and falls over the last.
struct SpeedChange {
  double from = 0, to = 0;
  double time = 0, ramp = 0;  ///< [s]; ramp in [0, time / 2]

  SpeedChange() = default;
  SpeedChange(double first, double last, double duration, double ramp_time)
      : from(first), to(last), time(duration), ramp(ramp_time) {}
  /// The fastest change within limits on acceleration and jerk. Takes no time unless first < last.
  SpeedChange(double first, double last, const LineLimits& limits);

  /// The same change in as much time or a little more: no phase of it is shorter than 0.1 ms, so
  /// that cubics through rounded numbers keep its limits. Rises with the change, as the fastest.
  SpeedChange withLongPhases() const;

  struct State {
    double way = 0, speed = 0, acceleration = 0;
  };
  double way() const { return (from + to) / 2 * time; }
  /// At t in [0, time]. Where acceleration jumps: its value before the jump.
  State at(double t) const;
};

/// The fastest motion over a length from one speed to another under constant limits on speed,
/// acceleration and jerk, whose acceleration is 0 at both ends if jerk is limited: three phases,
/// seven with a limit on jerk, none shorter than 0.1 ms where the length has room (double S: L.
/// Biagiotti, C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008,
/// section 3.4).
class SpeedProfile {
 public:
  /// Speed and acceleration are finite. Throws std::invalid_argument for limits or a length that
  /// are not positive, and for speeds below 0 or above the limit. The length must suffice for the
  /// change of speed: see mostSpeedAfter(). O(1).
  SpeedProfile(const LineLimits& limits, double length, double first = 0, double last = 0);

  using State = SpeedChange::State;
  double duration() const { return rise_.time + cruise_ + fall_.time; }
  double length() const { return length_; }
  /// Before 0 and from duration() on: at the ends, without acceleration. Where acceleration jumps:
  /// its value after the jump.
  State at(double time) const;
  /// The time at which `way` is reached [s]. Bisects, because it has no simple inverse.
  double timeAt(double way) const;
  /// Times at which acceleration or its derivative jumps, both ends included, ascending [s].
  std::vector<double> knots() const;
  /// The same without allocation. Times may repeat.
  std::array<double, 8> knotArray() const;

 private:
  SpeedChange rise_, fall_;  // fall_ runs backwards from the end
  double cruise_ = 0, length_ = 0;
};

/// The highest speed, up to the limit, that can be reached over a length from `speed` with an
/// acceleration of 0 at both ends if jerk is limited. Also the highest speed from which `speed` can
/// be reached.
double mostSpeedAfter(const LineLimits& limits, double speed, double length);

/// A corner that is cut. The motion leaves the edge before waypoint `corner` at a distance of
/// `before` from it, and joins the next edge at a distance of `after` (Euclidean norm of
/// ConfigurationSpace::difference()). Between, its velocity changes from that on one edge to that
/// on the other along a straight line, as SpeedChange says with a ramp of this share of its time.
/// So every joint moves on up to three cubics, velocity does not jump, and with a ramp above 0
/// neither does acceleration. Without a ramp it is a parabola.
struct Blend {
  int corner;
  double before, after;
  double ramp = 0;  ///< in [0, 0.5]
};

/// Where a motion leaves the edges of its path.
struct Cuts {
  std::vector<Blend> blends;  ///< by ascending corner
  /// Waypoints that are left out, ascending: an edge joins those beside them.
  std::vector<int> left_out = {};
  /// Everything of the cuts keeps this distance, and its margins [m]; -infinity: its margins.
  double clearance = -std::numeric_limits<double>::infinity();
};

/// Cuts of a path whose edges are certified, which make its motion within the limits shorter.
/// Leaves out waypoints that are within kStraightening of the line between those beside them, and
/// blends the corners of the others: with lengths that give a short time, reduced until they are
/// proven. Cuts keep the margins, and half of the path's clearance above the margins. Proves edges,
/// and chords of blends with margins grown by more than the curve departs from them. Corners
/// without a proof are passed at rest; paths with rotations (floating joints) are not cut.
/// Waypoints as for Trajectory. Deterministic. Certifies O(waypoints) edges. Throws
/// std::invalid_argument without a scene, for a waypoint of another size, and for limits as
/// Trajectory.
Cuts certifiedCuts(const std::shared_ptr<const CompiledScene>& scene,
                   std::span<const std::vector<double>> waypoints, const MotionLimits& limits);

struct Leg;  // private: consecutive edges in one line

/// A path with times. It follows the certified edges themselves, and rests after each step of a
/// task and at each corner that is not cut, unless the edges are in line: every configuration is
/// one of the certificate's or of a cut. Each leg is passed as fast as the limits allow: its joints
/// move in proportion, the one nearest to its limit at that limit. A blend takes a constant
/// multiple of the least time that its limits allow, so that the legs beside it reach its speeds.
/// At every time joints move on cubics, between those of knots(). Its places are unwrapped().
class Trajectory {
 public:
  /// `waypoints` as in Path::positions, joined by space.interpolate(). Throws std::invalid_argument
  /// for rows or limits of another size, limits that are not positive, and blends that are out of
  /// order, longer than their edges, without a ramp beside a limit on jerk, in a space with
  /// rotations, or that leave no length for coming to rest at the other end of an edge, and for
  /// waypoints left out that are out of order or are ends or corners of blends. `least_times`: of
  /// each edge, what it takes at least at a constant rate [s]; an edge that joins the waypoints
  /// beside those left out takes their sum. `steps`: those of a task's path; nothing may be cut
  /// where one ends. O(waypoints).
  Trajectory(std::shared_ptr<const ConfigurationSpace> space,
             std::vector<std::vector<double>> waypoints, const MotionLimits& limits, Cuts cuts = {},
             std::span<const double> least_times = {}, std::span<const PathStep> steps = {});

  double duration() const { return times_.back(); }  // [s]
  const ConfigurationSpace& space() const { return *space_; }
  std::span<const std::vector<double>> waypoints() const { return waypoints_; }
  const Cuts& cuts() const { return cuts_; }
  /// The steps of a task's path, in numbers of waypoints().
  std::span<const PathStep> steps() const { return steps_; }
  /// Waypoints at which the motion cuts the corner: those of blends, and those left out. Ascending.
  std::vector<int> cutCorners() const;
  /// The time at which each waypoint, or the middle of its blend, is passed [s]. Waypoints that are
  /// left out are between those beside them.
  std::span<const double> times() const { return waypoint_times_; }
  /// Times at which acceleration, or its derivative, jumps, and those of waypoints that are passed:
  /// ascending, from 0 to duration() [s], without waypoints within 20 us of another. Between two of
  /// them every joint has constant jerk: it moves on the cubic through its positions and velocities
  /// at both. (Orientations: their rotation vector does.)
  std::vector<double> knots() const;

  /// A place on the path: t in [0, 1] of the edge from waypoint `edge` to the next one that is not
  /// left out; with `blend` >= 0, t in [0, 1] of that blend, whose corner ends `edge`. `rate` is
  /// dt/dtime [1/s], `acceleration` its derivative [1/s^2].
  struct Place {
    int edge = 0;
    int blend = -1;
    double t = 0, rate = 0, acceleration = 0;
  };
  Place place(double time) const;
  /// The time at t in [0, 1] of an edge [s]; nothing if a cut leaves this point out. O(waypoints).
  std::optional<double> passes(int edge, double t) const;
  /// The configuration at `time` [s] (held before 0 and after duration()). These three neither
  /// allocate nor throw, and may be called from several threads; O(log waypoints).
  void configuration(double time, std::span<double> q) const;
  /// The configuration's first and second derivative, in the numbers of space.difference()
  /// (rotations: of a rotation vector).
  void velocity(double time, std::span<double> rate) const;
  void acceleration(double time, std::span<double> second) const;

 private:
  /// A part of a leg, or a blend.
  struct Piece {
    double start;  // [s]
    int edge;      // the leg's first one, or the one before the blend
    int last;      // the leg's last one
    int blend;     // -1: part of a leg
    double begin;  // the leg's length before this part
    double time;   // of the blend [s]
    std::optional<SpeedProfile> profile;
  };
  void check(const MotionLimits& limits, std::span<const PathStep> steps) const;
  void leaveOut();
  int keptIndex(int waypoint) const;
  void checkRoom(std::span<const Leg> legs, std::span<const int> leg_of) const;
  void addPieces(std::span<const Leg> legs, std::span<const double> blend_times);
  void timeWaypoints();
  const Blend* blendAt(int corner) const;
  Place placeInside(double time) const;
  Place placeOn(const Piece& piece, double time) const;
  void derivative(double time, bool second, std::span<double> result) const;

  std::shared_ptr<const ConfigurationSpace> space_;
  std::vector<std::vector<double>> waypoints_;
  Cuts cuts_;
  std::vector<PathStep> steps_;
  std::vector<double> waypoint_times_;
  // The members below, and the functions above, number the waypoints that are not left out.
  std::vector<double> least_times_;  // of the edges at a constant rate; empty: none
  std::vector<int> kept_;            // in waypoints_
  std::vector<std::vector<double>> points_, differences_;
  std::vector<double> lengths_;  // of the edges, Euclidean
  std::vector<Blend> blends_;
  std::vector<double> ends_;  // of each edge: its leg's length up to there
  std::vector<Piece> pieces_;
  std::vector<double> times_;
};

/// Returns the trajectory of a path within the limits of the problem's execution. If the execution
/// wants blends, it has certifiedCuts(), which require the problem to be compiled. Beside
/// constraints, and on lines of a task, corners are blended where the blend is proven to keep the
/// constraints, or the line's tolerances; between the steps of a task, with a condition, and where
/// bodies turn freely, the motion rests. The path's edges must be certified for the problem. The
/// waypoints are those of edgesOf() the path. Lines of a task keep the speed of their frames
/// (LineStep::speed). Errors as edgesOf(); std::invalid_argument for the path of a task without its
/// steps.
Trajectory trajectoryOf(const Problem& problem, const Path& path);

/// The motion as a path, which verify() proves as it is executed: its rows at knots(), with times
/// and velocities (Path::times), and the steps of a task in numbers of these rows. Throws
/// std::invalid_argument for a space with rotations.
/// O(knots).
Path motionOf(const Trajectory& trajectory);

}  // namespace leeway::planner
