#include "leeway/planner/compiled_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using collision::Body;
using collision::Pose;
using collision::SceneAccess;
using robots::Joint;
using robots::Model;
using robots::VariableRange;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Limits for what is planned, the start's value for what is not.
std::vector<VariableRange> plannedRanges(const Problem& problem) {
  std::vector<VariableRange> ranges = robots::limitRanges(*problem.model);
  std::vector<char> planned(ranges.size(), 0);
  for (const int v : problem.variables) planned[at(v)] = 1;
  for (std::size_t v = 0; v < ranges.size(); ++v)
    if (!planned[v]) ranges[v] = {problem.configuration[v], problem.configuration[v]};
  return ranges;
}

/// Why pairs of bodies are left out; the first reason found stands.
class Pairs {
 public:
  Pairs(const Problem& problem, std::span<const VariableRange> ranges)
      : problem_(problem), model_(*problem.model), ranges_(ranges), poses_(model_.links.size()) {
    robots::forwardKinematics(model_, problem.configuration, poses_);
    addLinks();
    addAttachments();
    addObjects();
  }

  void decide(std::vector<CompiledScene::Dropped>& dropped) {
    for (int i = 0; i < count(); ++i)
      for (int j = i + 1; j < count(); ++j) drop(i, j, reason(i, j), dropped);
    if (!model_.has_srdf && !problem_.replace_srdf_pairs) dropProven(dropped);
  }

  collision::SceneBuilder builder() const {
    collision::SceneBuilder builder;
    for (const Entry& e : entries_) builder.add(e.body);
    for (const auto& [pair, why] : reasons_) builder.allow(pair.first, pair.second);
    builder.setDefaultMargin(problem_.margin);
    for (const Problem::PairMargin& m : problem_.margins)
      for (int i = 0; i < count(); ++i)
        for (int j = 0; j < count(); ++j)
          if (name(i) == m.a && name(j) == m.b) builder.setMargin(i, j, m.margin);
    return builder;
  }

  bool hasProven() const { return proven_; }

  /// Of two bodies that are links, what is proven of them.
  const robots::LinkGap* linkGap(int i, int j) const {
    if (!entries_[at(i)].isLink() || !entries_[at(j)].isLink()) return nullptr;
    const int a = entries_[at(i)].link, b = entries_[at(j)].link;
    for (const robots::LinkGap& gap : model_.link_gaps)
      if ((gap.link_a == a && gap.link_b == b) || (gap.link_a == b && gap.link_b == a)) return &gap;
    return nullptr;
  }

  std::vector<int> bodyLinks() const {
    std::vector<int> links;
    for (const Entry& e : entries_) links.push_back(e.body.moving ? e.link : -1);
    return links;
  }

 private:
  struct Entry {
    Body body;
    int link;                // that carries it; -1: the world
    const Attachment* held;  // null for links and objects
    bool isLink() const { return link >= 0 && held == nullptr; }
  };

  int count() const { return static_cast<int>(entries_.size()); }
  const std::string& name(int i) const { return entries_[at(i)].body.name; }

  bool moves(int link) const {
    return !robots::relativeMotion(model_, link, -1, Eigen::Vector3d::Zero(), 0, ranges_)
                .terms.empty();
  }

  void addLinks() {
    for (std::size_t l = 0; l < model_.links.size(); ++l) {
      const robots::Link& link = model_.links[l];
      if (link.geometries.empty()) continue;
      entries_.push_back({{link.name, link.geometries, moves(static_cast<int>(l)), poses_[l]},
                          static_cast<int>(l),
                          nullptr});
    }
  }

  void addAttachments() {
    for (const Attachment& a : problem_.attachments) {
      expectPose(a.X_LO, a.object.name);
      Body body{a.object.name, a.object.geometries, moves(a.link), poses_[at(a.link)]};
      for (robots::Geometry& g : body.geometries) g.X_BG = a.X_LO * g.X_BG;
      if (!body.geometries.empty()) entries_.push_back({std::move(body), a.link, &a});
    }
  }

  void addObjects() {
    for (const Object& o : problem_.objects) {
      expectPose(o.X_WO, o.name);
      if (!o.geometries.empty())
        entries_.push_back({{o.name, o.geometries, false, o.X_WO}, -1, nullptr});
    }
  }

  /// Files are read so that this holds; programs may say anything.
  void expectPose(const robots::Pose& X, const std::string& name) const {
    const double departure =
        (X.rotation.transpose() * X.rotation - Eigen::Matrix3d::Identity()).norm();
    if (X.translation.allFinite() && departure <= collision::kRotationTolerance) return;
    const Eigen::Vector3d& p = X.translation;
    throw robots::InputError(
        problem_.name, 0,
        fmt::format("the pose of '{}' is at ({}, {}, {}), its rotation {} from orthogonal; finite "
                    "numbers and a rotation within {} are expected",
                    name, p.x(), p.y(), p.z(), departure, collision::kRotationTolerance));
  }

  /// The nearest link above that a joint which is not fixed stands between, with the link's own.
  int rigidRoot(int link) const {
    while (model_.joints[at(model_.links[at(link)].joint)].type == robots::JointType::kFixed) {
      const int parent = model_.joints[at(model_.links[at(link)].joint)].parent_link;
      if (parent < 0) break;
      link = parent;
    }
    return link;
  }
  int parentOf(int link) const {
    return model_.joints[at(model_.links[at(link)].joint)].parent_link;
  }

  bool adjacent(int a, int b) const {
    if (parentOf(a) == b || parentOf(b) == a) return true;
    if (model_.has_srdf || problem_.replace_srdf_pairs) return false;
    const int x = rigidRoot(a), y = rigidRoot(b);
    const int above_x = parentOf(x), above_y = parentOf(y);
    return x == y || (above_x >= 0 && rigidRoot(above_x) == y) ||
           (above_y >= 0 && rigidRoot(above_y) == x);
  }

  static bool mayTouch(const Attachment& held, int link) {
    return link == held.link || std::find(held.touch_links.begin(), held.touch_links.end(), link) !=
                                    held.touch_links.end();
  }

  bool rigid(const Entry& a, const Entry& b) const {
    return robots::relativeMotion(model_, a.link, b.link, Eigen::Vector3d::Zero(), 0, ranges_)
        .terms.empty();
  }

  /// Empty: the pair stays.
  std::string reason(int i, int j) const {
    const Entry &a = entries_[at(i)], &b = entries_[at(j)];
    if (a.isLink() && b.isLink()) {
      if (adjacent(a.link, b.link)) return "adjacent";
      if (!problem_.replace_srdf_pairs)
        for (const robots::DisabledPair& d : model_.disabled_pairs)
          if ((d.link_a == a.link && d.link_b == b.link) ||
              (d.link_a == b.link && d.link_b == a.link))
            return "disabled by the SRDF" + (d.reason.empty() ? "" : ": " + d.reason);
    }
    for (const auto& [x, y] : problem_.allowed)
      if ((x == name(i) && y == name(j)) || (x == name(j) && y == name(i)))
        return "allowed by the problem";
    if (a.held != nullptr && b.isLink() && mayTouch(*a.held, b.link)) return "attached";
    if (b.held != nullptr && a.isLink() && mayTouch(*b.held, a.link)) return "attached";
    if (!a.body.moving && !b.body.moving) return "neither moves";
    if (a.link >= 0 && b.link >= 0 && rigid(a, b)) return "rigidly attached to each other";
    return {};
  }

  void drop(int i, int j, const std::string& why, std::vector<CompiledScene::Dropped>& dropped) {
    if (why.empty()) return;
    reasons_[{i, j}] = why;
    // Things of the world that stand beside each other are no news.
    if (entries_[at(i)].link >= 0 || entries_[at(j)].link >= 0)
      if (why != "neither moves" || (entries_[at(i)].link >= 0 && entries_[at(j)].link >= 0))
        dropped.push_back({name(i), name(j), why});
  }

  /// The proof is of not touching, no more.
  bool hasMargin(int i, int j) const {
    bool positive = problem_.margin > 0;
    for (const Problem::PairMargin& m : problem_.margins)
      if ((m.a == name(i) && m.b == name(j)) || (m.a == name(j) && m.b == name(i)))
        positive = m.margin > 0;
    return positive;
  }

  /// The proof holds within the limits, and a passive joint may stand outside them.
  bool passiveWithinLimits() const {
    for (std::size_t v = 0; v < model_.variables.size(); ++v) {
      const robots::Variable& variable = model_.variables[v];
      if (ranges_[v].lower != ranges_[v].upper) continue;
      if (problem_.configuration[v] < variable.lower || problem_.configuration[v] > variable.upper)
        return false;
    }
    return true;
  }

  void dropProven(std::vector<CompiledScene::Dropped>& dropped) {
    if (!passiveWithinLimits()) return;
    std::vector<std::pair<int, int>> candidates, bodies;
    for (int i = 0; i < count(); ++i)
      for (int j = i + 1; j < count(); ++j)
        if (entries_[at(i)].isLink() && entries_[at(j)].isLink() && reasons_.count({i, j}) == 0 &&
            !hasMargin(i, j)) {
          candidates.emplace_back(entries_[at(i)].link, entries_[at(j)].link);
          bodies.emplace_back(i, j);
        }
    const std::vector<std::pair<int, int>> proven = robots::provenApart(model_, candidates);
    for (std::size_t k = 0; k < candidates.size(); ++k)
      if (std::find(proven.begin(), proven.end(), candidates[k]) != proven.end()) {
        proven_ = true;
        drop(bodies[k].first, bodies[k].second, "proven never to meet", dropped);
      }
  }

  const Problem& problem_;
  const Model& model_;
  std::span<const VariableRange> ranges_;
  std::vector<Pose> poses_;
  std::vector<Entry> entries_;
  std::map<std::pair<int, int>, std::string> reasons_;
  bool proven_ = false;
};

/// Places in a point of the circles that some mimic joint follows with a factor that is no whole
/// number.
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

}  // namespace

CompiledScene::CompiledScene(const Problem& problem)
    : model_(problem.model),
      space_(std::make_shared<ConfigurationSpace>(problem.model, problem.variables)),
      base_configuration_(problem.configuration) {
  const std::vector<VariableRange> ranges = plannedRanges(problem);
  Pairs pairs(problem, ranges);
  pairs.decide(dropped_);
  try {
    scene_ = pairs.builder().build();
  } catch (const std::invalid_argument& error) {
    throw robots::InputError(problem.name, 0, error.what());
  }
  body_link_ = pairs.bodyLinks();
  for (const collision::ScenePair& pair : scene_.pairs())
    link_gaps_.push_back(pairs.linkGap(pair.body_a, pair.body_b));
  needs_limits_ = pairs.hasProven();
  jumping_circles_ = jumpingCircles(*space_);
  deriveMotions(problem, ranges);
}

void CompiledScene::deriveMotions(const Problem& problem, std::span<const VariableRange> ranges) {
  // What deforms is nowhere for good: its motion seen from a link cannot be bounded once for all.
  const auto deforms = [&](int body) {
    const std::string& name = scene_.bodies()[at(body)].name;
    return std::any_of(problem.deforming.begin(), problem.deforming.end(),
                       [&](const DeformingObstacle& o) { return o.object == name; });
  };
  double farthest = 0;
  std::size_t longest = 0;
  for (std::size_t b = 0; b < scene_.bodies().size(); ++b)
    for (std::size_t g = 0; body_link_[b] >= 0 && g < scene_.bodies()[b].geometries.size(); ++g) {
      const collision::Ball& ball =
          SceneAccess::bounds(
              scene_, SceneAccess::geometryIndex(scene_, static_cast<int>(b), static_cast<int>(g)))
              .outer;
      const robots::RelativeMotion motion =
          robots::relativeMotion(*model_, body_link_[b], -1, ball.center, ball.radius, ranges);
      farthest = std::max(farthest, motion.base_reach);
      longest = std::max(longest, motion.terms.size());
    }
  const std::vector<robots::JointMotion> unit(model_->joints.size(), {1, 1});
  std::map<std::pair<int, int>, int> known;  // geometry and base: index into motions_
  const auto derived = [&](int geometry, int link, int base) {
    const auto [entry, is_new] =
        known.emplace(std::pair(geometry, base), static_cast<int>(motions_.size()));
    const collision::Ball& ball = SceneAccess::bounds(scene_, geometry).outer;
    if (is_new)
      motions_.push_back(
          robots::relativeMotion(*model_, link, base, ball.center, ball.radius, ranges));
    return entry->second;
  };
  for (const collision::ScenePair& pair : scene_.pairs()) {
    const int a = SceneAccess::geometryIndex(scene_, pair.body_a, pair.geometry_a);
    const int b = SceneAccess::geometryIndex(scene_, pair.body_b, pair.geometry_b);
    const int link_a = bodyLink(pair.body_a), link_b = bodyLink(pair.body_b);
    int motion = derived(a, link_a, link_b);
    bool reversed = false;
    // What is near the joints between the two moves least; as a rule that is not the thing of the
    // world.
    if (std::isfinite(SceneAccess::bounds(scene_, b).outer.radius) && !deforms(pair.body_b)) {
      const int other = derived(b, link_b, link_a);
      reversed = robots::accelerationBound(*model_, motions_[at(other)], unit) <
                 robots::accelerationBound(*model_, motions_[at(motion)], unit);
      if (reversed) motion = other;
    }
    pair_motion_.push_back(motion);
    reversed_.push_back(reversed ? 1 : 0);
  }
  keepAskedMotions();
  reach_ = farthest <= kLargestReach / 2 ? 2 * farthest : kLargestReach;
  rounding_ = robots::kinematicsRounding(*model_, reach_) +
              static_cast<double>(longest) * reach_ * kInterpolationRounding;
}

/// Of most pairs only one side's motion is asked for.
void CompiledScene::keepAskedMotions() {
  std::vector<int> number(motions_.size(), -1);
  std::vector<robots::RelativeMotion> asked;
  for (int& motion : pair_motion_) {
    int& kept = number[at(motion)];
    if (kept < 0) {
      kept = static_cast<int>(asked.size());
      asked.push_back(std::move(motions_[at(motion)]));
    }
    motion = kept;
  }
  motions_ = std::move(asked);
}

std::shared_ptr<const CompiledScene> CompiledScene::withShapes(
    std::span<const Replacement> shapes) const {
  auto changed = std::make_shared<CompiledScene>(*this);
  for (const Replacement& r : shapes) {
    changed->scene_.setShape(r.body, r.geometry, r.shape);
    changed->scene_.growMargins(r.body, r.geometry, r.growth);
  }
  return changed;
}

std::shared_ptr<const CompiledScene> CompiledScene::withMarginsGrown(double growth) const {
  auto grown = std::make_shared<CompiledScene>(*this);
  for (std::size_t body = 0; body < scene_.bodies().size(); ++body)
    if (scene_.bodies()[body].moving)  // one of every pair is
      for (std::size_t g = 0; g < scene_.bodies()[body].geometries.size(); ++g)
        grown->scene_.growMargins(static_cast<int>(body), static_cast<int>(g), growth);
  return grown;
}

std::shared_ptr<const CompiledScene> CompiledScene::withPairs(
    const std::function<bool(const collision::ScenePair&)>& keep) const {
  auto reduced = std::make_shared<CompiledScene>(*this);
  // Each pair is asked once: of another answer the second time pairs would come to other pairs'
  // motions, and what these prove would not hold.
  std::vector<char> kept;
  kept.reserve(scene_.pairs().size());
  for (const collision::ScenePair& pair : scene_.pairs()) kept.push_back(keep(pair) ? 1 : 0);
  std::size_t next = 0;
  SceneAccess::keepPairs(reduced->scene_,
                         [&](const collision::ScenePair&) { return kept[next++] != 0; });
  reduced->pair_motion_.clear();
  reduced->reversed_.clear();
  reduced->link_gaps_.clear();
  for (std::size_t p = 0; p < kept.size(); ++p) {
    if (kept[p] == 0) continue;
    reduced->pair_motion_.push_back(pair_motion_[p]);
    reduced->reversed_.push_back(reversed_[p]);
    reduced->link_gaps_.push_back(link_gaps_[p]);
  }
  return reduced;
}

void CompiledScene::expand(std::span<const double> point, std::span<double> q) const {
  std::copy(base_configuration_.begin(), base_configuration_.end(), q.begin());
  const std::span<const int> variables = space_->variables();
  for (std::size_t i = 0; i < variables.size(); ++i) q[at(variables[i])] = point[i];
}

void CompiledScene::expandDifference(std::span<const double> difference,
                                     std::span<double> dq) const {
  std::fill(dq.begin(), dq.end(), 0.0);
  const std::span<const int> variables = space_->variables();
  for (std::size_t i = 0; i < variables.size(); ++i) dq[at(variables[i])] = difference[i];
}

bool CompiledScene::isSmooth(std::span<const double> a, std::span<const double> b,
                             std::span<const double> difference) const {
  // Inside an edge circles are wrapped: ends that are not would be whole turns from their
  // neighbours.
  const auto wrapped = [](double x) { return x >= -std::numbers::pi && x < std::numbers::pi; };
  for (const int i : jumping_circles_)
    if (!wrapped(a[at(i)]) || !wrapped(b[at(i)]) ||
        !(std::abs(a[at(i)] + difference[at(i)] - b[at(i)]) < 1))
      return false;  // else a whole turn apart
  return true;
}

}  // namespace leeway::planner
