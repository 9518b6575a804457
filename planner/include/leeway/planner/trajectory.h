#pragma once

#include <array>
#include <span>
#include <vector>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// What the planned variables' motion must not exceed, one number a variable in group order; of a
/// floating joint's orientation (four numbers) the first stands for the angle of the rotation.
struct MotionLimits {
  std::vector<double> velocity;      // [rad/s or m/s], positive and finite
  std::vector<double> acceleration;  // [rad/s^2 or m/s^2], positive and finite
  std::vector<double> jerk;          // [rad/s^3 or m/s^3], positive; infinite or empty: no limit
};

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
  /// At rest before 0 and after duration().
  State at(double time) const;

 private:
  State rising(double time) const;

  double rise_ = 0, ramp_ = 0, cruise_ = 0;  // [s]: speeding up, ramping acceleration, full speed
  double peak_ = 0, peak_acceleration_ = 0, jerk_ = 0;
};

/// A path with times. It runs over the very edges that were certified, from rest at each corner to
/// rest at the next, so that every configuration it takes is one of the certificate's; edges in
/// line with each other are run through. Between corners nothing within the limits is faster:
/// the joints move in proportion, and the one that is nearest to its limit is kept at it.
class Trajectory {
 public:
  /// `waypoints` as in Path::positions, joined by space.interpolate(). Throws std::invalid_argument
  /// for rows or limits of another size, or limits that are not positive. O(waypoints).
  Trajectory(std::shared_ptr<const ConfigurationSpace> space,
             std::vector<std::vector<double>> waypoints, const MotionLimits& limits);

  double duration() const { return times_.back(); }  // [s]
  std::span<const std::vector<double>> waypoints() const { return waypoints_; }
  /// When each waypoint is passed [s].
  std::span<const double> times() const { return times_; }

  /// Where on the path the robot is: on the edge from waypoint `edge`, at t in [0, 1] of it, with
  /// dt/dtime and its derivative [1/s, 1/s^2].
  struct Place {
    int edge = 0;
    double t = 0, rate = 0, acceleration = 0;
  };
  Place place(double time) const;
  /// The configuration at `time` [s] (held before 0 and after duration()); O(log waypoints).
  void configuration(double time, std::span<double> q) const;
  /// Its rate of change, as space.difference() has it (rotations: a rotation vector's rate), and
  /// second derivative. O(log waypoints).
  void velocity(double time, std::span<double> rate) const;
  void acceleration(double time, std::span<double> second) const;

 private:
  struct Stretch {  // from rest to rest over one edge or several in line
    int first_edge, edges;
    double start;  // [s]
    RestToRest profile;
  };
  void derivative(double time, bool second, std::span<double> result) const;

  std::shared_ptr<const ConfigurationSpace> space_;
  std::vector<std::vector<double>> waypoints_, differences_;
  std::vector<double> ends_;  // of each edge, as a share of its stretch
  std::vector<Stretch> stretches_;
  std::vector<double> times_;
};

}  // namespace leeway::planner
