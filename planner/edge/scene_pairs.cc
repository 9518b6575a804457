#include "planner/edge/scene_pairs.h"

#include <fmt/format.h>

#include <algorithm>

#include "collision/base/tolerances.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"

namespace leeway::planner {
namespace {

using collision::Body;
using robots::LinkGap;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Neither order of a pair matters.
template <typename T>
bool isPair(const T& x, const T& y, const T& a, const T& b) {
  return (x == a && y == b) || (x == b && y == a);
}

bool mayTouch(const Attachment& held, int link) {
  return link == held.link || std::find(held.touch_links.begin(), held.touch_links.end(), link) !=
                                  held.touch_links.end();
}

}  // namespace

ScenePairs::ScenePairs(const Problem& problem, std::span<const robots::VariableRange> ranges)
    : problem_(problem),
      model_(*problem.robot.model),
      ranges_(ranges),
      poses_(model_.links.size()) {
  robots::forwardKinematics(model_, problem.start, poses_);
  addLinks();
  addAttachments();
  carried_ = count();
  addObjects();
  findAllowed();
  // Of the world, what the problem allows: that it stands still needs no reason, and there may be
  // many of it.
  for (int i = 0; i < carried_; ++i) {
    for (int j = i + 1; j < carried_; ++j) drop(i, j, reason(i, j));
    for (auto p = allowed_.lower_bound({i, carried_}); p != allowed_.end() && p->first == i; ++p)
      drop(i, p->second, reason(i, p->second));
  }
  if (!model_.has_srdf && !problem_.contacts.replace_srdf) dropProven();
}

collision::SceneBuilder ScenePairs::builder() const {
  collision::SceneBuilder builder;
  for (const Entry& e : entries_) builder.add(e.body);
  for (const auto& [pair, why] : reasons_) builder.allow(pair.first, pair.second);
  builder.setDefaultMargin(problem_.margins.common);
  for (const PairMargin& m : problem_.margins.pairs)
    for (const int i : named(m.a))
      for (const int j : named(m.b)) builder.setMargin(i, j, m.margin);
  return builder;
}

std::vector<int> ScenePairs::bodyLinks() const {
  std::vector<int> links;
  for (const Entry& e : entries_) links.push_back(e.body.moving ? e.link : -1);
  return links;
}

const LinkGap* ScenePairs::linkGap(int i, int j) const {
  const Entry &a = entries_[at(i)], &b = entries_[at(j)];
  if (!a.isLink() || !b.isLink()) return nullptr;
  const auto gap =
      std::find_if(model_.link_gaps.begin(), model_.link_gaps.end(),
                   [&](const LinkGap& g) { return isPair(g.link_a, g.link_b, a.link, b.link); });
  return gap == model_.link_gaps.end() ? nullptr : &*gap;
}

// Bodies.

void ScenePairs::add(Entry entry) {
  named_[entry.body.name].push_back(count());
  entries_.push_back(std::move(entry));
}

void ScenePairs::addLinks() {
  for (std::size_t l = 0; l < model_.links.size(); ++l) {
    const robots::Link& link = model_.links[l];
    if (link.geometries.empty()) continue;
    add({{link.name, link.geometries, moves(static_cast<int>(l)), poses_[l]},
         static_cast<int>(l),
         nullptr});
  }
}

void ScenePairs::addAttachments() {
  for (const Attachment& a : problem_.robot.attachments) {
    expectPose(a.X_LO, a.object.name);
    Body body{a.object.name, a.object.geometries, moves(a.link), poses_[at(a.link)]};
    for (robots::Geometry& g : body.geometries) g.X_BG = a.X_LO * g.X_BG;
    if (!body.geometries.empty()) add({std::move(body), a.link, &a});
  }
}

void ScenePairs::addObject(const Object& object) {
  expectPose(object.X_WO, object.name);
  if (!object.geometries.empty())
    add({{object.name, object.geometries, false, object.X_WO}, -1, nullptr});
}

void ScenePairs::addObjects() {
  for (const Object& o : problem_.world.objects) addObject(o);
  for (const DeformingObstacle& o : problem_.world.deforming) {
    expectSnapshot(o);
    addObject(o.object);
  }
}

/// Queries find a deforming obstacle by its name, and see it as it is when execution starts.
void ScenePairs::expectSnapshot(const DeformingObstacle& obstacle) const {
  const std::string& name = obstacle.object.name;
  const auto refuse = [&](const std::string& message) {
    throw robots::InputError(problem_.name, 0,
                             fmt::format("deforming obstacle '{}' {}", name, message));
  };
  const collision::DeformableSnapshot* snapshot =
      obstacle.mesh && obstacle.object.geometries.size() == 1
          ? obstacle.object.geometries[0].shape.deformable()
          : nullptr;
  if (snapshot == nullptr) refuse("has no snapshot; see makeDeformingObstacle()");
  if (snapshot->time() != problem_.execution.start)
    refuse(fmt::format("is as it is at {} s; execution starts at {} s", snapshot->time(),
                       problem_.execution.start));
  if (!named(name).empty())
    refuse("has the name of another object or link; a name of its own is expected");
}

/// Readers of files see to it; programs may pass anything.
void ScenePairs::expectPose(const robots::Pose& X, const std::string& name) const {
  const double departure =
      (X.rotation.transpose() * X.rotation - Eigen::Matrix3d::Identity()).norm();
  if ((X.translation.array().abs() <= collision::kLargestSize).all() &&
      departure <= collision::kRotationTolerance)
    return;
  const Eigen::Vector3d& p = X.translation;
  throw robots::InputError(
      problem_.name, 0,
      fmt::format("the pose of '{}' is at ({}, {}, {}), its rotation {} from orthogonal; numbers "
                  "up to {} and a rotation within {} are expected",
                  name, p.x(), p.y(), p.z(), departure, collision::kLargestSize,
                  collision::kRotationTolerance));
}

// Reasons to drop a pair.

void ScenePairs::findAllowed() {
  for (const auto& [x, y] : problem_.contacts.allowed)
    for (const int i : named(x))
      for (const int j : named(y))
        if (i != j) allowed_.emplace(std::min(i, j), std::max(i, j));
}

/// Empty: the pair is checked.
std::string ScenePairs::reason(int i, int j) const {
  const Entry &a = entries_[at(i)], &b = entries_[at(j)];
  if (a.isLink() && b.isLink()) {
    if (areAdjacent(a.link, b.link)) return "adjacent";
    if (!problem_.contacts.replace_srdf)
      for (const robots::DisabledPair& d : model_.disabled_pairs)
        if (isPair(d.link_a, d.link_b, a.link, b.link))
          return "disabled by the SRDF" + (d.reason.empty() ? "" : ": " + d.reason);
  }
  if (allowed_.count({i, j}) != 0) return "allowed by the problem";
  if (a.held != nullptr && b.isLink() && mayTouch(*a.held, b.link)) return "attached";
  if (b.held != nullptr && a.isLink() && mayTouch(*b.held, a.link)) return "attached";
  if (!a.body.moving && !b.body.moving) return "neither moves";
  if (a.link >= 0 && b.link >= 0 && areRigid(a, b)) return "rigidly attached to each other";
  return {};
}

void ScenePairs::drop(int i, int j, const std::string& why) {
  if (why.empty()) return;
  reasons_[{i, j}] = why;
  const bool carried_i = entries_[at(i)].link >= 0, carried_j = entries_[at(j)].link >= 0;
  // That things of the world stand beside each other, or beside a robot's base, is no news.
  if ((carried_i && carried_j) || ((carried_i || carried_j) && why != "neither moves"))
    dropped_.push_back({name(i), name(j), why});
}

void ScenePairs::dropProven() {
  if (!isPassiveWithinLimits()) return;
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
      has_proven_ = true;
      drop(bodies[k].first, bodies[k].second, "proven never to meet");
    }
}

/// The proof is that two links never touch; it says nothing of a margin.
bool ScenePairs::hasMargin(int i, int j) const {
  bool positive = problem_.margins.common > 0;
  for (const PairMargin& m : problem_.margins.pairs)
    if (areNamed(i, j, m.a, m.b)) positive = m.margin > 0;
  return positive;
}

/// The proof holds within the limits, and a joint that is not planned may stand outside them.
bool ScenePairs::isPassiveWithinLimits() const {
  for (std::size_t v = 0; v < model_.variables.size(); ++v) {
    const robots::Variable& variable = model_.variables[v];
    if (ranges_[v].lower != ranges_[v].upper) continue;
    if (problem_.start[v] < variable.lower || problem_.start[v] > variable.upper) return false;
  }
  return true;
}

const std::string& ScenePairs::name(int i) const { return entries_[at(i)].body.name; }

std::span<const int> ScenePairs::named(const std::string& name) const {
  const auto found = named_.find(name);
  return found == named_.end() ? std::span<const int>() : found->second;
}

bool ScenePairs::areNamed(int i, int j, const std::string& a, const std::string& b) const {
  return isPair(a, b, name(i), name(j));
}

bool ScenePairs::moves(int link) const {
  return !robots::relativeMotion(model_, link, -1, Eigen::Vector3d::Zero(), 0, ranges_)
              .terms.empty();
}

bool ScenePairs::areRigid(const Entry& a, const Entry& b) const {
  return robots::relativeMotion(model_, a.link, b.link, Eigen::Vector3d::Zero(), 0, ranges_)
      .terms.empty();
}

int ScenePairs::parentOf(int link) const {
  return model_.joints[at(model_.links[at(link)].joint)].parent_link;
}

/// The first link of the rigid group that `link` belongs to: up from it through fixed joints.
int ScenePairs::rigidRoot(int link) const {
  while (model_.joints[at(model_.links[at(link)].joint)].type == robots::JointType::kFixed) {
    const int parent = parentOf(link);
    if (parent < 0) break;
    link = parent;
  }
  return link;
}

/// Parent and child; without an SRDF also what fixed joints join to them.
bool ScenePairs::areAdjacent(int a, int b) const {
  if (parentOf(a) == b || parentOf(b) == a) return true;
  if (model_.has_srdf || problem_.contacts.replace_srdf) return false;
  const int x = rigidRoot(a), y = rigidRoot(b);
  const int above_x = parentOf(x), above_y = parentOf(y);
  return x == y || (above_x >= 0 && rigidRoot(above_x) == y) ||
         (above_y >= 0 && rigidRoot(above_y) == x);
}

}  // namespace leeway::planner
