#pragma once

#include <span>
#include <vector>

#include "leeway/robots/model.h"

// The verifier's own kinematics: it shares nothing with robots/kinematics or robots/motion_bound.

namespace leeway::planner::verification {

/// The rotation by `angle` about a unit axis [rad].
Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle);

/// Returns the poses of all links in the world at the configuration q of all variables, computed
/// from the Joint structs alone. O(links).
std::vector<robots::Pose> placeLinks(const robots::Model& model, std::span<const double> q);

/// A sphere in the frame of a shape that contains the shape, computed from sizes and vertices. Its
/// radius is infinite for a half-space.
struct Sphere {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;
};
Sphere enclosingSphere(const collision::Shape& shape);

/// The joints above a link, nearest first; empty for the world (-1).
std::vector<int> jointsAbove(const robots::Model& model, int link);

/// Bounds on a body's motion while t changes by at most `half` from the instant of X_WL.
struct Motion {
  double speed = 0;  ///< of any point, in the frame below the last of `joints` [m per unit of t]
  double slack = 0;  ///< displacement of any point by rounding of q and of placeLinks() [m]
};

/// Bounds the motion of a body in the sphere (center_W, radius). `joints`: the joints above the
/// body that move it, nearest first. `dq`: the change of every variable while t goes from 0 to 1;
/// an orientation has its rotation vector in its first three places. O(joints).
Motion boundMotion(const robots::Model& model, std::span<const int> joints,
                   std::span<const robots::Pose> X_WL, std::span<const double> dq,
                   const Eigen::Vector3d& center_W, double radius, double half);

/// How the variables change with t at an instant, and bounds on their first two derivatives around
/// it.
struct VariableRates {
  std::span<const double> now, most, second;
};
/// Bounds the speed of a point of a body in the world while t changes by at most `half` from the
/// instant of X_WL. `joints`: all joints above the body, nearest first. `at_instant`: its speed
/// there, rounding apart. Infinite for floating joints, whose variables do not move on cubics.
/// O(joints^2).
double boundSpeed(const robots::Model& model, std::span<const int> joints,
                  std::span<const robots::Pose> X_WL, const VariableRates& rates,
                  const Eigen::Vector3d& point_W, double half, double& at_instant);

}  // namespace leeway::planner::verification
