// Straight and screw motions of a frame, and of frames that are fixed to it.

#include <Eigen/Geometry>
#include <cmath>

#include "leeway/collision/sine_cosine.h"
#include "leeway/collision/time_of_contact.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

/// Rotation vector of R1 R0^T, in the world.
void worldTurn(const Pose& X0, const Pose& X1, Eigen::Vector3d& axis, double& angle) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(X1.rotation * X0.rotation.transpose()));
  axis = turn.axis();
  angle = turn.angle();
}

/// Rodrigues; the columns of R turned about a unit axis.
Eigen::Matrix3d turned(const Eigen::Vector3d& axis, double angle, const Eigen::Matrix3d& R) {
  double s, c;
  sineCosine(angle, s, c);
  Eigen::Matrix3d turn = c * Eigen::Matrix3d::Identity() + (1 - c) * axis * axis.transpose();
  turn(0, 1) -= s * axis.z();
  turn(0, 2) += s * axis.y();
  turn(1, 0) += s * axis.z();
  turn(1, 2) -= s * axis.x();
  turn(2, 0) -= s * axis.y();
  turn(2, 1) += s * axis.x();
  return turn * R;
}

double outwards(double x) { return x * (1 + 64 * kUnitRoundoff); }

}  // namespace

StraightMotion::StraightMotion(const Pose& X_WA0, const Pose& X_WA1)
    : X_WA0_(X_WA0), travel_(X_WA1.translation - X_WA0.translation) {
  worldTurn(X_WA0, X_WA1, axis_W_, angle_);
}

Pose StraightMotion::pose(double t) const {
  return {turned(axis_W_, angle_ * t, X_WA0_.rotation), X_WA0_.translation + t * travel_};
}

FrameVelocity StraightMotion::velocity(double) const { return {travel_, angle_ * axis_W_}; }

FrameMotionBound StraightMotion::bound(double, double) const {
  return {outwards(travel_.norm()), 0, outwards(std::abs(angle_)), 0};
}

double StraightMotion::rounding(double reach) const {
  // Some thirty operations a coordinate, the axis' own departure from unit length among them.
  return kMotionRounding * (3 * reach + X_WA0_.translation.norm() + travel_.norm());
}

ScrewMotion::ScrewMotion(const Pose& X_WA0, const Pose& X_WA1) : X_WA0_(X_WA0) {
  worldTurn(X_WA0, X_WA1, axis_W_, angle_);
  const Eigen::Vector3d travel = X_WA1.translation - X_WA0.translation;
  double s, c;
  sineCosine(angle_ / 2, s, c);
  // Without rotation every line along the travel is an axis.
  const bool turns = std::abs(s) > kLeastScrewTurn;
  cotangent_ = turns ? c / s : 0;
  along_ = turns ? Eigen::Vector3d(axis_W_.dot(travel) * axis_W_) : travel;
  across_ = travel - along_;
  turned_ = axis_W_.cross(across_);
  if (!turns) angle_ = 0;
}

// The axis runs through o(0) + (across + cotangent * turned) / 2. What is turned about it comes to
// the sums below, in which no term is larger than the travel, however far away the axis is.
Pose ScrewMotion::pose(double t) const {
  double s, c, sh, ch;
  sineCosine(angle_ * t, s, c);
  sineCosine(angle_ * t / 2, sh, ch);
  const double versine = 2 * sh * sh;
  Pose X{turned(axis_W_, angle_ * t, X_WA0_.rotation), X_WA0_.translation + t * along_};
  X.translation += (s * cotangent_ + versine) / 2 * across_;
  X.translation += (versine * cotangent_ - s) / 2 * turned_;
  return X;
}

FrameVelocity ScrewMotion::velocity(double t) const {
  double s, c;
  sineCosine(angle_ * t, s, c);
  FrameVelocity v{along_, angle_ * axis_W_};
  v.linear += angle_ * (c * cotangent_ + s) / 2 * across_;
  v.linear += angle_ * (s * cotangent_ - c) / 2 * turned_;
  return v;
}

FrameMotionBound ScrewMotion::bound(double, double) const {
  const double arm = across_.norm() / 2 * std::sqrt(1 + cotangent_ * cotangent_);
  const double turn = std::abs(angle_);
  return {outwards(turn * arm + along_.norm()), outwards(turn * turn * arm), outwards(turn), 0};
}

double ScrewMotion::rounding(double reach) const {
  return kMotionRounding *
         (3 * reach + X_WA0_.translation.norm() + 4 * (across_.norm() + along_.norm()));
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
