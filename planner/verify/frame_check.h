#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "leeway/planner/verify.h"
#include "planner/verify/kinematics.h"

namespace leeway::planner::verification {

/// A frame at one point of an edge, seen from its base B, with first-order bounds on its motion
/// around that point.
struct FrameLook {
  robots::Pose X_BF;
  double size = 0;         ///< of the coordinates that X_BF is computed from [m]
  double t = 0, half = 0;  ///< the point, and half the part's length, as shares of the edge
  double moves = 0;        ///< bound on the motion of the origin over this part of the edge [m]
  double tips = 0;         ///< the same for ends of unit vectors fixed to the frame, by rotation
  double slack = 0;        ///< displacement of any of these by rounding [m]
  /// Speed of the origin in the world, at the point and at most on this part [m per unit of t]. Set
  /// for cubics, after FrameCheck::measureSpeed().
  double speed = 0, most_speed = 0;
};

/// Proves or refutes a condition on the frame of a link along edges, seen from a base B. Halves
/// edges as needed.
class FrameCheck {
 public:
  /// `problem` must outlive it. `base`: a link; -1: the world.
  FrameCheck(const Problem& problem, int link, const robots::Pose& X_LF, int base = -1);

  /// Returns what a look proves about its part of an edge. kCertified: the condition holds on all
  /// of it. kRefuted: it does not hold at the middle. kUndecided: the part is halved.
  using Judge = std::function<VerifyStatus(const FrameLook&)>;
  /// Checks the motion from one row of a path to the next: a line, or cubics if the path has times.
  /// Sets `t` to the point where the condition is refuted or undecided. Does not halve parts that
  /// are shorter than 2 * `least`.
  VerifyStatus check(const Path& path, std::size_t segment, double least, const Judge& judge,
                     double& t);
  /// From now on, looks at cubics bound the speed. Only without a base.
  void measureSpeed() { speeds_ = true; }
  /// check() leaves the rest of an edge undecided after `most` looks at it, and after `stop`
  /// returns true. `stop` may be empty.
  void limit(long most, const std::function<bool()>& stop) { most_ = most, stop_ = stop; }

 private:
  const robots::Model& model_;
  std::vector<int> variables_;
  ConfigurationSpace space_;
  int link_, base_;
  robots::Pose X_LF_;
  std::vector<double> q_;
  std::vector<int> joints_, base_joints_;  ///< above one of link and base alone
  long most_ = std::numeric_limits<long>::max();
  std::function<bool()> stop_;
  bool speeds_ = false;
};

/// Returns the first place of a path where a constraint of the problem is not proven to hold;
/// nothing if all constraints are proven on every line between the path's rows. Leaves an edge
/// undecided after kVerifyPairWork looks at a constraint, and after `stop` returns true. `stop` is
/// called often and may be empty. Shares nothing with planner/constraint.
std::optional<VerifyResult> findBrokenConstraint(const Problem& problem, const Path& path,
                                                 const std::function<bool()>& stop);

}  // namespace leeway::planner::verification
