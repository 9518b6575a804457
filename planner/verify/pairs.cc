#include "planner/verify/pairs.h"

#include <algorithm>

#include "collision/base/numbers.h"
#include "planner/verify/kinematics.h"

namespace leeway::planner::verification {
namespace {

using robots::Joint;
using robots::JointType;
using robots::Model;

bool same(const std::pair<std::string, std::string>& names, const std::string& a,
          const std::string& b) {
  return (names.first == a && names.second == b) || (names.first == b && names.second == a);
}

/// Which pairs may touch, and the margins of the others.
class Rules {
 public:
  explicit Rules(const Problem& problem) : problem_(problem), model_(*problem.robot.model) {}

  bool mayTouch(const Body& a, const Body& b) const {
    for (const auto& names : problem_.contacts.allowed)
      if (same(names, a.name, b.name)) return true;
    const bool link_a = a.link >= 0 && !a.attached, link_b = b.link >= 0 && !b.attached;
    if (link_a && link_b) return disabled(a.link, b.link) || adjacent(a.link, b.link);
    if (a.attached && link_b) return holds(a, b.link);
    if (b.attached && link_a) return holds(b, a.link);
    return false;
  }

  double margin(const Body& a, const Body& b) const {
    double margin = problem_.margins.common;
    for (const PairMargin& m : problem_.margins.pairs)
      if (same({m.a, m.b}, a.name, b.name)) margin = m.margin;
    return margin;
  }

  /// Whether the planner can change the joint's position.
  bool moves(int joint_index) const {
    const Joint* joint = &model_.joints[at(joint_index)];
    for (; joint->mimic >= 0; joint = &model_.joints[at(joint->mimic)])
      if (joint->multiplier == 0) return false;  // at rest at its offset
    for (int k = 0; k < joint->variable_count; ++k) {
      const int v = joint->first_variable + k;
      const robots::Variable& variable = model_.variables[at(v)];
      if (variable.lower < variable.upper &&
          std::count(problem_.robot.variables.begin(), problem_.robot.variables.end(), v) > 0)
        return true;
    }
    return false;
  }

 private:
  bool disabled(int a, int b) const {
    if (problem_.contacts.replace_srdf) return false;
    return std::any_of(model_.disabled_pairs.begin(), model_.disabled_pairs.end(),
                       [&](const robots::DisabledPair& d) {
                         return (d.link_a == a && d.link_b == b) ||
                                (d.link_a == b && d.link_b == a);
                       });
  }

  int parent(int link) const { return model_.joints[at(model_.links[at(link)].joint)].parent_link; }

  /// The highest link that fixed joints tie to this one.
  int block(int link) const {
    while (parent(link) >= 0 &&
           model_.joints[at(model_.links[at(link)].joint)].type == JointType::kFixed)
      link = parent(link);
    return link;
  }

  /// Links with one joint between them touch there. Without an SRDF, or MoveIt's matrix in its
  /// place, so do the links that fixed joints tie to them.
  bool adjacent(int a, int b) const {
    if (parent(a) == b || parent(b) == a) return true;
    if (model_.has_srdf || problem_.contacts.replace_srdf) return false;
    const int block_a = block(a), block_b = block(b);
    const auto above = [&](int x) { return parent(x) < 0 ? -1 : block(parent(x)); };
    return block_a == block_b || above(block_a) == block_b || above(block_b) == block_a;
  }

  bool holds(const Body& held, int link) const {
    for (const Attachment& attachment : problem_.robot.attachments)
      if (attachment.object.name == held.name && attachment.link == held.link)
        return link == held.link ||
               std::count(attachment.touch_links.begin(), attachment.touch_links.end(), link) > 0;
    return false;
  }

  const Problem& problem_;
  const Model& model_;
};

}  // namespace

std::vector<Body> collectBodies(const Problem& problem) {
  std::vector<Body> bodies;
  for (std::size_t l = 0; l < problem.robot.model->links.size(); ++l)
    bodies.push_back({problem.robot.model->links[l].name,
                      &problem.robot.model->links[l].geometries,
                      static_cast<int>(l),
                      false,
                      {}});
  for (const Attachment& a : problem.robot.attachments)
    bodies.push_back({a.object.name, &a.object.geometries, a.link, true, a.X_LO});
  for (const Object& o : problem.world.objects)
    bodies.push_back({o.name, &o.geometries, -1, false, o.X_WO});
  for (const DeformingObstacle& o : problem.world.deforming)
    bodies.push_back({o.object.name, &o.object.geometries, -1, false, o.object.X_WO});
  return bodies;
}

std::vector<BodyPair> collectPairs(const Problem& problem, const std::vector<Body>& bodies) {
  const Rules rules(problem);
  std::vector<BodyPair> pairs;
  // Bodies of the world come last; one of a pair is the robot's.
  for (std::size_t a = 0; a < bodies.size() && bodies[a].link >= 0; ++a)
    for (std::size_t b = a + 1; b < bodies.size(); ++b) {
      if (rules.mayTouch(bodies[a], bodies[b])) continue;
      BodyPair pair{a, b, rules.margin(bodies[a], bodies[b]),
                    jointsAbove(*problem.robot.model, bodies[a].link),
                    jointsAbove(*problem.robot.model, bodies[b].link)};
      while (!pair.joints_a.empty() && !pair.joints_b.empty() &&
             pair.joints_a.back() == pair.joints_b.back()) {
        pair.joints_a.pop_back();
        pair.joints_b.pop_back();
      }
      const auto moves = [&](int joint) { return rules.moves(joint); };
      if (std::any_of(pair.joints_a.begin(), pair.joints_a.end(), moves) ||
          std::any_of(pair.joints_b.begin(), pair.joints_b.end(), moves))
        pairs.push_back(std::move(pair));
    }
  return pairs;
}

}  // namespace leeway::planner::verification
