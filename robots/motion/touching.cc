// Links that meet at a joint.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "robots/base/tolerances.h"
#include "robots/motion/kept_proofs.h"

namespace leeway::robots {
namespace {

/// Two links, seen at one configuration after the other.
class Looks {
 public:
  Looks(const Model& model, int link_a, int link_b)
      : model_(model), a_(link_a), b_(link_b), X_WL_(model.links.size()) {}

  /// Whether they are not proven apart.
  bool touch(std::span<const double> q) {
    return any(q, [](const collision::Interval& distance) { return !(distance.lower > kTouch); });
  }
  /// Whether they are proven to touch.
  bool surelyTouch(std::span<const double> q) {
    return any(q, [](const collision::Interval& distance) { return distance.upper <= kTouch; });
  }

 private:
  template <class Is>
  bool any(std::span<const double> q, const Is& is) {
    forwardKinematics(model_, q, X_WL_);
    collision::DistanceRequest request;
    request.depth = false;
    for (const Geometry& g : model_.links[at(a_)].geometries)
      for (const Geometry& h : model_.links[at(b_)].geometries)
        if (is(collision::distance(g.shape, X_WL_[at(a_)] * g.X_BG, h.shape, X_WL_[at(b_)] * h.X_BG,
                                   request, scratch_)
                   .distance))
          return true;
    return false;
  }

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

/// Those that move two links against each other, whatever their limits.
std::vector<int> jointsBetween(const Model& model, int link_a, int link_b) {
  std::vector<int> a = jointsAbove(model, link_a), b = jointsAbove(model, link_b);
  while (!a.empty() && !b.empty() && a.back() == b.back()) {
    a.pop_back();
    b.pop_back();
  }
  a.insert(a.end(), b.begin(), b.end());
  std::erase_if(a, [&](int j) { return model.joints[at(j)].type == JointType::kFixed; });
  return a;
}

}  // namespace

int onlyJointBetween(const Model& model, int link_a, int link_b) {
  const std::vector<int> between = jointsBetween(model, link_a, link_b);
  return between.size() == 1 ? between[0] : -1;
}

std::vector<std::pair<int, int>> touchingAtRest(const Model& model, const Stop& stop) {
  const std::vector<double> q = model.fileConfiguration();
  const auto parent = [&](int link) {
    return model.joints[at(model.links[at(link)].joint)].parent_link;
  };
  std::set<std::pair<int, int>> disabled;
  for (const DisabledPair& pair : model.disabled_pairs)
    disabled.insert(std::minmax(pair.link_a, pair.link_b));
  const std::set<std::pair<int, int>> enabled(model.enabled_pairs.begin(),
                                              model.enabled_pairs.end());
  std::vector<std::pair<int, int>> touching;
  for (int a = 0; a < static_cast<int>(model.links.size()); ++a)
    for (int b = a + 1; b < static_cast<int>(model.links.size()); ++b) {
      const bool is_adjacent = parent(a) == b || parent(b) == a;
      // Pairs of enable_collisions stay checked.
      if (is_adjacent || enabled.count({a, b}) != 0 || disabled.count({a, b}) != 0 ||
          model.links[at(a)].geometries.empty() || model.links[at(b)].geometries.empty() ||
          jointsBetween(model, a, b).empty())
        continue;
      throwIfStopped(stop, "links that touch at rest were looked for");
      if (Looks(model, a, b).surelyTouch(q)) touching.emplace_back(a, b);
    }
  return touching;
}

namespace {

Touch touchAtJoint(const Model& model, int link_a, int link_b) {
  const int joint = onlyJointBetween(model, link_a, link_b);
  if (joint < 0) return Touch::kApart;
  std::vector<double> q = model.fileConfiguration();
  Looks looks(model, link_a, link_b);
  if (!looks.touch(q)) return Touch::kApart;
  const Joint* master = &model.joints[at(joint)];
  double multiplier = 1;  // how often the joint goes as far as its master
  for (; master->mimic >= 0; master = &model.joints[at(master->mimic)])
    multiplier *= master->multiplier;
  if (master->variable_count != 1) return Touch::kSometimes;
  const std::size_t v = at(master->first_variable);
  auto [lower, upper] = model.variables[v].touchRange();
  if (!std::isfinite(lower) || !std::isfinite(upper)) {
    // A joint that slides without limits parts them.
    if (model.joints[at(joint)].type == JointType::kPrismatic) return Touch::kSometimes;
    lower = q[v];
    upper = q[v] + 2 * std::numbers::pi / std::abs(multiplier);
    if (!std::isfinite(upper)) return Touch::kSometimes;
  } else if (const double turn = 2 * std::numbers::pi / std::abs(multiplier);
             model.joints[at(joint)].type != JointType::kPrismatic && upper - lower > turn) {
    upper = lower + turn;  // steps over many turns could meet the same few angles again and again
  }
  for (int k = 0; k <= kTouchLooks; ++k) {
    q[v] = lower + (upper - lower) * k / kTouchLooks;
    if (!looks.touch(q)) return Touch::kSometimes;
  }
  return Touch::kEverywhere;
}

}  // namespace

std::vector<Touch> touchAtJoints(const Model& model, std::span<const std::pair<int, int>> pairs,
                                 const Stop& stop) {
  const auto decide = [&](const std::pair<int, int>& pair) {
    return static_cast<unsigned char>(touchAtJoint(model, pair.first, pair.second));
  };
  std::vector<Touch> touches;
  for (const unsigned char touch :
       decidePairs(model, pairs, {"touch", "links that touch were looked for", decide}, stop))
    touches.push_back(static_cast<Touch>(touch));
  return touches;
}

}  // namespace leeway::robots
