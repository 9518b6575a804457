#pragma once

#include <span>
#include <vector>

#include "leeway/robots/model.h"

// The verifier's own kinematics: nothing of robots/kinematics or robots/motion_bound is used here.

namespace leeway::planner::verification {

/// Poses of all links in the world at the configuration q of all variables, straight from the Joint
/// structs.
std::vector<robots::Pose> placeLinks(const robots::Model& model, std::span<const double> q);

/// A sphere that holds the shape, in its frame; computed anew from sizes and vertices. Infinite
/// radius for a half-space.
struct Sphere {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;
};
Sphere enclosingSphere(const collision::Shape& shape);

/// The joints above a link, nearest first; none for the world (-1).
std::vector<int> jointsAbove(const robots::Model& model, int link);

/// How a body moves when t changes by at most `half` from the instant at which X_WL holds: every
/// point of it has a speed of at most `speed` [m per unit of t] in the frame below the last of
/// `joints`, and rounding of q and of placeLinks() displaces none by more than `slack` [m].
struct Motion {
  double speed = 0;
  double slack = 0;
};

/// `joints`: those above the body, nearest first, as far as they count. `dq`: change of every
/// variable over t from 0 to 1 (orientations as rotation vectors in their first three places). The
/// body lies in the sphere (center_W, radius). O(joints).
Motion boundMotion(const robots::Model& model, std::span<const int> joints,
                   std::span<const robots::Pose> X_WL, std::span<const double> dq,
                   const Eigen::Vector3d& center_W, double radius, double half);

}  // namespace leeway::planner::verification
