#include "leeway/robots/link_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/robots/kinematics.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {
namespace {

/// The variable that a joint follows, directly or through its masters.
struct Follows {
  int variable = -1;
  double multiplier = 1;
};
Follows follows(const Model& model, const Joint& joint) {
  Follows f;
  const Joint* j = &joint;
  for (std::size_t steps = 0; j->mimic >= 0 && steps < model.joints.size(); ++steps) {
    f.multiplier *= j->multiplier;
    j = &model.joints[at(j->mimic)];
  }
  f.variable = j->first_variable;
  return f;
}

/// The quaternion p * q, xyzw.
Eigen::Vector4d product(const Eigen::Vector4d& p, const Eigen::Vector4d& q) {
  Eigen::Vector4d r;
  r.head<3>() = p.w() * q.head<3>() + q.w() * p.head<3>() +
                Eigen::Vector3d(p.head<3>()).cross(Eigen::Vector3d(q.head<3>()));
  r.w() = p.w() * q.w() - p.head<3>().dot(q.head<3>());
  return r;
}

/// The ranges of the variables along the edge: tighter reaches than the limits'.
std::vector<VariableRange> edgeRanges(const Model& model, std::span<const double> q0,
                                      std::span<const double> dq) {
  std::vector<VariableRange> ranges;
  for (std::size_t i = 0; i < q0.size(); ++i) {
    const double end = q0[i] + dq[i];
    // Rounded outwards, except that a variable at rest stays a constant.
    const double slack = dq[i] == 0 ? 0 : kReachRounding * (1 + std::abs(q0[i]) + std::abs(end));
    ranges.push_back({std::min(q0[i], end) - slack, std::max(q0[i], end) + slack});
  }
  for (const Joint& joint : model.joints)
    if (joint.type == JointType::kFloating && joint.first_variable >= 0) {
      const std::size_t first = at(joint.first_variable);
      const bool turns = dq[first + 3] != 0 || dq[first + 4] != 0 || dq[first + 5] != 0;
      for (std::size_t k = first + 3; k < first + 7; ++k)
        ranges[k] = turns ? VariableRange{-1, 1} : VariableRange{q0[k], q0[k]};
    }
  return ranges;
}

}  // namespace

LinkMotion::LinkMotion(std::shared_ptr<const Model> model, int link, std::span<const double> q0,
                       std::span<const double> dq)
    : model_(std::move(model)), link_(link), q0_(q0.begin(), q0.end()), dq_(dq.begin(), dq.end()) {
  const std::size_t variables = model_->variables.size();
  if (q0.size() != variables || dq.size() != variables)
    throw std::invalid_argument("LinkMotion: " + std::to_string(q0.size()) + " and " +
                                std::to_string(dq.size()) + " numbers for a model of " +
                                std::to_string(variables) + " variables");
  if (link < 0 || link >= static_cast<int>(model_->links.size()))
    throw std::invalid_argument("LinkMotion: the model has no link " + std::to_string(link));
  q_.resize(variables);
  X_WL_.resize(model_->links.size());
  rates_.assign(model_->joints.size(), 0);
  for (int l = link; l >= 0; l = model_->joints[at(model_->links[at(l)].joint)].parent_link) {
    const int joint = model_->links[at(l)].joint;
    path_.push_back(joint);
    const Joint& j = model_->joints[at(joint)];
    const Follows f = follows(*model_, j);
    const bool single = j.type == JointType::kRevolute || j.type == JointType::kContinuous ||
                        j.type == JointType::kPrismatic;
    if (single && f.variable >= 0) rates_[at(joint)] = f.multiplier * dq_[at(f.variable)];
  }
  std::reverse(path_.begin(), path_.end());

  const std::vector<VariableRange> ranges = edgeRanges(*model_, q0_, dq_);
  const RelativeMotion motion =
      relativeMotion(*model_, link, -1, Eigen::Vector3d::Zero(), 0, ranges);
  std::vector<JointMotion> joint_motion(model_->joints.size());
  jointMotion(*model_, dq_, joint_motion);
  base_reach_ = motion.base_reach;
  bound_.speed = speedBound(*model_, motion, joint_motion);
  bound_.acceleration = accelerationBound(*model_, motion, joint_motion);
  // omega is the sum of the joints' rates about axes that the joints nearer to the root turn: its
  // derivative is at most the sum of the products of two different rates.
  for (const int joint : path_) {
    const double angle = joint_motion[at(joint)].angle;
    bound_.angular_acceleration += bound_.angular_speed * angle;
    bound_.angular_speed += angle;
  }
  bound_.angular_speed *= 1 + kBoundRounding;
  bound_.angular_acceleration *= 1 + kBoundRounding;
}

void LinkMotion::configuration(double t, std::span<double> q) const {
  for (std::size_t i = 0; i < q0_.size(); ++i) q[i] = q0_[i] + t * dq_[i];
  for (const Joint& joint : model_->joints) {
    if (joint.type != JointType::kFloating || joint.first_variable < 0) continue;
    const std::size_t first = at(joint.first_variable) + 3;
    const Eigen::Vector3d turn(dq_[first], dq_[first + 1], dq_[first + 2]);
    const double angle = turn.norm();
    double s = 0, c = 1;
    collision::sineCosine(angle * t / 2, s, c);
    Eigen::Vector4d step(0, 0, 0, c);
    if (angle > 0) step.head<3>() = s / angle * turn;
    const Eigen::Vector4d start(q0_[first], q0_[first + 1], q0_[first + 2], q0_[first + 3]);
    const Eigen::Vector4d now = product(start, step);
    for (std::size_t k = 0; k < 4; ++k) q[first + k] = now[static_cast<Eigen::Index>(k)];
  }
}

void LinkMotion::place(double t) const {
  if (placed_ == t) return;
  configuration(t, q_);
  forwardKinematics(*model_, q_, X_WL_);
  placed_ = t;
}

Pose LinkMotion::pose(double t) const {
  place(t);
  return X_WL_[at(link_)];
}

collision::FrameVelocity LinkMotion::velocity(double t) const {
  place(t);
  collision::FrameVelocity v;
  const Eigen::Vector3d origin = X_WL_[at(link_)].translation;
  const auto turn = [&](const Eigen::Vector3d& omega, const Pose& X_WC) {
    v.angular += omega;
    v.linear += omega.cross(Eigen::Vector3d(origin - X_WC.translation));
  };
  for (const int i : path_) {
    const Joint& joint = model_->joints[at(i)];
    const Pose& X_WC = X_WL_[at(joint.child_link)];
    const Pose X_WJ =
        joint.parent_link < 0 ? joint.X_PJ : X_WL_[at(joint.parent_link)] * joint.X_PJ;
    const auto d = [&](std::size_t k) { return dq_[at(joint.first_variable) + k]; };
    switch (joint.type) {
      case JointType::kFixed:
        break;
      case JointType::kRevolute:
      case JointType::kContinuous:
        turn(rates_[at(i)] * (X_WC.rotation * joint.axis), X_WC);
        break;
      case JointType::kPrismatic:
        v.linear += rates_[at(i)] * (X_WJ.rotation * joint.axis);
        break;
      case JointType::kPlanar: {
        Eigen::Vector3d x, y;
        planeAxes(joint.axis, x, y);
        v.linear += X_WJ.rotation * (d(0) * x + d(1) * y);
        turn(d(2) * (X_WC.rotation * joint.axis), X_WC);
        break;
      }
      case JointType::kFloating:
        v.linear += X_WJ.rotation * Eigen::Vector3d(d(0), d(1), d(2));
        turn(X_WC.rotation * Eigen::Vector3d(d(3), d(4), d(5)), X_WC);
        break;
    }
  }
  return v;
}

collision::FrameMotionBound LinkMotion::bound(double, double) const { return bound_; }

double LinkMotion::rounding(double reach) const {
  return kinematicsRounding(*model_, base_reach_ + reach);
}

collision::PointMotion pointMotion(const Model& model, const RelativeMotion& motion,
                                   std::span<const double> velocity, const RateLimits& limits) {
  std::vector<JointMotion> rates(model.joints.size()), present(rates.size());
  collision::PointMotion result;
  jointMotion(model, velocity, present);
  result.speed = speedBound(model, motion, present);
  jointMotion(model, limits.velocity, rates);
  for (std::size_t j = 0; j < rates.size(); ++j) {
    rates[j].angle = std::max(rates[j].angle, present[j].angle);
    rates[j].travel = std::max(rates[j].travel, present[j].travel);
  }
  result.speed_cap = speedBound(model, motion, rates);
  result.acceleration = accelerationBound(model, motion, rates);
  // Points accelerate with the joints' accelerations as they move with their velocities.
  jointMotion(model, limits.acceleration, rates);
  result.acceleration += speedBound(model, motion, rates);
  const auto known = [](double x) {
    return std::isnan(x) ? std::numeric_limits<double>::infinity() : x;
  };
  return {known(result.speed), known(result.acceleration), known(result.speed_cap)};
}

}  // namespace leeway::robots
