#pragma once

// Subproblems to which the inverse kinematics of many arms reduce: Paden (Kinematics and control of
// robot manipulators, 1986) and Kahan; numbered as by Elias and Wen, "IK-Geo: Unified robot inverse
// kinematics using subproblem decomposition", Mechanism and Machine Theory 209, 2025. All axes k
// are unit vectors. A subproblem that has no solution because of rounding returns the nearest
// angles.

#include <Eigen/Core>
#include <array>

namespace leeway::robots {

/// Up to two angles.
struct Angles {
  int count = 0;
  std::array<double, 2> value = {0, 0};
  /// Two solutions are about to become one or none, or any angle solves.
  bool singular = false;
};

/// Rotation about the unit vector `axis` by `angle`. O(1).
Eigen::Matrix3d turnAbout(const Eigen::Vector3d& axis, double angle);

/// Subproblem 1: the angle for which p, turned about k, is nearest to q. `otherwise`, and singular,
/// if p or q is along k. O(1).
Angles angleBetween(const Eigen::Vector3d& k, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                    double otherwise);

/// Subproblem 4: h dot (p turned about k) = d. `otherwise`, and singular, if turning p has no
/// effect on it. O(1).
Angles anglesToPlane(const Eigen::Vector3d& h, const Eigen::Vector3d& k, const Eigen::Vector3d& p,
                     double d, double otherwise);

/// Subproblem 3: |(p turned about k) - q| = d. O(1).
Angles anglesToDistance(const Eigen::Vector3d& k, const Eigen::Vector3d& p,
                        const Eigen::Vector3d& q, double d, double otherwise);

/// Up to two points.
struct MeetingPoints {
  int count = 0;
  std::array<Eigen::Vector3d, 2> point;
  bool singular = false;
};

/// Subproblem 2: the intersections of the circle of p1 about k1 with that of p2 about k2; |p1| =
/// |p2|, and the axes, through the origin, are not parallel. O(1).
MeetingPoints meetingPoints(const Eigen::Vector3d& k1, const Eigen::Vector3d& p1,
                            const Eigen::Vector3d& k2, const Eigen::Vector3d& p2);

}  // namespace leeway::robots
