#include "planner/verify/pose_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "planner/base/tolerances.h"

namespace leeway::planner::verification {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Range = std::pair<double, double>;

constexpr double kTurn = 2 * std::numbers::pi;

/// The angle of the range that is nearest to `angle`, modulo whole turns.
double into(const Range& range, double angle) {
  if (range.second - range.first >= kTurn) return angle;
  const double middle = range.first / 2 + range.second / 2;
  return std::clamp(middle + std::remainder(angle - middle, kTurn), range.first, range.second);
}

Matrix3d turned(double roll, double pitch, double yaw) {
  return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
          AngleAxisd(roll, Vector3d::UnitX()))
      .toRotationMatrix();
}

/// The angle between R and the nearest of a few rotations, all of them inside the ranges [rad].
double angleOutside(const std::array<Range, 3>& rpy, const Matrix3d& R) {
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double roll, double pitch, double yaw) {
    const Matrix3d nearest = turned(into(rpy[0], roll), into(rpy[1], pitch), into(rpy[2], yaw));
    // |A - B| (Frobenius) of two rotations is sqrt(8) sin(angle / 2).
    const double sine = (R - nearest).norm() / std::sqrt(8.0);
    least = std::min(least, 2 * std::asin(std::min(1.0, sine)));
  };
  // Try both sets of angles that give R.
  const double roll = std::atan2(R(2, 1), R(2, 2)), yaw = std::atan2(R(1, 0), R(0, 0));
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  consider(roll, pitch, yaw);
  consider(roll + std::numbers::pi, std::numbers::pi - pitch, yaw + std::numbers::pi);
  // Near a pitch of 90 degrees, roll and yaw turn about the same axis. So also fix one of them in
  // its range and solve for the other two angles.
  for (const double x : {rpy[0].first, rpy[0].second, into(rpy[0], roll), into(rpy[0], 0)}) {
    const Matrix3d S = R * turned(-x, 0, 0);
    consider(x, std::atan2(-S(2, 0), S(2, 2)), std::atan2(-S(0, 1), S(1, 1)));
  }
  for (const double z : {rpy[2].first, rpy[2].second, into(rpy[2], yaw), into(rpy[2], 0)}) {
    const Matrix3d S = turned(0, 0, -z) * R;
    consider(std::atan2(-S(1, 2), S(1, 1)), std::atan2(-S(2, 0), S(0, 0)), z);
  }
  return least;
}

}  // namespace

bool isInRegion(const robots::PoseRegion& region, std::span<const robots::Pose> X_WL) {
  const robots::Pose X_WF = X_WL[static_cast<std::size_t>(region.link)] * region.X_LF;
  const robots::Pose X_WR =
      region.base < 0 ? region.X_WR : X_WL[static_cast<std::size_t>(region.base)] * region.X_WR;
  const robots::Pose X_RF = X_WR.inverse() * X_WF;
  Vector3d outside;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Range& range = region.position[static_cast<std::size_t>(i)];
    outside[i] =
        std::max({range.first - X_RF.translation[i], X_RF.translation[i] - range.second, 0.0});
  }
  // Rounding grows with the coordinates' size.
  const double size = 1 + X_WF.translation.norm() + X_WR.translation.norm();
  // Both comparisons are false for NaN, which is therefore outside.
  return outside.norm() <= region.position_tolerance + kVerifyPose * size &&
         angleOutside(region.rpy, X_RF.rotation) <= region.angle_tolerance + kVerifyPose;
}

}  // namespace leeway::planner::verification
