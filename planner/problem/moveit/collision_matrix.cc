// MoveIt's allowed collision matrix (moveit_msgs/AllowedCollisionMatrix).

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "collision/base/numbers.h"
#include "planner/problem/moveit/fields.h"

namespace leeway::planner {
namespace {

using robots::Joint;
using robots::JointType;
using robots::Model;

struct Matrix {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;
  int index(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }
};

Matrix readMatrix(const YamlReader& map) {
  Matrix matrix;
  const auto names = map.find("entry_names");
  if (!hasContent(names)) return matrix;
  for (const YamlReader& name : names->items()) matrix.names.push_back(name.text());
  const YamlReader rows = map.at("entry_values", "a row of true and false for each entry name");
  for (const YamlReader& row : rows.items()) {
    // MoveIt's own writer nests the row under `enabled`.
    const YamlReader flags = row.isMap() ? row.at("enabled", "a list of true and false") : row;
    std::vector<bool> line;
    for (const YamlReader& flag : flags.items()) line.push_back(flag.boolean());
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

/// The matrix entry that holds for a link; -1: none. A link without one that is fixed to a link
/// with one and named after it (`torso_2` on `torso`) was split off that link's geometry, and
/// shares its entry.
int matrixEntry(const Model& model, const Matrix& matrix, int link) {
  const std::string& name = model.links[at(link)].name;
  while (true) {
    const std::string& candidate = model.links[at(link)].name;
    const int entry = matrix.index(candidate);
    if (entry >= 0 && (candidate == name || name.rfind(candidate + "_", 0) == 0)) return entry;
    const Joint& joint = model.joints[at(link)];
    if (joint.type != JointType::kFixed || joint.parent_link < 0) return -1;
    link = joint.parent_link;
  }
}

/// Allows pairs of links by the matrix where it has both, by the SRDF where it has not; pairs with
/// objects by the matrix.
void takeMatrix(const YamlReader& map, const Matrix& matrix, Problem& problem) {
  const Model& model = *problem.robot.model;
  problem.contacts.replace_srdf = true;
  std::vector<int> entry(model.links.size());
  for (std::size_t l = 0; l < entry.size(); ++l) {
    entry[l] = matrixEntry(model, matrix, static_cast<int>(l));
    if (entry[l] >= 0 && matrix.names[at(entry[l])] != model.links[l].name)
      problem.warnings.push_back(
          fmt::format("{}:{}: link '{}' is not in the matrix, may touch what '{}' may touch",
                      map.file(), map.line(), model.links[l].name, matrix.names[at(entry[l])]));
  }
  std::set<std::pair<int, int>> disabled;
  for (const robots::DisabledPair& pair : model.disabled_pairs)
    disabled.insert(std::minmax(pair.link_a, pair.link_b));
  // A matrix that is not symmetric contradicts itself: a pair needs both entries.
  const auto both = [&](int i, int j) {
    return matrix.allowed[at(i)][at(j)] && matrix.allowed[at(j)][at(i)];
  };
  for (std::size_t a = 0; a < entry.size(); ++a)
    for (std::size_t b = a + 1; b < entry.size(); ++b) {
      const bool known = entry[a] >= 0 && entry[b] >= 0 && entry[a] != entry[b];
      if (known ? both(entry[a], entry[b])
                : disabled.count({static_cast<int>(a), static_cast<int>(b)}) > 0)
        problem.contacts.allowed.emplace_back(model.links[a].name, model.links[b].name);
    }
  std::set<std::string> bodies;
  for (const Object& object : problem.world.objects) bodies.insert(object.name);
  for (const Attachment& attachment : problem.robot.attachments)
    bodies.insert(attachment.object.name);
  for (std::size_t i = 0; i < matrix.names.size(); ++i) {
    const bool body = bodies.count(matrix.names[i]) > 0;
    if (!body && model.findLink(matrix.names[i]) < 0)
      problem.warnings.push_back(
          fmt::format("{}:{}: the matrix names '{}', which is no link and no object", map.file(),
                      map.line(), matrix.names[i]));
    for (std::size_t j = 0; body && j < matrix.names.size(); ++j) {
      const bool other_body = bodies.count(matrix.names[j]) > 0;
      if ((other_body ? i < j : model.findLink(matrix.names[j]) >= 0) &&
          both(static_cast<int>(i), static_cast<int>(j)))
        problem.contacts.allowed.emplace_back(matrix.names[i], matrix.names[j]);
    }
  }
}

}  // namespace

void readAllowedCollisions(const YamlReader& scene, Problem& problem) {
  const auto map = scene.find("allowed_collision_matrix");
  if (!map || !map->isMap()) return;
  if (const Matrix matrix = readMatrix(*map); !matrix.names.empty())
    takeMatrix(*map, matrix, problem);
}

}  // namespace leeway::planner
