#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "leeway/planner/verify.h"
#include "planner/verify/kinematics.h"

namespace leeway::planner::verification {

/// A frame at one place of an edge, with first-order bounds for what is around it.
struct FrameLook {
  robots::Pose X_WF;
  double t = 0, half = 0;  ///< the place's, and half of what it stands for, as shares of the edge
  double moves = 0;        ///< the origin over this part of the edge, at most [m]
  double tips = 0;         ///< the ends of unit vectors fixed to the frame, from its rotation alone
  double slack = 0;        ///< displacement of any of these by rounding [m]
};

/// Proves or refutes what a frame on a link keeps along edges, by halving them.
class FrameCheck {
 public:
  /// `problem` must outlive it.
  FrameCheck(const Problem& problem, int link, const robots::Pose& X_LF);

  /// Returns what a look proves about its part of an edge: kCertified, it holds on all of it;
  /// kRefuted, it does not hold at its middle; kUndecided, the part is halved.
  using Judge = std::function<VerifyStatus(const FrameLook&)>;
  /// The answer for the line from a to b. `t`: where it is refuted or undecided. `least`: parts of
  /// half that length are not halved.
  VerifyStatus check(const std::vector<double>& a, const std::vector<double>& b, double least,
                     const Judge& judge, double& t);
  /// check() leaves the rest of an edge undecided after `most` looks, counted over all edges, and
  /// once `stop` returns true; it may be empty.
  void limit(long most, const std::function<bool()>& stop) { most_ = most, stop_ = stop; }

 private:
  const robots::Model& model_;
  std::vector<int> variables_;
  ConfigurationSpace space_;
  int link_;
  robots::Pose X_LF_;
  std::vector<double> q_;
  std::vector<int> joints_;
  long looks_ = 0, most_ = std::numeric_limits<long>::max();
  std::function<bool()> stop_;
};

/// The first place of a path where a constraint of the problem is not proven to hold; nothing when
/// all are, on every line between its rows. Shares nothing with planner/constraint.
/// An edge is left undecided after kVerifyPairWork looks at a constraint, and once `stop`, which is
/// called often, returns true; it may be empty.
std::optional<VerifyResult> findBrokenConstraint(const Problem& problem, const Path& path,
                                                 const std::function<bool()>& stop);

}  // namespace leeway::planner::verification
