#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::planner {

/// Names of interpolations.
inline constexpr const char* kJointLinear = "joint-linear";
inline constexpr const char* kPlaneGeodesic = "SE(2) geodesic";
inline constexpr const char* kSpaceGeodesic = "SE(3) geodesic";

/// The planned variables of a group: their indices, their interpolation, and the distance of two
/// points. Planner, certificate, verifier and files all interpolate here. A point is a span of
/// size() doubles in group order [rad or m]. Joints follow straight lines. Continuous joints and
/// the angles of planar ones go the shorter way. Floating joints move their origin on a line and
/// turn at a constant rate about a fixed axis. Functions rely on points of that size.
class ConfigurationSpace {
 public:
  enum class Kind : unsigned char {
    kLine,
    kCircle,
    kRotation,  ///< four numbers, a quaternion xyzw
  };
  struct Part {
    Kind kind;
    int first;  ///< index into the point
    double
        weight;  ///< in distance(): 1; for a body's turn half its reach to its farthest point [m]
  };

  /// `variables` are indices into Model::variables. Throws std::invalid_argument for an index that
  /// does not exist or is listed twice, for part of an orientation, and without a model.
  ConfigurationSpace(std::shared_ptr<const robots::Model> model, std::vector<int> variables);

  int size() const { return static_cast<int>(variables_.size()); }
  std::span<const Part> parts() const { return parts_; }
  std::span<const int> variables() const { return variables_; }
  const robots::Model& model() const { return *model_; }
  double lower(int i) const { return lower_[static_cast<std::size_t>(i)]; }
  double upper(int i) const { return upper_[static_cast<std::size_t>(i)]; }

  /// Writes dq such that the edge is a + t dq. Circles go the shorter way. Rotations are a rotation
  /// vector (body frame) in the first three numbers, with 0 in the fourth.
  void difference(std::span<const double> a, std::span<const double> b, std::span<double> dq) const;
  /// Writes the point at t in [0, 1] of the edge from a along dq. Circles are wrapped to [-pi, pi).
  void advance(std::span<const double> a, std::span<const double> dq, double t,
               std::span<double> result) const;
  /// Writes the point at t in [0, 1] of the edge from a to b; at t = 0 and 1 exactly a and b.
  void interpolate(std::span<const double> a, std::span<const double> b, double t,
                   std::span<double> result) const;
  /// The greatest change of a variable between a and b, of an orientation its turn [rad or m].
  double greatestChange(std::span<const double> a, std::span<const double> b) const;
  /// Weighted Euclidean length of difference(). It mixes rad and m, except for turns of whole
  /// bodies.
  double distance(std::span<const double> a, std::span<const double> b) const;
  /// Throws std::invalid_argument, with a message that begins with `call`, for a waypoint that does
  /// not have size() numbers.
  void requirePath(std::span<const std::vector<double>> waypoints, const char* call) const;
  /// True for finite numbers inside the limits, with orientations of unit length to within 1e-6.
  bool withinLimits(std::span<const double> a) const;
  /// The first variable that is outside its limits, in words: "joint2 = 3 is outside -1 to 1";
  /// empty: none is.
  std::string brokenLimit(std::span<const double> a) const;
  /// Adds whole turns to the circles of `next` so that each is at most half a turn from `previous`,
  /// and takes the sign of quaternions that is nearer; what already is keeps its bits. Paths and
  /// motions are stored and written in this form: a controller without circles goes the same way.
  void unwrap(std::span<const double> previous, std::span<double> next) const;

  /// The name of this interpolation: kSpaceGeodesic where orientations turn, kPlaneGeodesic with
  /// planar joints, else kJointLinear.
  const char* interpolation() const;

  // Between the rows of a path (plan.h), circles also follow straight lines: from 3 to -3 by 6 rad,
  // through 0.

  /// As difference(), but circles go straight.
  void lineDifference(std::span<const double> a, std::span<const double> b,
                      std::span<double> dq) const;
  /// As interpolate(), but circles go straight and are not wrapped. `result` is neither a nor b.
  void alongLine(std::span<const double> a, std::span<const double> b, double t,
                 std::span<double> result) const;
  /// The number of edges of the space, all of the same length, that make up the line from a to b: 1
  /// unless a circle turns by more than half a turn. 0 if such a circle is beyond 1000 rad, which
  /// no certifier accepts.
  int edgesAlongLine(std::span<const double> a, std::span<const double> b) const;

 private:
  /// How far a part goes from a to b [rad or m].
  static double change(const Part& part, std::span<const double> a, std::span<const double> b);

  std::shared_ptr<const robots::Model> model_;
  std::vector<int> variables_;
  std::vector<Part> parts_;
  std::vector<double> lower_, upper_;
};

/// Returns the rows such that each continues straight from the row before:
/// ConfigurationSpace::unwrap().
std::vector<std::vector<double>> unwrapped(const ConfigurationSpace& space,
                                           std::vector<std::vector<double>> rows);

}  // namespace leeway::planner
