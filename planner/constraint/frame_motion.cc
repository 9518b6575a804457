#include "planner/constraint/frame_motion.h"

#include "collision/base/numbers.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

FrameMotion::FrameMotion(const CompiledScene& scene, int link, const robots::Pose& X_LF)
    : scene_(&scene), link_(link), X_LF_(X_LF) {
  const robots::Model& model = scene.model();
  const ConfigurationSpace& space = scene.space();
  q_.resize(model.variables.size());
  dq_.resize(at(space.size()));
  point_.resize(at(space.size()));
  variables_dq_.resize(model.variables.size());
  moved_.resize(model.joints.size());
  X_WL_.resize(model.links.size());
  robots::findChain(model, {&link_, 1}, chain_);
  // Variables that are not planned stay at their values. Otherwise a robot whose SRDF connects it
  // to the world by a floating joint would have no reach.
  scene.expand(point_, q_);
  std::vector<robots::VariableRange> ranges;
  for (const double q : q_) ranges.push_back({q, q});
  for (int i = 0; i < space.size(); ++i)
    ranges[at(space.variables()[at(i)])] = {space.lower(i), space.upper(i)};
  motion_ = robots::relativeMotion(model, link, -1, X_LF.translation, 0, ranges);
  for (const robots::RelativeMotion::Term& term : motion_.terms) joints_.push_back(term.joint);
}

robots::Pose FrameMotion::poseAt(std::span<const double> point) {
  scene_->expand(point, q_);
  robots::chainKinematics(scene_->model(), q_, chain_, X_WL_);
  return X_WL_[at(link_)] * X_LF_;
}

void FrameMotion::begin(std::span<const double> a, std::span<const double> b) {
  const ConfigurationSpace& space = scene_->space();
  a_ = a;
  b_ = b;
  space.difference(a, b, dq_);
  for (std::size_t i = 0; i < dq_.size(); ++i) variables_dq_[at(space.variables()[i])] = dq_[i];
  robots::jointMotion(scene_->model(), joints_, variables_dq_, moved_);
  turns_ = 0;
  for (const int joint : joints_) turns_ += moved_[at(joint)].angle;
}

robots::Pose FrameMotion::poseAt(double t) {
  scene_->space().interpolate(a_, b_, t, point_);
  return poseAt(std::span<const double>(point_));
}

ChordDeparture FrameMotion::departure(double t0, double t1) {
  const double part = t1 - t0;
  poseAt(t0 / 2 + t1 / 2);
  const double acceleration =
      robots::localMotionBound(scene_->model(), motion_, moved_, X_WL_, part / 2).acceleration;
  const double turns = turns_ * part;
  return {acceleration * part * part / 8, 1.5 * turns * turns / 8};
}

ChordDeparture FrameMotion::rounding() const {
  return {kLineRounding * (1 + motion_.base_reach), kLineRounding};
}

}  // namespace leeway::planner
