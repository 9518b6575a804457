#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>

#include "leeway/collision/pose.h"

namespace leeway::robots {

using collision::Pose;

/// Where a frame F, fixed to a link, may be: a box of positions and of roll, pitch and yaw of F in
/// a reference frame R. The rotation is Rz(yaw) Ry(pitch) Rx(roll), as URDF's rpy. A range of no
/// width is an exact value; one of 2 pi or more is any angle.
struct PoseRegion {
  int link = -1;
  Pose X_LF;
  Pose X_WR;
  std::array<std::pair<double, double>, 3> position;  ///< least and greatest x, y, z [m]
  std::array<std::pair<double, double>, 3> rpy;       ///< roll, pitch, yaw [rad]
  /// How far outside of the region an answer may be. At least kLeastPoseTolerance.
  double position_tolerance = 1e-9, angle_tolerance = 1e-9;  // [m], [rad]
  /// W is the frame of this link, and the region moves with it; -1: the world.
  int base = -1;

  /// The region that holds X_RF alone: its frame R is X_WR * X_RF, and its ranges are 0 there.
  static PoseRegion exact(int link, const Pose& X_LF, const Pose& X_WR, const Pose& X_RF);
};

/// Tolerances below this are refused: kinematics of a robot of some metres round by 1e-14.
inline constexpr double kLeastPoseTolerance = 1e-12;

/// How far a frame is outside of its region.
struct PoseError {
  double position = 0;  ///< the distance to the box [m]
  double angle = 0;     ///< of the rotation to the nearest one allowed [rad]
};

/// The error of F when its link is at X_WL, in the frame W of region.base. Where two or three of
/// the angles have a width, the nearest rotation is searched and may be missed: never less than the
/// true error. O(1).
PoseError poseError(const PoseRegion& region, const Pose& X_WL);

/// Roll, pitch, yaw of a rotation, |pitch| <= pi/2; roll 0 where only their sum or difference is
/// determined. The same bytes with every C library. O(1).
Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& R);

/// Rz(yaw) Ry(pitch) Rx(roll). O(1).
Eigen::Matrix3d rotationOf(const Eigen::Vector3d& roll_pitch_yaw);

}  // namespace leeway::robots
