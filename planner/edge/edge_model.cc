#include "planner/edge/edge_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "collision/scene/scene_access.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using robots::Joint;
using robots::Model;
using robots::VariableRange;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// See EdgeModel::jumping_circles: circles that a mimic joint follows with a factor that is no
/// whole number, or by sliding.
std::vector<int> jumpingCircles(const ConfigurationSpace& space) {
  std::vector<int> places;
  const Model& model = space.model();
  for (const ConfigurationSpace::Part& part : space.parts()) {
    if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
    const int master = model.variables[at(space.variables()[at(part.first)])].joint;
    bool jumps = false;
    for (const Joint& mimic : model.joints) {
      double factor = 1;
      const Joint* j = &mimic;
      while (j->mimic >= 0) {
        factor *= j->multiplier;
        j = &model.joints[at(j->mimic)];
      }
      if (j != &model.joints[at(master)] || j == &mimic) continue;
      const bool turns = mimic.type == robots::JointType::kRevolute ||
                         mimic.type == robots::JointType::kContinuous;
      jumps = jumps || !turns || factor != std::round(factor);
    }
    if (jumps) places.push_back(part.first);
  }
  return places;
}

class Builder {
 public:
  Builder(const CompiledScene& compiled, std::span<const VariableRange> ranges)
      : compiled_(compiled), scene_(compiled.scene()), model_(compiled.model()), ranges_(ranges) {}

  std::shared_ptr<const EdgeModel> build(std::span<const robots::LinkGap* const> gaps,
                                         bool needs_limits) {
    result_->needs_limits = needs_limits;
    result_->jumping_circles = jumpingCircles(compiled_.space());
    for (std::size_t p = 0; p < scene_.pairs().size(); ++p) addPair(scene_.pairs()[p], gaps[p]);
    dropUnusedMotions();
    setRounding();
    return result_;
  }

 private:
  const collision::Ball& ballOf(int geometry) const {
    return collision::SceneAccess::bounds(scene_, geometry).outer;
  }

  void addPair(const collision::ScenePair& pair, const robots::LinkGap* gap) {
    const int a = collision::SceneAccess::geometryIndex(scene_, pair.body_a, pair.geometry_a);
    const int b = collision::SceneAccess::geometryIndex(scene_, pair.body_b, pair.geometry_b);
    const int link_a = compiled_.bodyLink(pair.body_a), link_b = compiled_.bodyLink(pair.body_b);
    EdgeModel::Pair result{motionOf(a, link_a, link_b), false, gap};
    // What stands still is never the one that is swept: a motion for each of many things would be
    // bounded on every edge, and a deforming thing has no place for good.
    if (link_b >= 0 && std::isfinite(ballOf(b).radius)) {
      const int other = motionOf(b, link_b, link_a);
      result.is_reversed = accelerationOf(other) < accelerationOf(result.motion);
      if (result.is_reversed) result.motion = other;
    }
    result_->pairs.push_back(result);
  }

  /// Index of the motion of a geometry on `link` seen from `base`.
  int motionOf(int geometry, int link, int base) {
    std::vector<robots::RelativeMotion>& motions = result_->motions;
    const auto [entry, is_new] =
        known_.emplace(std::pair(geometry, base), static_cast<int>(motions.size()));
    if (is_new) motions.push_back(relativeMotion(geometry, link, base));
    return entry->second;
  }

  robots::RelativeMotion relativeMotion(int geometry, int link, int base) const {
    const collision::Ball& ball = ballOf(geometry);
    return robots::relativeMotion(model_, link, base, ball.center, ball.radius, ranges_);
  }

  /// With all joints at unit rate.
  double accelerationOf(int motion) const {
    return robots::accelerationBound(model_, result_->motions[at(motion)], unit_);
  }

  /// Most pairs use the motion of one of their bodies only.
  void dropUnusedMotions() {
    std::vector<int> number(result_->motions.size(), -1);
    std::vector<robots::RelativeMotion> used;
    for (EdgeModel::Pair& pair : result_->pairs) {
      int& kept = number[at(pair.motion)];
      if (kept < 0) {
        kept = static_cast<int>(used.size());
        used.push_back(std::move(result_->motions[at(pair.motion)]));
      }
      pair.motion = kept;
    }
    result_->motions = std::move(used);
  }

  void setRounding() {
    double farthest = 0;
    std::size_t longest = 0;
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b) {
      const auto body = static_cast<int>(b);
      if (compiled_.bodyLink(body) < 0) continue;
      for (std::size_t g = 0; g < scene_.bodies()[b].geometries.size(); ++g) {
        const int geometry =
            collision::SceneAccess::geometryIndex(scene_, body, static_cast<int>(g));
        const robots::RelativeMotion motion =
            relativeMotion(geometry, compiled_.bodyLink(body), -1);
        farthest = std::max(farthest, motion.base_reach);
        longest = std::max(longest, motion.terms.size());
      }
    }
    const double reach = farthest <= kLargestReach / 2 ? 2 * farthest : kLargestReach;
    result_->reach = reach;
    result_->rounding = robots::kinematicsRounding(model_, reach) +
                        static_cast<double>(longest) * reach * kInterpolationRounding;
  }

  const CompiledScene& compiled_;
  const collision::Scene& scene_;
  const Model& model_;
  std::span<const VariableRange> ranges_;
  const std::vector<robots::JointMotion> unit_{model_.joints.size(), {1, 1}};
  std::map<std::pair<int, int>, int> known_;  // geometry and base: index into motions
  std::shared_ptr<EdgeModel> result_ = std::make_shared<EdgeModel>();
};

}  // namespace

std::shared_ptr<const EdgeModel> makeEdgeModel(const CompiledScene& scene,
                                               std::span<const VariableRange> ranges,
                                               std::span<const robots::LinkGap* const> gaps,
                                               bool needs_limits) {
  return Builder(scene, ranges).build(gaps, needs_limits);
}

bool EdgeModel::isSmooth(std::span<const double> a, std::span<const double> b,
                         std::span<const double> difference) const {
  // Inside an edge circles are wrapped: an end that is not would be whole turns from its
  // neighbours.
  const auto wrapped = [](double x) { return x >= -std::numbers::pi && x < std::numbers::pi; };
  return std::all_of(jumping_circles.begin(), jumping_circles.end(), [&](int circle) {
    const std::size_t i = at(circle);
    // Where the edge does not end in b to rounding, it ends a whole turn away.
    return wrapped(a[i]) && wrapped(b[i]) && std::abs(a[i] + difference[i] - b[i]) < 1;
  });
}

void expandDifference(const ConfigurationSpace& space, std::span<const double> difference,
                      std::span<double> dq) {
  std::fill(dq.begin(), dq.end(), 0.0);
  const std::span<const int> variables = space.variables();
  for (std::size_t i = 0; i < variables.size(); ++i) dq[at(variables[i])] = difference[i];
}

}  // namespace leeway::planner
