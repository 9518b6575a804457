#include "planner/compiled/edge_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/largest_value.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using robots::Joint;
using robots::Model;
using robots::VariableRange;

/// See EdgeModel::jumping_circles: circles that a mimic joint follows by sliding, or with a factor
/// that is not an integer.
std::vector<EdgeModel::JumpingCircle> jumpingCircles(const ConfigurationSpace& space) {
  std::vector<EdgeModel::JumpingCircle> circles;
  const Model& model = space.model();
  for (const ConfigurationSpace::Part& part : space.parts()) {
    if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
    const int master = model.variables[at(space.variables()[at(part.first)])].joint;
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
      if (turns && factor == std::round(factor)) continue;
      circles.push_back({part.first, static_cast<int>(&mimic - model.joints.data())});
      break;
    }
  }
  return circles;
}

/// See RobotMotions::largest_exact.
double largestExact(const ConfigurationSpace& space, int i) {
  const int variable = space.variables()[at(i)];
  const double most = largestValue(space.model(), variable);
  if (isAngle(space.model(), variable)) return most;
  const double limit = std::max(std::abs(space.lower(i)), std::abs(space.upper(i)));
  return std::min(most, std::max(limit, kLargestLengthOutside));
}

/// All other joints stand still along every edge.
std::vector<int> movedJoints(const ConfigurationSpace& space) {
  const Model& model = space.model();
  std::vector<double> any(model.variables.size(), 0);
  for (const int v : space.variables()) any[at(v)] = 1;
  std::vector<robots::JointMotion> motion(model.joints.size());
  robots::jointMotion(model, any, motion);
  std::vector<int> moved;
  for (std::size_t j = 0; j < motion.size(); ++j)
    if (motion[j].angle != 0 || motion[j].travel != 0) moved.push_back(static_cast<int>(j));
  return moved;
}

class EdgeModelBuilder {
 public:
  EdgeModelBuilder(const ConfigurationSpace& space, const collision::Scene& scene,
                   std::span<const int> carriers, std::span<const VariableRange> ranges)
      : space_(space), scene_(scene), carriers_(carriers), model_(space.model()), ranges_(ranges) {
    result_.jumping_circles = jumpingCircles(space);
    result_.moved_joints = movedJoints(space);
    for (int i = 0; i < space.size(); ++i) result_.largest_exact.push_back(largestExact(space, i));
  }

  RobotMotions build(std::span<const robots::LinkGap* const> gaps) {
    for (std::size_t p = 0; p < scene_.pairs().size(); ++p) addPair(scene_.pairs()[p], gaps[p]);
    addWorldMotions();
    keepUsedMotions();
    setRounding();
    return std::move(result_);
  }

 private:
  const collision::Ball& ballOf(int geometry) const {
    return collision::SceneAccess::bounds(scene_, geometry).outer;
  }
  bool moves(int body) const { return scene_.bodies()[at(body)].moving; }
  /// The link that carries a body; -1: the body stands still.
  int linkOf(int body) const { return moves(body) ? carriers_[at(body)] : -1; }
  int geometryOf(int body, int geometry) const {
    return collision::SceneAccess::geometryIndex(scene_, body, geometry);
  }

  void addPair(const collision::ScenePair& pair, const robots::LinkGap* gap) {
    const int a = geometryOf(pair.body_a, pair.geometry_a),
              b = geometryOf(pair.body_b, pair.geometry_b);
    const int link_a = linkOf(pair.body_a), link_b = linkOf(pair.body_b);
    EdgeModel::Pair result{motionOf(a, link_a, link_b), false, gapOf(gap)};
    // A static body is never the swept one. Otherwise a motion for each of many objects would be
    // bounded on every edge, and a deforming obstacle has no fixed shape.
    if (link_b >= 0 && std::isfinite(ballOf(b).radius)) {
      const int other = motionOf(b, link_b, link_a);
      result.is_reversed = accelerationOf(other) < accelerationOf(result.motion);
      if (result.is_reversed) result.motion = other;
    }
    result_.pairs.push_back(result);
  }

  /// Index of a pair's gap; -1 for null.
  int gapOf(const robots::LinkGap* table) {
    if (table == nullptr) return -1;
    const float most = std::accumulate(table->gaps.begin(), table->gaps.end(), table->cell_gap,
                                       [](float x, float y) { return std::max(x, y); });
    result_.gaps.push_back(
        {table, angleOf(table->joint), angleOf(table->other), static_cast<double>(most)});
    return static_cast<int>(result_.gaps.size()) - 1;
  }
  EdgeModel::Angle angleOf(int joint) const {
    const robots::KinematicStep& step = model_.steps[at(joint)];
    const std::span<const int> planned = space_.variables();
    const auto found = std::find(planned.begin(), planned.end(), step.variable);
    if (found == planned.end())  // its range is its value
      return {-1, 0, step.multiplier * ranges_[at(step.variable)].lower + step.offset};
    return {static_cast<int>(found - planned.begin()), step.multiplier, step.offset};
  }

  void addWorldMotions() {
    result_.of_world.assign(geometryCount(), -1);
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b) {
      const auto body = static_cast<int>(b);
      if (!moves(body)) continue;
      for (std::size_t g = 0; g < scene_.bodies()[b].geometries.size(); ++g) {
        const int geometry = geometryOf(body, static_cast<int>(g));
        result_.of_world[at(geometry)] = motionOf(geometry, linkOf(body), -1);
      }
    }
  }
  std::size_t geometryCount() const {
    std::size_t count = 0;
    for (const collision::Body& body : scene_.bodies()) count += body.geometries.size();
    return count;
  }

  /// Index of the motion of a geometry on `link` relative to `base`.
  int motionOf(int geometry, int link, int base) {
    std::vector<robots::RelativeMotion>& motions = result_.motions;
    const auto [entry, is_new] =
        known_.emplace(std::pair(geometry, base), static_cast<int>(motions.size()));
    if (is_new) {
      const collision::Ball& ball = ballOf(geometry);
      motions.push_back(
          robots::relativeMotion(model_, link, base, ball.center, ball.radius, ranges_));
    }
    return entry->second;
  }

  /// With all joints at unit rate.
  double accelerationOf(int motion) const {
    return robots::accelerationBound(model_, result_.motions[at(motion)], unit_);
  }

  /// Most pairs use the motion of only one of their bodies. The order is that of the first bodies
  /// of pairs; each body's motions relative to the world come after those relative to other bodies.
  void keepUsedMotions() {
    std::vector<int> number(result_.motions.size(), -1);
    std::vector<robots::RelativeMotion> used;
    const auto keep = [&](int& motion) {
      int& kept = number[at(motion)];
      if (kept < 0) {
        kept = static_cast<int>(used.size());
        used.push_back(std::move(result_.motions[at(motion)]));
      }
      motion = kept;
    };
    std::size_t p = 0;
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b) {
      const auto body = static_cast<int>(b);
      for (; p < result_.pairs.size() &&
             std::min(scene_.pairs()[p].body_a, scene_.pairs()[p].body_b) == body;
           ++p)
        keep(result_.pairs[p].motion);
      if (!moves(body)) continue;
      for (std::size_t g = 0; g < scene_.bodies()[b].geometries.size(); ++g)
        keep(result_.of_world[at(geometryOf(body, static_cast<int>(g)))]);
    }
    result_.motions = std::move(used);
  }

  void setRounding() {
    double farthest = 0;
    std::size_t longest = 0;
    for (const int motion : result_.of_world) {
      if (motion < 0) continue;
      farthest = std::max(farthest, result_.motions[at(motion)].base_reach);
      longest = std::max(longest, result_.motions[at(motion)].terms.size());
    }
    const double reach = farthest <= kLargestReach / 2 ? 2 * farthest : kLargestReach;
    result_.reach = reach;
    result_.rounding = robots::kinematicsRounding(model_, reach) +
                       static_cast<double>(longest) * reach * kInterpolationRounding;
  }

  const ConfigurationSpace& space_;
  const collision::Scene& scene_;
  std::span<const int> carriers_;
  const Model& model_;
  std::span<const VariableRange> ranges_;
  const std::vector<robots::JointMotion> unit_{model_.joints.size(), {1, 1}};
  std::map<std::pair<int, int>, int> known_;  // geometry and base: index into motions
  RobotMotions result_;
};

}  // namespace

RobotMotions makeRobotMotions(const ConfigurationSpace& space, const collision::Scene& robot,
                              std::span<const int> carriers, std::span<const VariableRange> ranges,
                              std::span<const robots::LinkGap* const> gaps) {
  return EdgeModelBuilder(space, robot, carriers, ranges).build(gaps);
}

bool EdgeModel::isSmooth(std::span<const double> a, std::span<const double> b,
                         std::span<const double> difference) const {
  // Inside an edge circles are wrapped. An end that is not wrapped would be whole turns from its
  // neighbours.
  const auto wrapped = [](double x) { return x >= -std::numbers::pi && x < std::numbers::pi; };
  return std::all_of(jumping_circles.begin(), jumping_circles.end(), [&](JumpingCircle circle) {
    const std::size_t i = at(circle.place);
    // If the edge does not end in b to rounding, it ends a whole turn away.
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
