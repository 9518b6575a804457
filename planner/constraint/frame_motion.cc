#include "planner/constraint/frame_motion.h"

#include <algorithm>
#include <array>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

namespace {

/// The values of all variables where the planned ones are 0.
std::vector<double> othersOf(const CompiledScene& scene) {
  std::vector<double> q(scene.model().variables.size());
  scene.expand(std::vector<double>(at(scene.space().size())), q);
  return q;
}

}  // namespace

FrameMotion::FrameMotion(const CompiledScene& scene, int link, const robots::Pose& X_LF, int base)
    : FrameMotion(scene.space(), othersOf(scene), link, X_LF, base) {}

FrameMotion::FrameMotion(const ConfigurationSpace& space, std::vector<double> configuration,
                         int link, const robots::Pose& X_LF, int base)
    : space_(&space), link_(link), base_(base), X_LF_(X_LF), q_(std::move(configuration)) {
  const robots::Model& model = space.model();
  dq_.resize(at(space.size()));
  point_.resize(at(space.size()));
  variables_dq_.resize(model.variables.size());
  moved_.resize(model.joints.size());
  X_WL_.resize(model.links.size());
  robots::findChain(model, std::array{link_, base_}, chain_);
  // Variables that are not planned stay at their values. Otherwise a robot whose SRDF connects it
  // to the world by a floating joint would have no reach.
  std::vector<robots::VariableRange> ranges;
  for (const double q : q_) ranges.push_back({q, q});
  for (int i = 0; i < space.size(); ++i)
    ranges[at(space.variables()[at(i)])] = {space.lower(i), space.upper(i)};
  motion_ = robots::relativeMotion(model, link, base, X_LF.translation, 0, ranges);
  // Poses of both links are computed from the world.
  size_ = motion_.base_reach;
  if (base >= 0)
    for (const auto& [of, p] : {std::pair(link, X_LF.translation), {base, Eigen::Vector3d::Zero()}})
      size_ += robots::relativeMotion(model, of, -1, p, 0, ranges).base_reach;
  for (const robots::RelativeMotion::Term& term : motion_.terms) joints_.push_back(term.joint);
}

robots::Pose FrameMotion::poseAt(std::span<const double> point) {
  for (std::size_t i = 0; i < point.size(); ++i) q_[at(space_->variables()[i])] = point[i];
  robots::chainKinematics(space_->model(), q_, chain_, X_WL_);
  const robots::Pose X_WF = X_WL_[at(link_)] * X_LF_;
  return base_ < 0 ? X_WF : X_WL_[at(base_)].inverse() * X_WF;
}

void FrameMotion::begin(std::span<const double> a, std::span<const double> b) {
  a_ = a;
  b_ = b;
  space_->difference(a, b, dq_);
  move(dq_);
}

void FrameMotion::move(std::span<const double> difference) {
  for (std::size_t i = 0; i < difference.size(); ++i)
    variables_dq_[at(space_->variables()[i])] = difference[i];
  robots::jointMotion(space_->model(), joints_, variables_dq_, moved_);
  turns_ = 0;
  for (const int joint : joints_) turns_ += moved_[at(joint)].angle;
}

robots::Pose FrameMotion::poseAt(double t) {
  space_->interpolate(a_, b_, t, point_);
  return poseAt(std::span<const double>(point_));
}

ChordDeparture FrameMotion::departure(double t0, double t1) {
  const double part = t1 - t0;
  poseAt(t0 / 2 + t1 / 2);
  const double acceleration =
      robots::localMotionBound(space_->model(), motion_, moved_, X_WL_, part / 2).acceleration;
  const double turns = turns_ * part;
  return {acceleration * part * part / 8, 1.5 * turns * turns / 8};
}

double FrameMotion::speed(int parts) {
  // Over a part of length h the velocity departs from that of the chord by at most A h / 2, and the
  // origin by A h^2 / 8.
  double speed = 0;
  Eigen::Vector3d p0 = poseAt(0).translation;
  for (int k = 0; k < parts; ++k) {
    const double t0 = static_cast<double>(k) / parts, t1 = static_cast<double>(k + 1) / parts;
    const Eigen::Vector3d p1 = poseAt(t1).translation;
    const double off = 4 * departure(t0, t1).origin + 2 * rounding().origin;
    speed = std::max(speed, ((p1 - p0).norm() + off) * parts);
    p0 = p1;
  }
  return speed * (1 + kLineRounding);
}

ChordDeparture FrameMotion::reach(std::span<const double> difference) {
  move(difference);
  return {robots::speedBound(space_->model(), motion_, moved_), turns_};
}

ChordDeparture FrameMotion::rounding() const {
  return {kLineRounding * (1 + size_), kLineRounding};
}

}  // namespace leeway::planner
