#pragma once

#include <array>
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

/// The limits of a problem's execution: its velocities, by default those of defaultMotionLimits(),
/// times its speed; its accelerations and jerks. O(variables).
MotionLimits motionLimits(const Problem& problem);

/// The robot's own limits. By default, the velocity is at most kDefaultVelocity and is reached in
/// half a second, and jerk is unlimited. O(variables).
MotionLimits defaultMotionLimits(const ConfigurationSpace& space);

/// The fastest motion from rest to rest over a way of 1 under constant limits on speed,
/// acceleration and jerk: three phases, seven with a limit on jerk (double S: L. Biagiotti, C.
/// Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4).
class RestToRest {
 public:
  /// Acceleration and speed are finite. Throws std::invalid_argument unless all are positive.
  RestToRest(double speed, double acceleration, double jerk);

  struct State {
    double way = 0, speed = 0, acceleration = 0;
  };
  double duration() const { return 2 * rise_ + cruise_; }
  /// At rest before 0 and from duration() on. Where acceleration jumps: its value after the jump.
  State at(double time) const;
  /// Times at which acceleration or its derivative jumps, both ends included, ascending [s].
  std::vector<double> knots() const;
  /// The same without allocation. Times may repeat.
  std::array<double, 8> knotArray() const;

 private:
  State rising(double time) const;

  double rise_ = 0, ramp_ = 0, cruise_ = 0;  // [s]: speeding up, ramping acceleration, full speed
  double peak_ = 0, peak_acceleration_ = 0, jerk_ = 0;
};

/// A cut corner. The motion leaves the edge before waypoint `corner` at a distance of `length` from
/// it, and joins the next edge at that distance (Euclidean norm of
/// ConfigurationSpace::difference()). Between, it is the quadratic Bezier curve of these two points
/// and the corner: direction and speed do not jump.
struct Blend {
  int corner;
  double length;
};

/// Blends of a path whose edges are certified: for each corner the longest of several cuts, up to
/// half of the shorter edge, that is proven to keep all margins. The proof certifies chords, with
/// margins grown by more than the curve departs from them. Corners without a proof, and spaces with
/// rotations (floating joints), have no blends. Waypoints as for Trajectory. Deterministic.
/// Certifies O(waypoints) edges. Throws std::invalid_argument without a scene, and for a waypoint
/// of another size.
std::vector<Blend> certifiedBlends(const std::shared_ptr<const CompiledScene>& scene,
                                   std::span<const std::vector<double>> waypoints);

/// From `start` [s] until the next phase, the way along a piece of a curve is s = way + rate dt +
/// acceleration dt^2 / 2.
struct TimedPhase {
  double start;
  int piece;
  double way, rate, acceleration;
};

/// A path with times. It follows the certified edges themselves, and rests at each corner that is
/// not blended, unless the edges are in line: every configuration is one of the certificate's or of
/// a blend. Without blends it is the fastest motion within the limits: joints move in proportion,
/// the one nearest to its limit at that limit. With blends it is the fastest whose acceleration
/// along the path is constant on each sixteenth of a blend.
class Trajectory {
 public:
  /// `waypoints` as in Path::positions, joined by space.interpolate(). Throws std::invalid_argument
  /// for rows or limits of another size, limits that are not positive, and blends that are out of
  /// order, longer than their edges, in a space with rotations, or beside a limit on jerk.
  /// `least_times`: of each edge, what it takes at least at a constant rate [s]; with blends none.
  /// O(waypoints).
  Trajectory(std::shared_ptr<const ConfigurationSpace> space,
             std::vector<std::vector<double>> waypoints, const MotionLimits& limits,
             std::span<const Blend> blends = {}, std::span<const double> least_times = {});

  double duration() const { return times_.back(); }  // [s]
  const ConfigurationSpace& space() const { return *space_; }
  std::span<const std::vector<double>> waypoints() const { return waypoints_; }
  std::span<const Blend> blends() const { return blends_; }
  /// The time at which each waypoint, or the middle of its blend, is passed [s].
  std::span<const double> times() const { return times_; }
  /// Times at which acceleration along the path, or its derivative, jumps, and those of waypoints:
  /// ascending, from 0 to duration() [s]. Between two of them motion along an edge has constant
  /// jerk: it is the cubic through the configurations and velocities at both.
  std::vector<double> knots() const;

  /// A place on the path: t in [0, 1] of the edge from waypoint `edge`; with `blend` >= 0, t in
  /// [0, 1] of that blend, whose corner ends `edge`. `rate` is dt/dtime [1/s], `acceleration` its
  /// derivative [1/s^2].
  struct Place {
    int edge = 0;
    int blend = -1;
    double t = 0, rate = 0, acceleration = 0;
  };
  Place place(double time) const;
  /// The time at t in [0, 1] of an edge [s]; nothing if a blend cuts this point off. O(waypoints).
  std::optional<double> passes(int edge, double t) const;
  /// The configuration at `time` [s] (held before 0 and after duration()). These three neither
  /// allocate nor throw, and may be called from several threads; O(log waypoints).
  void configuration(double time, std::span<double> q) const;
  /// The configuration's first and second derivative, in the numbers of space.difference()
  /// (rotations: of a rotation vector).
  void velocity(double time, std::span<double> rate) const;
  void acceleration(double time, std::span<double> second) const;

 private:
  /// Part of a bent stretch: a blend, or the rest of an edge between blends.
  struct Piece {
    int edge, blend;
  };
  struct Stretch {  // from rest to rest
    int first_edge, edges;
    double start;  // [s]
    /// For one edge or several in line. A bent stretch has pieces and phases instead.
    std::optional<RestToRest> profile;
    std::vector<Piece> pieces = {};
    std::vector<TimedPhase> phases = {};
  };
  void check(const MotionLimits& limits) const;
  /// End of the stretch that begins at edge `first`: its edges are in line, or joined by blends.
  int stretchEnd(int first) const;
  /// How fast the way of all edges from first to last may be passed, so that each takes its least
  /// time at least.
  double rateOf(int first, int last, double length) const;
  void addStraight(int first, int last, const MotionLimits& limits, double now);
  void addBent(int first, int last, const MotionLimits& limits, double now);
  const Blend* blendAt(int corner) const;
  Place placeOn(const Stretch& stretch, double time) const;
  void derivative(double time, bool second, std::span<double> result) const;

  std::shared_ptr<const ConfigurationSpace> space_;
  std::vector<std::vector<double>> waypoints_, differences_;
  std::vector<double> lengths_;  // of the edges, Euclidean
  std::vector<Blend> blends_;
  std::vector<double> least_times_;  // of the edges at a constant rate; empty: none
  std::vector<double> ends_;         // of each edge, as a share of its straight stretch
  std::vector<Stretch> stretches_;
  std::vector<double> times_;
};

/// Returns the trajectory of a path within the limits of the problem's execution. It has blends if
/// the execution wants them, jerk is not limited, and the path does not belong to a task; blends
/// require the problem to be compiled. The path's edges must be certified for the problem. The
/// waypoints are those of edgesOf() the path. Lines of a task keep the speed of their frames
/// (LineStep::speed). Errors as edgesOf().
Trajectory trajectoryOf(const Problem& problem, const Path& path);

}  // namespace leeway::planner
