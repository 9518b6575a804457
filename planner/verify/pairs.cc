#include "planner/verify/pairs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/collision/distance.h"
#include "planner/base/tolerances.h"
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

template <typename Item>
bool contains(const std::vector<Item>& items, const Item& item) {
  return std::find(items.begin(), items.end(), item) != items.end();
}

/// Which pairs may touch, and the margins of the others.
class Rules {
 public:
  explicit Rules(const Problem& problem)
      : problem_(problem),
        model_(*problem.robot.model),
        derives_(!model_.has_srdf && !problem.contacts.replace_srdf),
        robot_is_word_(isWord("robot")),
        world_is_word_(isWord("world")) {}

  /// Returns why two bodies that move against each other are not checked; nothing if they are
  /// checked.
  std::optional<Unchecked> reason(const Body& a, const Body& b, const BodyPair& pair) {
    const bool link_a = a.link >= 0 && !a.attached, link_b = b.link >= 0 && !b.attached;
    const bool links = link_a && link_b;
    for (const auto& names : problem_.contacts.checked)
      if (links && same(names, a.name, b.name)) return std::nullopt;
    if (links && adjacent(a.link, b.link)) return Unchecked::kAdjacent;
    if (links)
      if (const robots::DisabledPair* entry = disabled(a.link, b.link))
        return entry->is_of_mjcf ? Unchecked::kMjcf : Unchecked::kSrdf;
    for (const auto& names : problem_.contacts.allowed)
      if (same(names, a.name, b.name)) return Unchecked::kAllowed;
    if ((a.attached && link_b && holds(a, b.link)) || (b.attached && link_a && holds(b, a.link)))
      return Unchecked::kAttached;
    if (!links && ((link_a && unchecked(a.link)) || (link_b && unchecked(b.link))))
      return Unchecked::kSrdf;
    if (links && derives_)
      if (const int joint = onlyJoint(pair); joint >= 0 && touch(a, b, joint))
        return Unchecked::kTouchSampled;
    return std::nullopt;
  }

  /// Whether a word stands for all bodies of its kind in margins. It does not if an object, or a
  /// link with shapes, has this word as its name.
  bool isWord(const std::string& word) const {
    const std::vector<Body> bodies = collectBodies(problem_);
    return std::none_of(bodies.begin(), bodies.end(), [&](const Body& body) {
      const bool is_link = body.link >= 0 && !body.attached;
      return body.name == word && (!is_link || body.hasShape());
    });
  }
  bool stands(const std::string& name, const Body& body) const {
    const bool is_of_robot = body.link >= 0;
    return name == body.name || (robot_is_word_ && name == "robot" && is_of_robot) ||
           (world_is_word_ && name == "world" && !is_of_robot);
  }

  double margin(const Body& a, const Body& b) const {
    double margin = problem_.margins.common;
    for (const PairMargin& m : problem_.margins.pairs)
      if ((stands(m.a, a) && stands(m.b, b)) || (stands(m.a, b) && stands(m.b, a)))
        margin = m.margin;
    // The objective length may keep a clearance from the world.
    const auto* length = std::get_if<MinimumLength>(&problem_.objective);
    const bool is_with_world = a.link < 0 || b.link < 0;
    return length != nullptr && is_with_world ? std::max(margin, length->clearance) : margin;
  }

  /// Whether the planner can change the joint's position.
  bool moves(int joint_index) const {
    const Joint* joint = &model_.joints[at(joint_index)];
    for (; joint->mimic >= 0; joint = &model_.joints[at(joint->mimic)])
      if (joint->multiplier == 0) return false;  // at rest at its offset
    for (int k = 0; k < joint->variable_count; ++k) {
      const int v = joint->first_variable + k;
      const robots::Variable& variable = model_.variables[at(v)];
      if (variable.lower < variable.upper && contains(problem_.robot.variables, v)) return true;
    }
    return false;
  }

 private:
  int parent(int link) const { return model_.joints[at(model_.links[at(link)].joint)].parent_link; }

  /// A joint between two links makes them touch.
  bool adjacent(int a, int b) const {
    return (parent(a) == b || parent(b) == a) &&
           !contains(model_.enabled_pairs, std::pair(std::min(a, b), std::max(a, b)));
  }

  const robots::DisabledPair* disabled(int a, int b) const {
    if (problem_.contacts.replace_srdf) return nullptr;
    for (const robots::DisabledPair& d : model_.disabled_pairs)
      if ((d.link_a == a && d.link_b == b) || (d.link_a == b && d.link_b == a)) return &d;
    return nullptr;
  }

  bool unchecked(int link) const {
    return !problem_.contacts.replace_srdf && contains(model_.unchecked_links, link);
  }

  bool holds(const Body& held, int link) const {
    for (const Attachment& attachment : problem_.robot.attachments)
      if (attachment.object.name == held.name && attachment.link == held.link)
        return link == held.link || contains(attachment.touch_links, link);
    return false;
  }

  /// The only joint of the pair that is not fixed; -1 if there is another number of them.
  int onlyJoint(const BodyPair& pair) const {
    int only = -1;
    for (const std::vector<int>* joints : {&pair.joints_a, &pair.joints_b})
      for (const int j : *joints) {
        if (model_.joints[at(j)].type == JointType::kFixed) continue;
        if (only >= 0) return -1;
        only = j;
      }
    return only;
  }

  /// A lower bound on the distance of two links with one joint at `position` and all others at zero
  /// [m].
  double gap(const Body& a, const Body& b, std::size_t variable, double position) {
    std::vector<double> q = model_.fileConfiguration();
    q[variable] = position;
    const std::vector<robots::Pose> X_WL = placeLinks(model_, q);
    collision::DistanceRequest request;
    request.depth = false;
    double gap = kInfinity;
    for (const robots::Geometry& g : *a.geometries)
      for (const robots::Geometry& h : *b.geometries)
        gap = std::min(gap, collision::distance(g.shape, X_WL[at(a.link)] * g.X_BG, h.shape,
                                                X_WL[at(b.link)] * h.X_BG, request, scratch_)
                                .distance.lower);
    return gap;
  }

  /// Whether two links touch with all joints at zero, and at every sampled position of the joint
  /// between them. A single position at which they are apart means that the pair is checked.
  bool touch(const Body& a, const Body& b, int joint) {
    if (a.geometries->empty() || b.geometries->empty()) return false;
    double ratio = 1;
    int moved = joint;
    while (model_.joints[at(moved)].mimic >= 0) {
      ratio *= model_.joints[at(moved)].multiplier;
      moved = model_.joints[at(moved)].mimic;
    }
    const JointType type = model_.joints[at(moved)].type;
    const auto v = at(model_.joints[at(moved)].first_variable);
    const double zero = model_.fileConfiguration()[v];
    if (gap(a, b, v, zero) > kVerifyTouch) return false;
    if (type == JointType::kPlanar || type == JointType::kFloating) return false;
    // Samples the file's limits even if the problem narrows them, but wider limits of the problem
    // count.
    const robots::Variable& limits = model_.variables[v];
    double begin = limits.lower, end = limits.upper;
    if (limits.file_limits) {
      begin = std::min(begin, limits.file_limits->first);
      end = std::max(end, limits.file_limits->second);
    }
    double length = end - begin;
    if (!std::isfinite(length)) {
      if (model_.joints[at(joint)].type == JointType::kPrismatic || ratio == 0) return false;
      begin = zero;
      length = 2 * std::numbers::pi / std::abs(ratio);
    }
    // One turn of a joint shows everything that further turns repeat, and even steps over many
    // turns could repeat the same few angles.
    if (model_.joints[at(joint)].type != JointType::kPrismatic)
      length = std::min(length, 2 * std::numbers::pi / std::abs(ratio));
    for (int k = kVerifyTouchLooks; k >= 0; --k)
      if (gap(a, b, v, begin + length * k / kVerifyTouchLooks) > kVerifyTouch) return false;
    return true;
  }

  const Problem& problem_;
  const Model& model_;
  bool derives_;                        // which links meet at joints
  bool robot_is_word_, world_is_word_;  // in margins
  collision::Scratch scratch_;
};

}  // namespace

std::vector<Body> collectBodies(const Problem& problem) {
  std::vector<Body> bodies;
  for (std::size_t l = 0; l < problem.robot.model->links.size(); ++l)
    bodies.push_back({problem.robot.model->links[l].name,
                      &problem.robot.model->links[l].geometries,
                      nullptr,
                      static_cast<int>(l),
                      false,
                      {}});
  for (const Attachment& a : problem.robot.attachments)
    bodies.push_back(
        {a.object.name, &a.object.geometries, a.object.cloud.get(), a.link, true, a.X_LO});
  for (const Object& o : problem.world.objects)
    bodies.push_back({o.name, &o.geometries, o.cloud.get(), -1, false, o.X_WO});
  for (const DeformingObstacle& o : problem.world.deforming)
    bodies.push_back(
        {o.object.name, &o.object.geometries, o.object.cloud.get(), -1, false, o.object.X_WO});
  return bodies;
}

Pairs collectPairs(const Problem& problem, const std::vector<Body>& bodies) {
  Rules rules(problem);
  Pairs pairs;
  const auto moves = [&](int joint) { return rules.moves(joint); };
  bool can_move = false, is_checked = false, has_world = false;  // something with a shape
  // Bodies of the world come last, and one body of each pair belongs to the robot.
  for (std::size_t a = 0; a < bodies.size() && bodies[a].link >= 0; ++a) {
    const std::vector<int> above = jointsAbove(*problem.robot.model, bodies[a].link);
    can_move = can_move || (bodies[a].hasShape() && std::any_of(above.begin(), above.end(), moves));
    for (std::size_t b = a + 1; b < bodies.size(); ++b) {
      BodyPair pair{a, b, rules.margin(bodies[a], bodies[b]), above,
                    jointsAbove(*problem.robot.model, bodies[b].link)};
      while (!pair.joints_a.empty() && !pair.joints_b.empty() &&
             pair.joints_a.back() == pair.joints_b.back()) {
        pair.joints_a.pop_back();
        pair.joints_b.pop_back();
      }
      std::optional<Unchecked> why;
      if (std::none_of(pair.joints_a.begin(), pair.joints_a.end(), moves) &&
          std::none_of(pair.joints_b.begin(), pair.joints_b.end(), moves))
        why = Unchecked::kRigid;
      else
        why = rules.reason(bodies[a], bodies[b], pair);
      const bool has_shapes = bodies[a].hasShape() && bodies[b].hasShape();
      if (!why) {
        is_checked = is_checked || has_shapes;
        pairs.checked.push_back(std::move(pair));
      } else if (has_shapes && (*why != Unchecked::kRigid || bodies[b].link >= 0)) {
        pairs.unchecked.push_back({bodies[a].name, bodies[b].name, *why});
      }
    }
  }
  for (const auto& body : bodies) has_world = has_world || (body.link < 0 && body.hasShape());
  if (!can_move)
    pairs.nothing_checked = kNothingMoves;
  else if (!is_checked && has_world)
    pairs.nothing_checked =
        "no pair with the world is checked; " + toString(countUnchecked(pairs.unchecked));
  return pairs;
}

}  // namespace leeway::planner::verification
