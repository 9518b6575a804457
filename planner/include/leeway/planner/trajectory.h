#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"

namespace leeway::planner {

/// What the planned variables' motion must not exceed, one number a variable in group order; of a
/// floating joint's orientation (four numbers) the first stands for the angle of the rotation.
struct MotionLimits {
  std::vector<double> velocity;      // [rad/s or m/s], positive and finite
  std::vector<double> acceleration;  // [rad/s^2 or m/s^2], positive and finite
  std::vector<double> jerk;          // [rad/s^3 or m/s^3], positive; infinite or empty: no limit
};

/// What a problem's execution says: its velocities or else defaultMotionLimits()', each times its
/// speed; its accelerations and jerks. O(variables).
MotionLimits motionLimits(const Problem& problem);

/// The velocity limits of the URDF (1 rad/s or m/s where a joint has none), and accelerations that
/// reach them from rest in half a second; no limit on jerk. O(variables).
MotionLimits defaultMotionLimits(const ConfigurationSpace& space);

/// From rest to rest over a way of 1, as fast as constant limits on speed, acceleration and jerk
/// allow: three phases, seven with a limit on jerk (double S: L. Biagiotti, C. Melchiorri,
/// "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4).
class RestToRest {
 public:
  /// All positive; acceleration and speed finite.
  RestToRest(double speed, double acceleration, double jerk);

  struct State {
    double way = 0, speed = 0, acceleration = 0;
  };
  double duration() const { return 2 * rise_ + cruise_; }
  /// At rest before 0 and from duration() on; where acceleration jumps, as it is afterwards.
  State at(double time) const;
  /// Where acceleration or its derivative jumps, both ends among them, ascending [s].
  std::vector<double> knots() const;

 private:
  State rising(double time) const;

  double rise_ = 0, ramp_ = 0, cruise_ = 0;  // [s]: speeding up, ramping acceleration, full speed
  double peak_ = 0, peak_acceleration_ = 0, jerk_ = 0;
};

/// A corner that is cut. The motion leaves the edge before waypoint `corner` at `length` from it
/// and joins the one after at `length` behind it (Euclidean norm of the numbers of
/// ConfigurationSpace::difference()). Between, it is the quadratic Bezier curve with those two
/// places and the corner as its control points, so that direction and speed do not jump.
struct Blend {
  int corner;
  double length;
};

/// Blends of a path whose edges are certified: for each corner the longest of several cuts, up to
/// half of the shorter edge, that is proven to keep all margins, as chords from which the curve
/// departs by less than is added to the margins. Corners where none is proven have no blend, and so
/// have all of a space with rotations (floating joints). The waypoints are those of Trajectory.
/// Deterministic. O(waypoints) edges to certify.
std::vector<Blend> certifiedBlends(const std::shared_ptr<const CompiledScene>& scene,
                                   std::span<const std::vector<double>> waypoints);

/// From `start` [s] on, until the next phase starts: s = way + rate dt + acceleration dt^2 / 2, s
/// being the way along one piece of a curve.
struct TimedPhase {
  double start;
  int piece;
  double way, rate, acceleration;
};

/// A path with times. It runs over the very edges that were certified, and comes to rest at each
/// corner that is not blended, so that every configuration it takes is one of the certificate's or
/// of a blend; edges in line with each other are run through. From rest to rest without blends
/// nothing within the limits is faster: the joints move in proportion, and the one that is nearest
/// to its limit is kept at it. With blends it is as fast as accelerations along the path allow that
/// are constant on a sixteenth of a blend.
class Trajectory {
 public:
  /// `waypoints` as in Path::positions, joined by space.interpolate(). Throws std::invalid_argument
  /// for rows or limits of another size, limits that are not positive, and blends that are out of
  /// order, longer than their edges, in a space with rotations, or beside a limit on jerk.
  /// O(waypoints).
  Trajectory(std::shared_ptr<const ConfigurationSpace> space,
             std::vector<std::vector<double>> waypoints, const MotionLimits& limits,
             std::span<const Blend> blends = {});

  double duration() const { return times_.back(); }  // [s]
  const ConfigurationSpace& space() const { return *space_; }
  std::span<const std::vector<double>> waypoints() const { return waypoints_; }
  std::span<const Blend> blends() const { return blends_; }
  /// When each waypoint is passed, or the middle of its blend [s].
  std::span<const double> times() const { return times_; }
  /// When acceleration along the path, or its derivative, jumps, and when waypoints are passed:
  /// ascending, from 0 to duration() [s]. Between two of these an edge is gone along with constant
  /// jerk, so that the cubic through configurations and velocities there is the motion itself.
  std::vector<double> knots() const;

  /// Where on the path the robot is: on the edge from waypoint `edge`, at t in [0, 1] of it, or,
  /// with `blend` >= 0, at the parameter t in [0, 1] of that blend (`edge` being the one before the
  /// corner); with dt/dtime and its derivative [1/s, 1/s^2].
  struct Place {
    int edge = 0;
    int blend = -1;
    double t = 0, rate = 0, acceleration = 0;
  };
  Place place(double time) const;
  /// When t in [0, 1] of an edge is passed [s]; nothing where a blend cuts it off. O(waypoints).
  std::optional<double> passes(int edge, double t) const;
  /// The configuration at `time` [s] (held before 0 and after duration()); O(log waypoints).
  void configuration(double time, std::span<double> q) const;
  /// Its rate of change, as space.difference() has it (rotations: a rotation vector's rate), and
  /// second derivative. O(log waypoints).
  void velocity(double time, std::span<double> rate) const;
  void acceleration(double time, std::span<double> second) const;

 private:
  /// Part of a bent stretch: what cuts leave of an edge, or a blend.
  struct Piece {
    int edge, blend;
  };
  struct Stretch {  // from rest to rest
    int first_edge, edges;
    double start;  // [s]
    /// Over one edge or several in line; nothing: over pieces.
    std::optional<RestToRest> profile;
    std::vector<Piece> pieces = {};
    std::vector<TimedPhase> phases = {};
  };
  void check(const MotionLimits& limits) const;
  /// In line with, or joined by a blend to, the edge before: the stretch that begins at edge
  /// `first`.
  int stretchEnd(int first) const;
  void addStraight(int first, int last, const MotionLimits& limits, double now);
  void addBent(int first, int last, const MotionLimits& limits, double now);
  const Blend* blendAt(int corner) const;
  Place placeOn(const Stretch& stretch, double time) const;
  void derivative(double time, bool second, std::span<double> result) const;

  std::shared_ptr<const ConfigurationSpace> space_;
  std::vector<std::vector<double>> waypoints_, differences_;
  std::vector<double> lengths_;  // of the edges, Euclidean
  std::vector<Blend> blends_;
  std::vector<double> ends_;  // of each edge, as a share of its straight stretch
  std::vector<Stretch> stretches_;
  std::vector<double> times_;
};

/// The trajectory of a path as the problem's execution has it: its limits, and blends where it asks
/// for them and limits no jerk; the problem is compiled for these. The path's edges must be
/// certified for the problem.
Trajectory trajectoryOf(const Problem& problem, const Path& path);

}  // namespace leeway::planner
