#pragma once

#include <span>
#include <utility>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Joints between two links and how far a body's points can be from their axes: what bounds the
/// motion of the body on `link`, seen from `base` (-1: the world), along an edge q(t) = q0 + t dq,
/// t in [0, 1]. Reaches and the bound on speed are in the manner of Schwarzer, Saha and Latombe
/// ("Adaptive dynamic collision checking for single and multiple articulated robots in complex
/// environments", 2005); the bound on acceleration goes beyond them.
struct RelativeMotion {
  struct Term {
    int joint;     ///< a moving joint of the path from `base` to `link`, nearest to `base` first
    double reach;  ///< rho: no point of the body is ever farther from the joint's axis (floating:
                   ///< origin), over all configurations within the limits [m]; rounded outwards;
                   ///< infinite behind an unlimited prismatic joint
    bool inverted = false;  ///< the body is on the joint's parent side: the joint lies between
                            ///< `base` and the common ancestor
  };
  int link = -1;
  int base = -1;
  std::vector<Term> terms;
  Eigen::Vector3d center_L = Eigen::Vector3d::Zero();  ///< the body's sphere, in link's frame [m]
  double radius = 0;                                   ///< [m]
  /// No point of the body is ever farther from base's origin [m]; infinite as above.
  double base_reach = 0;
};

/// Derives the terms for a body inside the sphere (center_L, radius) fixed to `link` (-1: the
/// world). O(joints^2).
RelativeMotion relativeMotion(const Model& model, int link, int base,
                              const Eigen::Vector3d& center_L, double radius);

/// What values a variable may take, when that is less or other than its limits. A range of no width
/// is a constant.
struct VariableRange {
  double lower, upper;  ///< [rad or m]
};
/// The ranges of the model's limits (infinite where unlimited), one a variable.
std::vector<VariableRange> limitRanges(const Model& model);

/// relativeMotion() over `ranges` (one a variable) in place of the limits: joints whose variables
/// are all constant have no term.
RelativeMotion relativeMotion(const Model& model, int link, int base,
                              const Eigen::Vector3d& center_L, double radius,
                              std::span<const VariableRange> ranges);

/// |dq| of every joint for the edge dq (variables' differences; floating and planar joints: see
/// below): rotation angle and translation length.
struct JointMotion {
  double angle = 0;   ///< [rad]
  double travel = 0;  ///< [m]
};
/// joint_motion has one entry a joint, mimic joints with their multiplier. dq as made by the
/// planner's difference(): continuous joints the shortest; floating: the three translations and, in
/// the quaternion's first three places, the rotation vector (body frame), 0 in the fourth.
void jointMotion(const Model& model, std::span<const double> dq,
                 std::span<JointMotion> joint_motion);

/// A bound on the acceleration |p''| of the body's points seen from base, t in [0, 1] [m].
/// O(terms).
double accelerationBound(const Model& model, const RelativeMotion& motion,
                         std::span<const JointMotion> joint_motion);

/// A bound on the speed |p'| of the same points [m]. O(terms).
double speedBound(const Model& model, const RelativeMotion& motion,
                  std::span<const JointMotion> joint_motion);

/// Bounds on speed and acceleration [m] of the body's points seen from base.
struct MotionBound {
  double speed = 0;
  double acceleration = 0;
};

/// Both bounds over an interval of the edge, from the distances of the body's sphere to the joints'
/// axes at the interval's middle (X_WL there, one a link) and from what the joints between can add
/// within `half_interval` (in t) of it; never more than the static reaches give. These hold
/// whatever the limits are, when `within_limits` is false. O(terms).
MotionBound localMotionBound(const Model& model, const RelativeMotion& motion,
                             std::span<const JointMotion> joint_motion, std::span<const Pose> X_WL,
                             double half_interval, bool within_limits = true);

/// Pairs of links that can never touch, proven over all configurations within the limits: returns
/// those of `candidates` that are proven. Interval subdivision over the joints between the two
/// links with a work limit; what it cannot prove stays checked.
std::vector<std::pair<int, int>> provenApart(const Model& model,
                                             std::span<const std::pair<int, int>> candidates);

}  // namespace leeway::robots
