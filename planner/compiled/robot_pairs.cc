#include "planner/compiled/robot_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "collision/base/numbers.h"
#include "leeway/robots/kinematics.h"
#include "planner/validate/names.h"

namespace leeway::planner {
namespace {

using collision::Body;
using robots::LinkGap;

/// Ignores the order of both pairs.
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
  // Static links have the values in `ranges`, which identify a prepared robot. A planned joint may
  // be locked by its limits, and a start that is refused later may be outside them.
  std::vector<double> fixed = problem.start;
  for (std::size_t v = 0; v < ranges.size(); ++v)
    if (ranges[v].lower == ranges[v].upper) fixed[v] = ranges[v].lower;
  robots::forwardKinematics(model_, fixed, poses_);
  findCarriers();
  addLinks();
  addAttachments();
  allowed_ = bodiesOf(problem.contacts.allowed);
  checked_ = bodiesOf(problem.contacts.checked);
  for (int i = 0; i < count(); ++i) {
    for (int j = i + 1; j < count(); ++j)
      if (const std::optional<Reason> why = reason(i, j)) drop(i, j, *why);
    dropped_ends_.push_back(dropped_.size());
  }
  if (derivesPairs()) dropTouching(stop);
}

collision::SceneBuilder RobotPairs::builder() const {
  collision::SceneBuilder builder;
  // Worlds are added to these pairs, and edges identify them by their order, so all are listed.
  builder.listAll();
  for (const Entry& e : entries_) builder.add(e.body);
  for (const auto& [i, j] : is_dropped_) builder.allow(i, j);
  return builder;
}

std::vector<int> RobotPairs::carriers() const {
  std::vector<int> links;
  for (const Entry& e : entries_) links.push_back(e.link);
  return links;
}

std::vector<int> RobotPairs::uncheckedBodies() const {
  std::vector<int> bodies;
  for (int i = 0; i < count(); ++i)
    if (isUnchecked(entries_[at(i)])) bodies.push_back(i);
  return bodies;
}

const LinkGap* RobotPairs::linkGap(int i, int j) const {
  const Entry &a = entries_[at(i)], &b = entries_[at(j)];
  if (!a.isLink() || !b.isLink()) return nullptr;
  const auto gap = std::find_if(link_gaps_.begin(), link_gaps_.end(), [&](const LinkGap& g) {
    return isPair(g.link_a, g.link_b, a.link, b.link);
  });
  return gap == link_gaps_.end() ? nullptr : &*gap;
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
    add({{link.name, link.geometries, carrier_[l] >= 0, poses_[l]}, static_cast<int>(l), nullptr});
  }
}

void RobotPairs::addAttachments() {
  for (const Attachment& a : problem_.robot.attachments) {
    Body body{a.object.name, a.object.geometries, carrier_[at(a.link)] >= 0, poses_[at(a.link)]};
    for (robots::Geometry& g : body.geometries) g.X_BG = a.X_LO * g.X_BG;
    if (!body.geometries.empty()) add({std::move(body), a.link, &a});
  }
}

// Reasons to drop a pair.

std::set<std::pair<int, int>> RobotPairs::bodiesOf(
    const std::vector<std::pair<std::string, std::string>>& pairs) const {
  std::set<std::pair<int, int>> bodies;
  for (const auto& [x, y] : pairs)
    for (const int i : named(x))
      for (const int j : named(y))
        if (i != j) bodies.emplace(std::min(i, j), std::max(i, j));
  return bodies;
}

/// Returns nullopt for a pair that is checked. The condition that two bodies do not move relative
/// to each other is tested first; the reported reason may be another one.
std::optional<RobotPairs::Reason> RobotPairs::reason(int i, int j) const {
  const Entry &a = entries_[at(i)], &b = entries_[at(j)];
  std::optional<Reason> told = contact(i, j);
  if (carrier_[at(a.link)] != carrier_[at(b.link)]) return told;
  if (told) return Reason{Unchecked::kRigid, std::move(told->words)};
  return Reason{Unchecked::kRigid,
                a.body.moving ? "rigidly attached to each other" : "neither moves"};
}

/// The reason why two bodies may touch, by their rules.
std::optional<RobotPairs::Reason> RobotPairs::contact(int i, int j) const {
  if (checked_.count({i, j}) != 0) return std::nullopt;
  const Entry &a = entries_[at(i)], &b = entries_[at(j)];
  const auto plain = [](Unchecked why) { return Reason{why, toString(why)}; };
  if (a.isLink() && b.isLink()) {
    if (areAdjacent(a.link, b.link)) return plain(Unchecked::kAdjacent);
    if (const robots::DisabledPair* d = findDisabled(a.link, b.link)) {
      const Unchecked by = d->is_of_mjcf ? Unchecked::kMjcf : Unchecked::kSrdf;
      return Reason{by, toString(by) + (d->reason.empty() ? "" : ": " + d->reason)};
    }
  }
  if (allowed_.count({i, j}) != 0) return plain(Unchecked::kAllowed);
  if ((a.held != nullptr && b.isLink() && mayTouch(*a.held, b.link)) ||
      (b.held != nullptr && a.isLink() && mayTouch(*b.held, a.link)))
    return plain(Unchecked::kAttached);
  if (a.isLink() != b.isLink() && (isUnchecked(a) || isUnchecked(b)))
    return Reason{Unchecked::kSrdf, "disabled by the SRDF: disable_default_collisions"};
  return std::nullopt;
}

void RobotPairs::drop(int i, int j, const Reason& reason) {
  is_dropped_.insert({i, j});
  dropped_.push_back({name(i), name(j), reason.why, reason.words});
}

/// Drops parts that meet at a joint, in addition to the two links of the joint: they touch at every
/// sample. Two links with several joints between them are checked.
void RobotPairs::dropTouching(const robots::Stop& stop) {
  std::vector<std::pair<int, int>> neighbours, places, touching, bodies;
  for (int i = 0; i < count(); ++i)
    for (int j = i + 1; j < count(); ++j) {
      const Entry &a = entries_[at(i)], &b = entries_[at(j)];
      if (!a.isLink() || !b.isLink() || is_dropped_.count({i, j}) != 0 ||
          checked_.count({i, j}) != 0 || robots::onlyJointBetween(model_, a.link, b.link) < 0)
        continue;
      neighbours.emplace_back(a.link, b.link);
      places.emplace_back(i, j);
    }
  const std::vector<robots::Touch> touches = robots::touchAtJoints(model_, neighbours, stop);
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k] == robots::Touch::kSometimes) warnOfTouch(places[k].first, places[k].second);
    if (touches[k] != robots::Touch::kEverywhere) continue;
    touching.push_back(neighbours[k]);
    bodies.push_back(places[k]);
  }
  const std::vector<std::pair<int, int>> always = robots::provenTouching(model_, touching, stop);
  for (std::size_t k = 0; k < touching.size(); ++k) {
    const bool is_proven = std::find(always.begin(), always.end(), touching[k]) != always.end();
    const Unchecked why = is_proven ? Unchecked::kTouchAlways : Unchecked::kTouchSampled;
    drop(bodies[k].first, bodies[k].second, {why, toString(why)});
    if (std::count(model_.asked_pairs.begin(), model_.asked_pairs.end(),
                   std::pair<int, int>(std::minmax(touching[k].first, touching[k].second))) > 0)
      warnings_.push_back(
          fmt::format("links '{}' and '{}' are not checked although the robot's file has a <pair> "
                      "of them: they are {}",
                      name(bodies[k].first), name(bodies[k].second), toString(why)));
  }
}

/// Parts that rest on each other at the default configuration may be driven into each other from
/// there, so they are checked.
void RobotPairs::warnOfTouch(int i, int j) {
  warnings_.push_back(
      fmt::format("links '{0}' and '{1}' touch at the zero configuration, but not at others: the "
                  "pair is checked; 'allowed: [[{0}, {1}]]' or an SRDF would leave it out",
                  name(i), name(j)));
}

const std::string& RobotPairs::name(int i) const { return entries_[at(i)].body.name; }

std::span<const int> RobotPairs::named(const std::string& name) const {
  const auto found = named_.find(name);
  return found == named_.end() ? std::span<const int>() : found->second;
}

/// In margins, kRobotWord stands for all of these bodies, unless one link of several has that name.
bool RobotPairs::areNamed(int i, int j, const std::string& a, const std::string& b) const {
  const bool is_word = named(kRobotWord).empty() || model_.links.size() == 1;
  const auto isNamed = [&](int body, const std::string& word) {
    return word == name(body) || (is_word && word == kRobotWord);
  };
  return (isNamed(i, a) && isNamed(j, b)) || (isNamed(i, b) && isNamed(j, a));
}

int RobotPairs::parentOf(int link) const {
  return model_.joints[at(model_.links[at(link)].joint)].parent_link;
}

void RobotPairs::findCarriers() {
  for (int l = 0; l < static_cast<int>(model_.links.size()); ++l) {
    const int parent = parentOf(l);
    const bool is_fixed =
        robots::relativeMotion(model_, l, parent, Eigen::Vector3d::Zero(), 0, ranges_)
            .terms.empty();
    carrier_.push_back(!is_fixed ? l : parent < 0 ? -1 : carrier_[at(parent)]);
  }
}

/// Parent and child, unless the SRDF enables them.
bool RobotPairs::areAdjacent(int a, int b) const {
  if (parentOf(a) != b && parentOf(b) != a) return false;
  return std::count(model_.enabled_pairs.begin(), model_.enabled_pairs.end(),
                    std::pair(std::min(a, b), std::max(a, b))) == 0;
}

const robots::DisabledPair* RobotPairs::findDisabled(int a, int b) const {
  if (problem_.contacts.replace_srdf) return nullptr;
  const auto found =
      std::find_if(model_.disabled_pairs.begin(), model_.disabled_pairs.end(),
                   [&](const robots::DisabledPair& d) { return isPair(d.link_a, d.link_b, a, b); });
  return found == model_.disabled_pairs.end() ? nullptr : &*found;
}

bool RobotPairs::isUnchecked(const Entry& entry) const {
  return entry.isLink() && !problem_.contacts.replace_srdf &&
         std::count(model_.unchecked_links.begin(), model_.unchecked_links.end(), entry.link) > 0;
}

const char* toString(Unchecked why) {
  switch (why) {
    case Unchecked::kRigid:
      return "rigidly attached to each other";
    case Unchecked::kAdjacent:
      return "adjacent";
    case Unchecked::kSrdf:
      return "disabled by the SRDF";
    case Unchecked::kMjcf:
      return "disabled by the MJCF or SDF";
    case Unchecked::kAllowed:
      return "allowed by the problem";
    case Unchecked::kAttached:
      return "attached";
    case Unchecked::kTouchAlways:
      return "touching in every configuration";
    case Unchecked::kTouchSampled:
      break;
  }
  return "touching at every sampled configuration";
}

std::vector<UncheckedPairs> countUnchecked(std::span<const CompiledScene::Dropped> dropped) {
  std::map<Unchecked, UncheckedPairs> groups;
  for (const CompiledScene::Dropped& d : dropped) {
    UncheckedPairs& group = groups[d.why];
    group.why = d.why;
    ++group.count;
    if (d.why == Unchecked::kTouchSampled) group.names.emplace_back(d.a, d.b);
  }
  std::vector<UncheckedPairs> counted;
  for (auto& [why, group] : groups) counted.push_back(std::move(group));
  return counted;
}

std::string toString(std::span<const UncheckedPairs> unchecked) {
  int all = 0;
  std::string text;
  for (const UncheckedPairs& group : unchecked) {
    all += group.count;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", group.count, toString(group.why));
    std::string names;
    for (const auto& [a, b] : group.names)
      names += fmt::format("{}{} and {}", names.empty() ? "" : ", ", a, b);
    if (!names.empty()) text += " (" + names + ")";
  }
  if (all == 0) return "All pairs are checked";
  return fmt::format("{} pair{} not checked: {}", all, all == 1 ? " is" : "s are", text);
}

}  // namespace leeway::planner
