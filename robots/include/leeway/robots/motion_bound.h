#pragma once

#include <span>
#include <utility>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// The joints between two links, and the largest distances of a body's points from their axes. They
/// bound the motion of the body on `link`, seen from `base` (-1: the world), along an edge q(t) =
/// q0
/// + t dq, t in [0, 1]. Reaches and the speed bound follow Schwarzer, Saha and Latombe ("Adaptive
/// dynamic collision checking for single and multiple articulated robots in complex environments",
/// 2005); the bound on acceleration is ours.
struct RelativeMotion {
  struct Term {
    int joint;  ///< a moving joint of the path from `base` to `link`, nearest to `base` first
    /// rho: bound on the distance of the body's points from the joint's axis (floating: origin)
    /// over all configurations within the limits, rounded up [m]. Infinite behind an unlimited
    /// prismatic joint.
    double reach;
    bool inverted = false;  ///< the body is on the parent's side: `base` is below the joint
  };
  int link = -1;
  int base = -1;
  std::vector<Term> terms;
  Eigen::Vector3d center_L = Eigen::Vector3d::Zero();  ///< the body's sphere, in link's frame [m]
  double radius = 0;                                   ///< [m]
  /// Bound on the distance of the body's points from base's origin [m]; infinite as `reach`.
  double base_reach = 0;
};

/// Derives the terms for a body inside the sphere (center_L, radius) fixed to `link` (-1: the
/// world). O(joints^2).
RelativeMotion relativeMotion(const Model& model, int link, int base,
                              const Eigen::Vector3d& center_L, double radius);

/// The values of a variable, in place of its limits. A range of no width is a constant.
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

/// |dq| of a joint along an edge.
struct JointMotion {
  double angle = 0;   ///< [rad]
  double travel = 0;  ///< [m]
};
/// Fills in one entry a joint; a mimic joint has its multiplier. dq is that of the planner's
/// difference(): of continuous joints the shorter way; of floating ones the translation and, in
/// place of the quaternion, the rotation vector (body frame) and 0. O(joints).
void jointMotion(const Model& model, std::span<const double> dq,
                 std::span<JointMotion> joint_motion);
/// The same for some joints alone: what the others have stays. O(joints asked).
void jointMotion(const Model& model, std::span<const int> joints, std::span<const double> dq,
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

/// Both bounds over an interval of the edge: from the distances of the body's sphere to the joints'
/// axes at the interval's middle (X_WL there, one a link), plus what the joints between add within
/// `half_interval` (in t). At most the bounds by `reach`; with `within_limits` false they do not
/// use it, and hold outside the limits. O(terms).
MotionBound localMotionBound(const Model& model, const RelativeMotion& motion,
                             std::span<const JointMotion> joint_motion, std::span<const Pose> X_WL,
                             double half_interval, bool within_limits = true);

/// Those of `candidates` that are proven never to touch at any configuration within the limits.
/// Interval subdivision over the joints between the two links, with a work limit of milliseconds a
/// pair, on all cores. Calls `stop` from this thread, and throws Stopped. Answers are kept in the
/// model's cache folder, by a digest of everything that they depend on; they are the same without
/// it.
std::vector<std::pair<int, int>> provenApart(const Model& model,
                                             std::span<const std::pair<int, int>> candidates,
                                             const Stop& stop = {});

/// Those of `candidates` that are proven to touch at every configuration within the limits, by the
/// depths of their convex geometries. Cost and errors as provenApart().
std::vector<std::pair<int, int>> provenTouching(const Model& model,
                                                std::span<const std::pair<int, int>> candidates,
                                                const Stop& stop = {});

/// The only joint that moves two links against each other, whatever its limits; -1: there are none
/// or several. O(joints).
int onlyJointBetween(const Model& model, int link_a, int link_b);

/// Where two links with one joint between them touch, to within kTouch (tolerances.h).
enum class Touch : unsigned char {
  kApart,       ///< they do not touch at the default configuration
  kSometimes,   ///< they touch there, but not at every sample
  kEverywhere,  ///< they touch there and at every sample
};

/// Returns where the links of each pair touch; kApart for a pair without onlyJointBetween().
/// Samples are the joint's positions at even steps over Variable::touchRange(), or over a whole
/// turn. Nothing is proven between the samples. Kept and in parallel as provenApart(). One look at
/// each sample until the links are apart, kTouchLooks + 2 at most; a look is a distance query for
/// each pair of geometries.
std::vector<Touch> touchAtJoints(const Model& model, std::span<const std::pair<int, int>> pairs,
                                 const Stop& stop = {});

/// The pairs of links that touch at the default configuration, proven to within kTouch
/// (tolerances.h), the lower link first: those that joints move against each other, without
/// neighbours and pairs that the SRDF disables. One distance query a pair of geometries.
std::vector<std::pair<int, int>> touchingAtRest(const Model& model, const Stop& stop = {});

}  // namespace leeway::robots
