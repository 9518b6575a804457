#include "planner/verify/frame_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"
#include "planner/verify/path_check.h"

namespace leeway::planner::verification {
namespace {

using robots::Pose;

/// The greatest angle of a rotation that moves the ends of unit vectors by at most `tips` [rad].
double turnOf(double tips) { return tips < 2 ? 2 * std::asin(tips / 2) : kInfinity; }

/// Compares a look at a constraint's frame with the constraint's tolerances.
VerifyStatus judge(const Constraint& constraint, const Pose& X_BR, const FrameLook& look) {
  const Pose X_RF = X_BR.inverse() * look.X_BF;
  // Rounding of placing F in R.
  const double slack = look.slack + kVerifyPose * (1 + look.size + X_BR.translation.norm());
  Eigen::Vector3d nearest = X_RF.translation;
  bool is_anywhere = true;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto& [from, to] = constraint.position[static_cast<std::size_t>(i)];
    nearest[i] = std::clamp(nearest[i], from, to);
    is_anywhere = is_anywhere && std::isinf(from) && std::isinf(to);
  }
  const double off = (X_RF.translation - nearest).norm();
  double angle = 0, most = kInfinity;
  if (constraint.turn == Constraint::Turn::kFixed) {
    const Eigen::AngleAxisd between(
        Eigen::Matrix3d(X_RF.rotation.transpose() * constraint.rotation));
    angle = std::abs(between.angle());
    most = constraint.angle;
  } else if (constraint.turn == Constraint::Turn::kAxis) {
    const Eigen::Vector3d axis = X_RF.rotation * constraint.axis.normalized();
    const Eigen::Vector3d direction = constraint.direction.normalized();
    angle = std::atan2(axis.cross(direction).norm(), axis.dot(direction));
    most = constraint.angle;
  }
  if (off - slack > constraint.position_tolerance || angle - turnOf(slack) > most)
    return VerifyStatus::kRefuted;
  // Both comparisons are false for NaN, which is therefore never certified.
  if ((is_anywhere || off + slack + look.moves <= constraint.position_tolerance) &&
      (constraint.turn == Constraint::Turn::kAny ||
       angle + turnOf(slack) + turnOf(look.tips + slack) <= most))
    return VerifyStatus::kCertified;
  return VerifyStatus::kUndecided;
}

}  // namespace

FrameCheck::FrameCheck(const Problem& problem, int link, const Pose& X_LF, int base)
    : model_(*problem.robot.model),
      variables_(problem.robot.variables),
      space_(problem.robot.model, problem.robot.variables),
      link_(link),
      base_(base),
      X_LF_(X_LF),
      q_(problem.start),
      joints_(jointsAbove(model_, link)),
      base_joints_(jointsAbove(model_, base)) {
  // Joints above both move neither against the other.
  while (!joints_.empty() && !base_joints_.empty() && joints_.back() == base_joints_.back()) {
    joints_.pop_back();
    base_joints_.pop_back();
  }
}

VerifyStatus FrameCheck::check(const Path& path, std::size_t segment, double least,
                               const Judge& judge, double& t) {
  const std::vector<double>& a = path.positions[segment];
  const std::vector<double>& b = path.positions[std::min(segment + 1, path.positions.size() - 1)];
  std::vector<double> difference(a.size()), point(a.size()), dq(model_.variables.size(), 0.0),
      rates(dq), seconds(dq);
  std::vector<Cubic> cubics;
  if (path.times.size() > 1) cubics = cubicsOf(path, segment);
  space_.lineDifference(a, b, difference);
  for (std::size_t i = 0; i < a.size(); ++i)
    dq[at(variables_[i])] = cubics.empty() ? difference[i] : cubics[i].speed();
  for (std::size_t i = 0; i < cubics.size(); ++i)
    seconds[at(variables_[i])] =
        std::max(std::abs(cubics[i].acceleration(0)), std::abs(cubics[i].acceleration(1)));
  std::deque<std::pair<double, double>> open{{0, 1}};
  long looks = 0;
  while (!open.empty()) {
    const auto [begin, end] = open.front();
    open.pop_front();
    t = begin / 2 + end / 2;
    if (++looks > most_ || (stop_ && looks % 64 == 0 && stop_())) return VerifyStatus::kUndecided;
    const double half = end / 2 - begin / 2;
    if (cubics.empty()) space_.alongLine(a, b, t, point);
    for (std::size_t i = 0; i < cubics.size(); ++i) point[i] = cubics[i].at(t);
    for (std::size_t i = 0; i < point.size(); ++i) q_[at(variables_[i])] = point[i];
    const std::vector<Pose> X_WL = placeLinks(model_, q_);
    FrameLook look;
    look.t = t;
    look.half = half;
    const Pose X_WF = X_WL[at(link_)] * X_LF_;
    look.X_BF = base_ < 0 ? X_WF : X_WL[at(base_)].inverse() * X_WF;
    look.size = X_WF.translation.norm() + (base_ < 0 ? 0 : X_WL[at(base_)].translation.norm());
    // Seen from B, F moves at most as far as it does, and the point of B that is at its origin now,
    // seen from the joints above both.
    for (const std::vector<int>* joints : {&joints_, &base_joints_}) {
      const Motion origin = boundMotion(model_, *joints, X_WL, dq, X_WF.translation, 0, half);
      const Motion tips = boundMotion(model_, *joints, X_WL, dq, X_WF.translation, 1, half);
      look.slack += std::max(origin.slack, tips.slack);
      look.moves += origin.speed * half;
      look.tips += (origin.speed + tips.speed) * half;
    }
    if (speeds_) {
      for (std::size_t i = 0; i < cubics.size(); ++i)
        rates[at(variables_[i])] = cubics[i].velocity(t);
      look.most_speed = boundSpeed(model_, joints_, X_WL, {rates, dq, seconds}, X_WF.translation,
                                   half, look.speed);
    }
    switch (judge(look)) {
      case VerifyStatus::kCertified:
        continue;
      case VerifyStatus::kRefuted:
        return VerifyStatus::kRefuted;
      default:
        break;
    }
    if (half < least) return VerifyStatus::kUndecided;
    open.emplace_back(begin, t);
    open.emplace_back(t, end);
  }
  return VerifyStatus::kCertified;
}

std::optional<VerifyResult> findBrokenConstraint(const Problem& problem, const Path& path,
                                                 const std::function<bool()>& stop) {
  for (const Constraint& constraint : problem.constraints) {
    const robots::PoseRegion frame = frameOf(problem, constraint);
    FrameCheck check(problem, frame.link, frame.X_LF, frame.base);
    check.limit(kVerifyPairWork, stop);
    const std::size_t edges = std::max<std::size_t>(1, path.positions.size() - 1);
    for (std::size_t i = 0; i < edges; ++i) {
      double t = 0;
      const VerifyStatus status = check.check(
          path, i, kVerifyConstraintPiece,
          [&](const FrameLook& look) { return judge(constraint, frame.X_WR, look); }, t);
      if (status == VerifyStatus::kCertified) continue;
      VerifyResult result;
      result.status = status;
      result.segment = static_cast<int>(i);
      result.t0 = result.t1 = t;
      result.reason = "constraint '" + constraint.name +
                      (status == VerifyStatus::kRefuted ? "' does not hold for '"
                                                        : "' is not proven to hold for '") +
                      constraint.frame + "'";
      return result;
    }
  }
  return std::nullopt;
}

}  // namespace leeway::planner::verification
