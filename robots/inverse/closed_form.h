#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "robots/inverse/chain.h"

namespace leeway::robots {

/// All angles of six revolute joints for a pose, in closed form, if the geometry allows it. There
/// are two cases, for the joints in order from base to hand or from hand to base. First: the last
/// three axes meet (a wrist), and of the first three either two neighbours meet or the second and
/// third are parallel. Second: the second to fourth axes are parallel and the last two meet. With
/// seven joints, one joint has a given angle. Subproblems: subproblems.h; the decomposition is that
/// of Elias and Wen, which is cited there.
///
/// Axes count as meeting and parallel to within kSameAxis. The angles have only that accuracy and
/// must be polished.
class ClosedForm {
 public:
  explicit ClosedForm(const Chain& chain);

  /// Whether there is a closed form for the chain.
  bool exists() const { return kind_ != Kind::kNone; }
  /// The joint whose angle is given; -1 with six joints.
  int given() const { return given_; }

  struct Answer {
    int count = 0;
    /// Angles of each joint, including the offset of KinematicStep.
    std::array<std::array<double, 7>, 8> angles;
    /// Solutions may be missing: near a singular pose, two solutions are about to become one or
    /// none, or are points of a curve, of which those nearest to `angles` were taken.
    bool singular = false;
  };
  /// Computes up to eight solutions for F at X_RF. `angles`: one for each joint, for joints that
  /// are given or free. Ignores limits. O(1), a few microseconds.
  void solve(const Pose& X_RF, const std::array<double, 7>& angles, Answer& answer) const;

 private:
  enum class Kind { kNone, kWristFirstTwoMeet, kWristNextTwoMeet, kWristParallel, kThreeParallel };
  /// A joint's axis at angle 0 of all joints, in R: a unit vector and a point.
  struct Axis {
    Eigen::Vector3d direction, point;
  };
  struct Arm;
  class WristSolver;
  static Kind kindOf(const std::vector<Axis>& axes, const std::array<int, 6>& joints);
  static void solveParallel(const Arm& arm, Answer& answer);

  std::vector<Axis> axes_;
  Pose X_RF0_inverse_;  ///< of F at angle 0
  Kind kind_ = Kind::kNone;
  int given_ = -1;
  std::array<int, 6> joints_ = {};  ///< of the chain, in the order in which they are solved
};

}  // namespace leeway::robots
