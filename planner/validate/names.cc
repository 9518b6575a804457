#include "planner/validate/names.h"

#include <fmt/format.h>

#include <algorithm>

#include "collision/base/numbers.h"
#include "planner/base/did_you_mean.h"

namespace leeway::planner {
namespace {

/// Whether a word keeps its meaning although a link has it as its name: the link has no shape, or
/// is the whole robot.
bool keepsMeaning(const robots::Model& model, std::string_view word) {
  return isBareLink(model, word) || (word == kRobotWord && model.links.size() == 1);
}

bool standsForAll(const Problem& problem, std::string_view word) {
  const auto& pairs = problem.margins.pairs;
  const robots::Model& model = *problem.robot.model;
  return std::any_of(pairs.begin(), pairs.end(),
                     [&](const PairMargin& m) { return m.a == word || m.b == word; }) &&
         (model.findLink(word) < 0 || keepsMeaning(model, word));
}

bool isSamePair(const std::pair<std::string, std::string>& x,
                const std::pair<std::string, std::string>& y) {
  return x == y || (x.first == y.second && x.second == y.first);
}

/// The fault of a name that has a meaning already; empty for other names.
const char* reservedFault(std::string_view name) {
  return name == kRobotWord ? kNameReserved : name == kWorldWord ? kWorldReserved : "";
}

}  // namespace

Names::Names(const Problem& problem)
    : problem_(problem),
      held_(problem.robot.model->links.size()),
      objects_(held_ + problem.robot.attachments.size()),
      deforming_(objects_ + problem.world.objects.size()),
      table_(at(count())) {
  const auto nameOf = [this](int thing) -> std::string_view { return name(thing); };
  for (int thing = 0; thing < count(); ++thing) {
    const std::string& own = name(thing);
    const bool is_taken = table_.insert(thing, own, nameOf) != thing;
    const std::string fault = own.empty()          ? "is empty; a name of its own is expected"
                              : at(thing) >= held_ ? objectNameFault(own, is_taken)
                              : is_taken           ? kNameTaken
                                                   : "";
    if (fault_.empty() && !fault.empty())
      fault_ = place(thing) + (own.empty() ? " " : " '" + own + "' ") + fault;
  }
}

const std::string& Names::name(int thing) const {
  const std::size_t i = at(thing);
  if (i < held_) return problem_.robot.model->links[i].name;
  if (i < objects_) return problem_.robot.attachments[i - held_].object.name;
  if (i < deforming_) return problem_.world.objects[i - objects_].name;
  return problem_.world.deforming[i - deforming_].object.name;
}

std::string Names::place(int thing) const {
  const std::size_t i = at(thing);
  if (i < held_) return fmt::format("robot.model->links[{}].name", i);
  if (i < objects_) return fmt::format("robot.attachments[{}].object.name", i - held_);
  if (i < deforming_) return fmt::format("world.objects[{}].name", i - objects_);
  return fmt::format("world.deforming[{}].object.name", i - deforming_);
}

bool Names::isKnown(std::string_view name) const {
  return table_.numberOf(name,
                         [this](int thing) -> std::string_view { return this->name(thing); }) >= 0;
}

std::string Names::unknown(std::string_view name, std::vector<std::string> others) const {
  if (name == kWorldWord)
    return "'world' stands for all objects in margins only; the names of the objects that are "
           "meant are expected";
  std::vector<std::string> known;
  for (int thing = 0; thing < count(); ++thing) known.push_back(this->name(thing));
  known.insert(known.end(), others.begin(), others.end());
  return fmt::format("no link or object is named '{}'{}", name, didYouMean(name, known));
}

std::string Names::pairFault(const std::string& a, const std::string& b) const {
  if (!isKnown(a)) return unknown(a);
  if (!isKnown(b)) return unknown(b);
  return a == b ? sameName(a) : std::string();
}

std::string Names::checkedFault(const std::string& a, const std::string& b) const {
  if (std::string fault = pairFault(a, b); !fault.empty()) return fault;
  for (const std::string& name : {a, b})
    if (problem_.robot.model->findLink(name) < 0)
      return "'" + name + "' is no link; two links are expected";
  if (allowed_.empty())
    for (const auto& [x, y] : problem_.contacts.allowed) allowed_.emplace(std::minmax(x, y));
  return allowed_.count(std::minmax(a, b)) > 0
             ? "'" + a + "' and '" + b + "' are allowed to touch, too; one of both is expected"
             : std::string();
}

void allowPairs(const std::vector<std::pair<std::string, std::string>>& pairs, Contacts& contacts) {
  for (const auto& pair : pairs) {
    contacts.allowed.push_back(pair);
    std::erase_if(contacts.checked, [&](const auto& other) { return isSamePair(pair, other); });
  }
}

std::string Names::marginFault(const std::string& a, const std::string& b) const {
  const auto isWord = [this](const std::string& side) {
    return (side == kRobotWord || side == kWorldWord) &&
           (!isKnown(side) || keepsMeaning(*problem_.robot.model, side));
  };
  for (const auto& [side, other] : {std::pair(a, b), std::pair(b, a)}) {
    if (!isWord(side)) continue;
    if (other == kWorldWord && !isWord(other))
      return "'world' is the name of a link, so that it does not stand for all objects; a link of "
             "another name, or the names of the objects that are meant, are expected";
    if (isWord(other)) return a == b && a == kWorldWord ? sameName(a) : std::string();
    return isKnown(other) ? std::string() : unknown(other, {kRobotWord, kWorldWord});
  }
  return pairFault(a, b);
}

bool isBareLink(const robots::Model& model, std::string_view name) {
  const int link = model.findLink(name);
  return link >= 0 && model.links[at(link)].geometries.empty();
}

MarginWords::MarginWords(const Problem& problem)
    : robot(standsForAll(problem, kRobotWord)), world(standsForAll(problem, kWorldWord)) {}

std::string objectNameFault(std::string_view name, bool is_taken) {
  const char* const reserved = reservedFault(name);
  return *reserved == '\0' && is_taken ? kNameTaken : reserved;
}

std::string frameNameFault(const Names& names, std::string_view name) {
  if (const char* const reserved = reservedFault(name); *reserved != '\0')
    return fmt::format("frame '{}' {}", name, reserved);
  if (!name.empty() && !names.isKnown(name)) return {};
  return fmt::format("frame '{}' has {}; a name of its own is expected", name,
                     name.empty() ? "no name" : "the name of a link or object");
}

std::string sameName(const std::string& name) {
  return fmt::format("'{}' stands twice; two different names of links or objects are expected",
                     name);
}

}  // namespace leeway::planner
