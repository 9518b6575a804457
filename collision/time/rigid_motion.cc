// Straight and screw motions of a frame, and motions of frames that are fixed to a moving frame.

#include <Eigen/Geometry>
#include <cmath>

#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {
namespace {

double outwards(double x) { return x * (1 + 64 * kUnitRoundoff); }

}  // namespace

AxisTurn::AxisTurn(const Eigen::Matrix3d& R_WA0, const Eigen::Matrix3d& R_WA1) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(R_WA1 * R_WA0.transpose()));
  *this = AxisTurn(R_WA0, turn.axis(), turn.angle());
}

AxisTurn::AxisTurn(const Eigen::Matrix3d& R_WA0, const Eigen::Vector3d& axis_W, double angle)
    : axis_W_(axis_W), angle_(angle) {
  // Rodrigues' formula, terms collected by sine and cosine.
  along_ = axis_W_ * (axis_W_.transpose() * R_WA0);
  across_ = R_WA0 - along_;
  for (int i = 0; i < 3; ++i) turned_.col(i) = axis_W_.cross(R_WA0.col(i));
}

Eigen::Matrix3d AxisTurn::at(double t) const {
  double s, c;
  sineCosine(angle_ * t, s, c);
  return along_ + c * across_ + s * turned_;
}

StraightMotion::StraightMotion(const Pose& X_WA0, const Pose& X_WA1)
    : start_(X_WA0.translation),
      travel_(X_WA1.translation - X_WA0.translation),
      turn_(X_WA0.rotation, X_WA1.rotation) {}

Pose StraightMotion::pose(double t) const { return {turn_.at(t), start_ + t * travel_}; }

FrameVelocity StraightMotion::velocity(double) const {
  return {travel_, turn_.angle() * turn_.axis()};
}

FrameMotionBound StraightMotion::bound(double, double) const {
  return {outwards(travel_.norm()), 0, outwards(turn_.angle()), 0};
}

double StraightMotion::rounding(double reach) const {
  // About thirty operations for each coordinate, including the axis' departure from unit length.
  return kMotionRounding * (3 * reach + start_.norm() + travel_.norm());
}

ScrewMotion::ScrewMotion(const Pose& X_WA0, const Pose& X_WA1)
    : start_(X_WA0.translation), turn_(X_WA0.rotation, X_WA1.rotation) {
  const Eigen::Vector3d travel = X_WA1.translation - X_WA0.translation;
  double s, c;
  sineCosine(turn_.angle() / 2, s, c);
  // Without rotation, every line along the travel is an axis.
  const bool turns = std::abs(s) > kLeastScrewTurn;
  if (!turns) turn_ = AxisTurn(X_WA0.rotation, X_WA0.rotation);
  cotangent_ = turns ? c / s : 0;
  along_ = turns ? Eigen::Vector3d(turn_.axis().dot(travel) * turn_.axis()) : travel;
  across_ = travel - along_;
  turned_ = turn_.axis().cross(across_);
}

// The axis runs through o(0) + (across + cotangent turned) / 2, which is far away for small angles.
// Rotation about it is written so that no term is larger than the travel.
Pose ScrewMotion::pose(double t) const {
  double s, c, sh, ch;
  sineCosine(turn_.angle() * t, s, c);
  sineCosine(turn_.angle() * t / 2, sh, ch);
  const double versine = 2 * sh * sh;
  Pose X{turn_.at(t), start_ + t * along_};
  X.translation += (s * cotangent_ + versine) / 2 * across_;
  X.translation += (versine * cotangent_ - s) / 2 * turned_;
  return X;
}

FrameVelocity ScrewMotion::velocity(double t) const {
  const double turn = turn_.angle();
  double s, c;
  sineCosine(turn * t, s, c);
  FrameVelocity v{along_, turn * turn_.axis()};
  v.linear += turn * (c * cotangent_ + s) / 2 * across_;
  v.linear += turn * (s * cotangent_ - c) / 2 * turned_;
  return v;
}

FrameMotionBound ScrewMotion::bound(double, double) const {
  const double arm = across_.norm() / 2 * std::sqrt(1 + cotangent_ * cotangent_);
  const double turn = turn_.angle();
  return {outwards(turn * arm + along_.norm()), outwards(turn * turn * arm), outwards(turn), 0};
}

double ScrewMotion::rounding(double reach) const {
  return kMotionRounding * (3 * reach + start_.norm() + 4 * (across_.norm() + along_.norm()));
}

FrameVelocity MountedMotion::velocity(double t) const {
  FrameVelocity v = body_.velocity(t);
  v.linear += v.angular.cross(body_.pose(t).rotation * X_BG_.translation);
  return v;
}

FrameMotionBound MountedMotion::bound(double t0, double t1) const {
  FrameMotionBound m = body_.bound(t0, t1);
  const double arm = outwards(X_BG_.translation.norm());
  m.acceleration += (m.angular_acceleration + m.angular_speed * m.angular_speed) * arm;
  m.speed += m.angular_speed * arm;
  return m;
}

double MountedMotion::rounding(double reach) const {
  const double arm = X_BG_.translation.norm();
  return body_.rounding(reach + arm) +
         kMotionRounding * (arm + reach + body_.pose(0).translation.norm());
}

}  // namespace leeway::collision
