// Links that meet at a joint.

#include <algorithm>
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

/// Two links, looked at while one joint moves.
class Looks {
 public:
  Looks(const Model& model, int link_a, int link_b)
      : model_(model), a_(link_a), b_(link_b), X_WL_(model.links.size()) {}

  /// The separation of the links' nearest geometries [m]; without `depth` an overlap has no lower
  /// end.
  collision::Interval separation(std::span<const double> q, bool depth) {
    forwardKinematics(model_, q, X_WL_);
    collision::DistanceRequest request;
    request.depth = depth;
    collision::Interval least{kInfinity, kInfinity};
    for (const Geometry& g : model_.links[at(a_)].geometries)
      for (const Geometry& h : model_.links[at(b_)].geometries) {
        const collision::Interval found =
            collision::distance(g.shape, X_WL_[at(a_)] * g.X_BG, h.shape, X_WL_[at(b_)] * h.X_BG,
                                request, scratch_)
                .distance;
        least = {std::min(least.lower, found.lower), std::min(least.upper, found.upper)};
      }
    return least;
  }

  /// Whether they are apart somewhere while variable v goes from its value in `q` to `end`.
  bool partTowards(std::vector<double> q, std::size_t v, double end) {
    const double begin = q[v];
    for (int k = 1; k <= kTouchLooks; ++k) {
      q[v] = begin + (end - begin) * k / kTouchLooks;
      if (separation(q, false).lower > kTouch) return true;
    }
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

bool touchAtDefault(const Model& model, int link_a, int link_b, int joint) {
  const std::vector<double> q = model.defaultConfiguration();
  Looks looks(model, link_a, link_b);
  if (looks.separation(q, false).lower > kTouch) return false;
  if (looks.separation(q, true).lower >= -kShallow) return true;
  const Joint* moving = &model.joints[at(joint)];
  while (moving->mimic >= 0) moving = &model.joints[at(moving->mimic)];
  const std::size_t v = at(moving->first_variable);
  if (moving->type == JointType::kContinuous)
    return !looks.partTowards(q, v, q[v] + 2 * std::numbers::pi);
  if (moving->type != JointType::kRevolute && moving->type != JointType::kPrismatic) return false;
  const auto parts = [&](double end) {  // without a limit anything comes apart
    return !std::isfinite(end) || (end != q[v] && looks.partTowards(q, v, end));
  };
  const Variable& variable = model.variables[v];
  return !(parts(variable.lower) && parts(variable.upper));
}

}  // namespace leeway::robots
