// Links that meet at a joint.

#include <cmath>
#include <numbers>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {
namespace {

/// Two links, seen at one configuration after the other.
class Looks {
 public:
  Looks(const Model& model, int link_a, int link_b)
      : model_(model), a_(link_a), b_(link_b), X_WL_(model.links.size()) {}

  bool touch(std::span<const double> q) {
    forwardKinematics(model_, q, X_WL_);
    collision::DistanceRequest request;
    request.depth = false;
    for (const Geometry& g : model_.links[at(a_)].geometries)
      for (const Geometry& h : model_.links[at(b_)].geometries)
        if (!(collision::distance(g.shape, X_WL_[at(a_)] * g.X_BG, h.shape, X_WL_[at(b_)] * h.X_BG,
                                  request, scratch_)
                  .distance.lower > kTouch))
          return true;
    return false;
  }

 private:
  const Model& model_;
  int a_, b_;
  std::vector<Pose> X_WL_;
  collision::Scratch scratch_;
};

std::vector<int> jointsAbove(const Model& model, int link) {
  std::vector<int> joints;
  for (; link >= 0; link = model.joints[at(joints.back())].parent_link)
    joints.push_back(model.links[at(link)].joint);
  return joints;
}

}  // namespace

int onlyJointBetween(const Model& model, int link_a, int link_b) {
  std::vector<int> a = jointsAbove(model, link_a), b = jointsAbove(model, link_b);
  while (!a.empty() && !b.empty() && a.back() == b.back()) {
    a.pop_back();
    b.pop_back();
  }
  int only = -1;
  for (const std::vector<int>* joints : {&a, &b})
    for (const int j : *joints) {
      if (model.joints[at(j)].type == JointType::kFixed) continue;
      if (only >= 0) return -1;
      only = j;
    }
  return only;
}

Touch touchAtJoint(const Model& model, int link_a, int link_b, int joint) {
  std::vector<double> q = model.defaultConfiguration();
  Looks looks(model, link_a, link_b);
  if (!looks.touch(q)) return Touch::kApart;
  const Joint* master = &model.joints[at(joint)];
  double multiplier = 1;  // how often the joint goes as far as its master
  for (; master->mimic >= 0; master = &model.joints[at(master->mimic)])
    multiplier *= master->multiplier;
  if (master->variable_count != 1) return Touch::kSometimes;
  const std::size_t v = at(master->first_variable);
  double lower = model.variables[v].lower, upper = model.variables[v].upper;
  if (!std::isfinite(lower) || !std::isfinite(upper)) {
    // A joint that slides without limits parts them.
    if (model.joints[at(joint)].type == JointType::kPrismatic) return Touch::kSometimes;
    lower = q[v];
    upper = q[v] + 2 * std::numbers::pi / std::abs(multiplier);
    if (!std::isfinite(upper)) return Touch::kSometimes;
  }
  for (int k = 0; k <= kTouchLooks; ++k) {
    q[v] = lower + (upper - lower) * k / kTouchLooks;
    if (!looks.touch(q)) return Touch::kSometimes;
  }
  return Touch::kEverywhere;
}

}  // namespace leeway::robots
