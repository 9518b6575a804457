#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::planner {

/// The planned variables of a group: which numbers they are, how they interpolate, how far they are
/// apart. The one home of interpolation for planner, certificate, verifier and files. A point is a
/// span of size() doubles in group order. Joints are straight lines, continuous joints go the
/// shorter way, planar angles likewise, floating joints move their origin on a line and turn at
/// constant rate about a fixed axis.
class ConfigurationSpace {
 public:
  enum class Kind : unsigned char {
    kLine,
    kCircle,
    kRotation
  };  // kRotation: four numbers, a quaternion xyzw
  struct Part {
    Kind kind;
    int first;      ///< index into the point
    double weight;  ///< in distance()
  };

  ConfigurationSpace(std::shared_ptr<const robots::Model> model, std::vector<int> variables);

  int size() const { return static_cast<int>(variables_.size()); }
  std::span<const Part> parts() const { return parts_; }
  std::span<const int> variables() const { return variables_; }
  const robots::Model& model() const { return *model_; }
  double lower(int i) const { return lower_[static_cast<std::size_t>(i)]; }
  double upper(int i) const { return upper_[static_cast<std::size_t>(i)]; }

  /// dq such that a + t dq is the edge: circles the shorter way; rotations as a rotation vector
  /// (body frame) in the first three places, 0 in the fourth.
  void difference(std::span<const double> a, std::span<const double> b, std::span<double> dq) const;
  /// The configuration at t in [0, 1] of the edge from a along dq. Circles are wrapped to [-pi,
  /// pi); t = 0 and t = 1 give a and b to the bit when called through interpolate().
  void advance(std::span<const double> a, std::span<const double> dq, double t,
               std::span<double> result) const;
  void interpolate(std::span<const double> a, std::span<const double> b, double t,
                   std::span<double> result) const;
  /// Weighted Euclidean distance of difference(); [rad and m mixed by the weights, 1 by default].
  double distance(std::span<const double> a, std::span<const double> b) const;
  /// True for finite numbers inside the limits and orientations of unit length to within 1e-6.
  bool withinLimits(std::span<const double> a) const;
  /// Adds whole turns to the circles of `next` so that each is at most half a turn from `previous`:
  /// how paths are kept and written, so that a controller that knows nothing of circles goes the
  /// same way. Numbers already there keep their bits.
  void unwrap(std::span<const double> previous, std::span<double> next) const;

 private:
  std::shared_ptr<const robots::Model> model_;
  std::vector<int> variables_;
  std::vector<Part> parts_;
  std::vector<double> lower_, upper_;
};

}  // namespace leeway::planner
