// MoveIt's allowed collision matrix (moveit_msgs/AllowedCollisionMatrix).

#include <fmt/format.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "planner/problem/moveit/fields.h"

namespace leeway::planner {
namespace {

using robots::Joint;
using robots::JointType;
using robots::Model;

/// The row and the default of a name in a matrix.
struct Entry {
  int row = -1;  ///< -1: none
  std::optional<bool> by_default;
  bool isKnown() const { return row >= 0 || by_default.has_value(); }
};

struct Matrix {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;
  std::map<std::string, Entry> entries;

  Entry entry(const std::string& name) const {
    const auto found = entries.find(name);
    return found == entries.end() ? Entry() : found->second;
  }
  /// Whether two names may touch: by their own entry, else by their defaults, which must both allow
  /// it. Nothing if the matrix has neither.
  std::optional<bool> allows(const Entry& a, const Entry& b) const {
    // A matrix that is not symmetric contradicts itself, so both entries of a pair must allow it.
    if (a.row >= 0 && b.row >= 0)
      return allowed[at(a.row)][at(b.row)] && allowed[at(b.row)][at(a.row)];
    if (!a.by_default && !b.by_default) return std::nullopt;
    return a.by_default.value_or(true) && b.by_default.value_or(true);
  }
};

void readDefaults(const YamlReader& map, Matrix& matrix) {
  const auto names = map.find("default_entry_names");
  const std::vector<YamlReader> name_items =
      hasContent(names) ? names->items() : std::vector<YamlReader>();
  const auto values = map.find("default_entry_values");
  const std::vector<YamlReader> items =
      hasContent(values) ? values->items() : std::vector<YamlReader>();
  if (items.size() != name_items.size())
    (values ? *values : map)
        .fail(fmt::format("{} default_entry_values for {} default_entry_names; equally many are "
                          "expected",
                          items.size(), name_items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) {
    std::optional<bool>& by_default = matrix.entries[name_items[i].text()].by_default;
    if (by_default)
      name_items[i].fail(fmt::format("'{}' stands twice in {}; once is expected",
                                     name_items[i].text(), names->where()));
    by_default = readMoveitBoolean(items[i]);
  }
}

Matrix readMatrix(const YamlReader& map) {
  Matrix matrix;
  readDefaults(map, matrix);
  const auto names = map.find("entry_names");
  if (!hasContent(names)) return matrix;
  for (const YamlReader& name : names->items()) {
    // The first entry of a name counts.
    Entry& entry = matrix.entries[name.text()];
    if (entry.row < 0) entry.row = static_cast<int>(matrix.names.size());
    matrix.names.push_back(name.text());
  }
  const YamlReader rows = map.at("entry_values", "a row of true and false for each entry name");
  for (const YamlReader& row : rows.items()) {
    // MoveIt's own writer nests the row under `enabled`.
    const YamlReader flags = row.isMap() ? row.at("enabled", "a list of true and false") : row;
    std::vector<bool> line;
    for (const YamlReader& flag : flags.items()) line.push_back(readMoveitBoolean(flag));
    if (line.size() != matrix.names.size())
      flags.fail(fmt::format("{} has {} entries for {} names; equally many are expected",
                             flags.where(), line.size(), matrix.names.size()));
    matrix.allowed.push_back(std::move(line));
  }
  if (matrix.allowed.size() != matrix.names.size())
    rows.fail(fmt::format("{} has {} rows for {} names; equally many are expected", rows.where(),
                          matrix.allowed.size(), matrix.names.size()));
  return matrix;
}

/// The name of a link in the matrix; its own name if the matrix has none. A link may lack an entry
/// and be fixed to a link with one after which it is named (`torso_2` on `torso`). It was then
/// split off that link's geometry, and shares its entry.
const std::string& matrixName(const Model& model, const Matrix& matrix, int link) {
  const std::string& name = model.links[at(link)].name;
  while (true) {
    const std::string& candidate = model.links[at(link)].name;
    if (matrix.entry(candidate).isKnown() &&
        (candidate == name || name.rfind(candidate + "_", 0) == 0))
      return candidate;
    const Joint& joint = model.joints[at(link)];
    if (joint.type != JointType::kFixed || joint.parent_link < 0) return name;
    link = joint.parent_link;
  }
}

/// Names the first pair whose two entries differ: it is checked, as are all others of that kind.
void warnOfContradictions(const Matrix& matrix,
                          const std::function<void(const std::string&)>& warn) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t a = 0; a < matrix.names.size(); ++a)
    for (std::size_t b = a + 1; b < matrix.names.size(); ++b)
      if (matrix.allowed[a][b] != matrix.allowed[b][a]) pairs.emplace_back(a, b);
  if (pairs.empty()) return;
  const std::string more =
      pairs.size() > 1 ? fmt::format(", as of {} more", pairs.size() - 1) : std::string();
  warn(
      fmt::format("the matrix has both true and false for '{}' and '{}'{}: what it contradicts "
                  "is checked; a symmetric matrix is expected",
                  matrix.names[pairs.front().first], matrix.names[pairs.front().second], more));
}

/// Allows pairs by the matrix. Pairs that are not in the matrix follow the SRDF.
void takeMatrix(const YamlReader& map, const Matrix& matrix, Problem& problem) {
  const Model& model = *problem.robot.model;
  // Defaults without an SRDF do not say which links are neighbours.
  problem.contacts.replace_srdf = !matrix.names.empty() || model.has_srdf;
  const auto warn = [&](const std::string& message) {
    problem.warnings.push_back(fmt::format("{}:{}: {}", map.file(), map.line(), message));
  };
  const auto allow = [&](const std::string& a, const std::string& b) {
    problem.contacts.allowed.emplace_back(a, b);
  };
  warnOfContradictions(matrix, warn);
  std::map<std::string, Entry> bodies, known;  // `known`: those in the matrix
  for (const Object& object : problem.world.objects)
    bodies.emplace(object.name, matrix.entry(object.name));
  for (const Attachment& held : problem.robot.attachments)
    bodies.emplace(held.object.name, matrix.entry(held.object.name));
  for (const auto& body : bodies)
    if (body.second.isKnown()) known.insert(body);
  for (const auto& [name, entry] : matrix.entries)
    if (known.count(name) == 0 && model.findLink(name) < 0)
      warn(fmt::format("the matrix names '{}', which is no link and no object", name));

  struct LinkEntry : Entry {
    const std::string* name;  ///< in the matrix
  };
  std::vector<LinkEntry> links;
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    const std::string& name = matrixName(model, matrix, static_cast<int>(l));
    links.push_back({matrix.entry(name), &name});
    if (name != model.links[l].name)
      warn(fmt::format("link '{}' is not in the matrix, may touch what '{}' may touch",
                       model.links[l].name, name));
  }
  std::set<std::pair<int, int>> disabled;
  for (const robots::DisabledPair& pair : model.disabled_pairs)
    disabled.insert(std::minmax(pair.link_a, pair.link_b));
  const std::set<int> unchecked(model.unchecked_links.begin(), model.unchecked_links.end());
  const auto isMovedBy = [&](int child, int parent) {
    const Joint& joint = model.joints[at(model.links[at(child)].joint)];
    return joint.parent_link == parent && joint.type != JointType::kFixed;
  };
  for (std::size_t a = 0; a < links.size(); ++a) {
    const int link = static_cast<int>(a);
    for (std::size_t b = a + 1; b < links.size(); ++b) {
      const std::pair pair(link, static_cast<int>(b));
      std::optional<bool> allowed;
      if (*links[a].name != *links[b].name) allowed = matrix.allows(links[a], links[b]);
      if (allowed.value_or(disabled.count(pair) > 0))
        allow(model.links[a].name, model.links[b].name);
      else if (allowed &&
               (isMovedBy(pair.first, pair.second) || isMovedBy(pair.second, pair.first)))
        problem.contacts.checked.emplace_back(model.links[a].name, model.links[b].name);
    }
    const bool is_unchecked = unchecked.count(link) > 0;
    for (const auto& [name, entry] : links[a].by_default || is_unchecked ? bodies : known)
      if (matrix.allows(links[a], entry).value_or(is_unchecked)) allow(name, model.links[a].name);
  }
  // Objects of the world do not move against each other.
  for (const Attachment& held : problem.robot.attachments) {
    const Entry of_held = matrix.entry(held.object.name);
    for (const auto& [name, entry] : of_held.by_default ? bodies : known)
      if (name != held.object.name && matrix.allows(of_held, entry).value_or(false))
        allow(held.object.name, name);
  }
}

}  // namespace

void readAllowedCollisions(const YamlReader& scene, Problem& problem) {
  const auto map = scene.find("allowed_collision_matrix");
  if (!map || !map->isMap()) return;
  if (const Matrix matrix = readMatrix(*map); !matrix.entries.empty())
    takeMatrix(*map, matrix, problem);
}

}  // namespace leeway::planner
