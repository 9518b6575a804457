#include "planner/edge/robot_pairs.h"

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/robots/kinematics.h"

namespace leeway::planner {
namespace {

using collision::Body;
using robots::LinkGap;

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

RobotPairs::RobotPairs(const Problem& problem, std::span<const robots::VariableRange> ranges,
                       const robots::Stop& stop)
    : problem_(problem),
      model_(*problem.robot.model),
      ranges_(ranges),
      poses_(model_.links.size()) {
  // Links that nothing moves stand where the ranges say, which are what a prepared robot is known
  // by. A planned joint may be locked by its limits, and a start that is refused later lie outside
  // them.
  std::vector<double> fixed = problem.start;
  for (std::size_t v = 0; v < ranges.size(); ++v)
    if (ranges[v].lower == ranges[v].upper) fixed[v] = ranges[v].lower;
  robots::forwardKinematics(model_, fixed, poses_);
  addLinks();
  addAttachments();
  findAllowed();
  for (int i = 0; i < count(); ++i) {
    for (int j = i + 1; j < count(); ++j) drop(i, j, reason(i, j));
    dropped_ends_.push_back(dropped_.size());
  }
  if (!model_.has_srdf && !problem_.contacts.replace_srdf) dropProven(stop);
}

collision::SceneBuilder RobotPairs::builder() const {
  collision::SceneBuilder builder;
  // Worlds are added to these pairs, and edges know them by their order: all are listed.
  builder.listAtMost(std::numeric_limits<std::size_t>::max());
  for (const Entry& e : entries_) builder.add(e.body);
  for (const auto& [pair, why] : reasons_) builder.allow(pair.first, pair.second);
  return builder;
}

std::vector<int> RobotPairs::carriers() const {
  std::vector<int> links;
  for (const Entry& e : entries_) links.push_back(e.link);
  return links;
}

const LinkGap* RobotPairs::linkGap(int i, int j) const {
  const Entry &a = entries_[at(i)], &b = entries_[at(j)];
  if (!a.isLink() || !b.isLink()) return nullptr;
  const auto gap =
      std::find_if(model_.link_gaps.begin(), model_.link_gaps.end(),
                   [&](const LinkGap& g) { return isPair(g.link_a, g.link_b, a.link, b.link); });
  return gap == model_.link_gaps.end() ? nullptr : &*gap;
}

// Bodies.

void RobotPairs::add(Entry entry) {
  named_[entry.body.name].push_back(count());
  entries_.push_back(std::move(entry));
}

void RobotPairs::addLinks() {
  for (std::size_t l = 0; l < model_.links.size(); ++l) {
    const robots::Link& link = model_.links[l];
    if (link.geometries.empty()) continue;
    add({{link.name, link.geometries, moves(static_cast<int>(l)), poses_[l]},
         static_cast<int>(l),
         nullptr});
  }
}

void RobotPairs::addAttachments() {
  for (const Attachment& a : problem_.robot.attachments) {
    Body body{a.object.name, a.object.geometries, moves(a.link), poses_[at(a.link)]};
    for (robots::Geometry& g : body.geometries) g.X_BG = a.X_LO * g.X_BG;
    if (!body.geometries.empty()) add({std::move(body), a.link, &a});
  }
}

// Reasons to drop a pair.

void RobotPairs::findAllowed() {
  for (const auto& [x, y] : problem_.contacts.allowed)
    for (const int i : named(x))
      for (const int j : named(y))
        if (i != j) allowed_.emplace(std::min(i, j), std::max(i, j));
}

/// Empty: the pair is checked.
std::string RobotPairs::reason(int i, int j) const {
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
  if (areRigid(a, b)) return "rigidly attached to each other";
  return {};
}

void RobotPairs::drop(int i, int j, const std::string& why) {
  if (why.empty()) return;
  reasons_[{i, j}] = why;
  dropped_.push_back({name(i), name(j), why});
}

void RobotPairs::dropProven(const robots::Stop& stop) {
  if (!isPassiveWithinLimits()) return;
  std::vector<std::pair<int, int>> candidates, bodies;
  for (int i = 0; i < count(); ++i)
    for (int j = i + 1; j < count(); ++j)
      if (entries_[at(i)].isLink() && entries_[at(j)].isLink() && reasons_.count({i, j}) == 0 &&
          !hasMargin(i, j)) {
        candidates.emplace_back(entries_[at(i)].link, entries_[at(j)].link);
        bodies.emplace_back(i, j);
      }
  const std::vector<std::pair<int, int>> proven = robots::provenApart(model_, candidates, stop);
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (std::find(proven.begin(), proven.end(), candidates[k]) != proven.end()) {
      has_proven_ = true;
      drop(bodies[k].first, bodies[k].second, "proven never to meet");
    }
}

/// The proof is that two links never touch; it says nothing of a margin or a wish.
bool RobotPairs::hasMargin(int i, int j) const {
  bool positive = problem_.margins.common > 0;
  for (const PairMargin& m : problem_.margins.pairs)
    if (areNamed(i, j, m.a, m.b)) positive = m.margin > 0;
  for (const Wish& wish : problem_.margins.wishes)
    for (const auto& [a, b] : wish.pairs) positive = positive || areNamed(i, j, a, b);
  return positive;
}

/// The proof holds within the limits, and a joint that is not planned may stand outside them.
bool RobotPairs::isPassiveWithinLimits() const {
  for (std::size_t v = 0; v < model_.variables.size(); ++v) {
    const robots::Variable& variable = model_.variables[v];
    if (ranges_[v].lower != ranges_[v].upper) continue;
    if (ranges_[v].lower < variable.lower || ranges_[v].lower > variable.upper) return false;
  }
  return true;
}

const std::string& RobotPairs::name(int i) const { return entries_[at(i)].body.name; }

std::span<const int> RobotPairs::named(const std::string& name) const {
  const auto found = named_.find(name);
  return found == named_.end() ? std::span<const int>() : found->second;
}

bool RobotPairs::areNamed(int i, int j, const std::string& a, const std::string& b) const {
  return isPair(a, b, name(i), name(j));
}

bool RobotPairs::moves(int link) const {
  return !robots::relativeMotion(model_, link, -1, Eigen::Vector3d::Zero(), 0, ranges_)
              .terms.empty();
}

bool RobotPairs::areRigid(const Entry& a, const Entry& b) const {
  return robots::relativeMotion(model_, a.link, b.link, Eigen::Vector3d::Zero(), 0, ranges_)
      .terms.empty();
}

int RobotPairs::parentOf(int link) const {
  return model_.joints[at(model_.links[at(link)].joint)].parent_link;
}

/// The first link of the rigid group that `link` belongs to: up from it through fixed joints.
int RobotPairs::rigidRoot(int link) const {
  while (model_.joints[at(model_.links[at(link)].joint)].type == robots::JointType::kFixed) {
    const int parent = parentOf(link);
    if (parent < 0) break;
    link = parent;
  }
  return link;
}

/// Parent and child; without an SRDF also what fixed joints join to them.
bool RobotPairs::areAdjacent(int a, int b) const {
  if (parentOf(a) == b || parentOf(b) == a) return true;
  if (model_.has_srdf || problem_.contacts.replace_srdf) return false;
  const int x = rigidRoot(a), y = rigidRoot(b);
  const int above_x = parentOf(x), above_y = parentOf(y);
  return x == y || (above_x >= 0 && rigidRoot(above_x) == y) ||
         (above_y >= 0 && rigidRoot(above_y) == x);
}

}  // namespace leeway::planner
