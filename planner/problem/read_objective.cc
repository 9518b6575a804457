#include "planner/problem/read_objective.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <utility>

#include "planner/problem/fail_at.h"
#include "planner/problem/read_settings.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

/// Reads an objective that has settings.
Objective readSettingsOf(const Objective& objective, const YamlReader& map) {
  const std::string word = toString(objective);
  map.expectKeys(keysOf(word + "_objective"));
  Problem problem;
  problem.objective = objective;
  readSettings(map, "objective." + word, problem);
  return problem.objective;
}

Pairs readPairsOf(const YamlReader& of) {
  for (const auto& [word, pairs] :
       {std::pair{"world", Pairs::kWorld}, {"self", Pairs::kSelf}, {"all", Pairs::kAll}})
    if (of.text() == word) return pairs;
  of.fail(
      fmt::format("{} '{}' is not known; world, self or all is expected", of.where(), of.text()));
}

/// Reads a term of a cost from a map whose keys have been checked.
CostTerm readTerm(const YamlReader& reader) {
  const auto hinge = reader.find("hinge"), inverse = reader.find("inverse");
  if (hinge.has_value() == inverse.has_value())
    reader.fail(fmt::format("{} has {}; one of hinge and inverse is expected", reader.where(),
                            hinge ? "both" : "neither"));
  CostTerm term;
  term.nearness.kind = hinge ? Nearness::Kind::kHinge : Nearness::Kind::kInverse;
  const YamlReader& distance = hinge ? *hinge : *inverse;
  term.nearness.distance = distance.number();
  if (const auto of = reader.find("of")) term.of = readPairsOf(*of);
  if (const auto weight = reader.find("weight")) term.weight = weight->number();
  if (const auto fault = termFault(term, reader.where())) failAt(reader, *fault);
  return term;
}

MinimumCost readIntegral(const YamlReader& integral) {
  integral.expectKeys(keysOf("nearness"));
  return {0, {readTerm(integral)}};
}

MinimumCost readWeighted(const YamlReader& weighted) {
  weighted.expectKeys(keysOf("weighted_objective"));
  MinimumCost cost;
  if (const auto length = weighted.find("length")) cost.length = length->sizeNumber();
  for (const char* key : {"integral", "worst"}) {
    const auto terms = weighted.find(key);
    if (!terms) continue;
    const auto read = [&](const YamlReader& reader) {
      reader.expectKeys(keysOf("weighted_nearness"));
      cost.terms.push_back(readTerm(reader));
      cost.terms.back().worst = std::string_view(key) == "worst";
    };
    if (terms->isMap()) {
      read(*terms);
    } else {
      for (const YamlReader& term : terms->items()) read(term);
    }
  }
  if (const auto fault = costFault(cost)) weighted.fail(*fault);
  return cost;
}

}  // namespace

const char* toString(const Objective& objective) {
  if (std::holds_alternative<MinimumLength>(objective)) return "length";
  if (std::holds_alternative<MaximumClearance>(objective)) return "clearance";
  const auto& cost = std::get<MinimumCost>(objective);
  return cost.length == 0 && cost.terms.size() == 1 && !cost.terms[0].worst ? "integral"
                                                                            : "weighted";
}

std::optional<Objective> objectiveOfName(std::string_view name) {
  for (const Objective& objective : {Objective(MinimumLength()), Objective(MaximumClearance())})
    if (name == toString(objective)) return objective;
  return std::nullopt;
}

Objective readObjective(const YamlReader& objective) {
  if (!objective.isMap()) {
    const std::optional<Objective> known = objectiveOfName(objective.text());
    if (!known)
      objective.fail(fmt::format(
          "objective '{}' is not known; length, clearance, or a map with integral or weighted is "
          "expected",
          objective.text()));
    return *known;
  }
  objective.expectKeys(keysOf("objective"));
  std::optional<Objective> found;
  for (const std::string_view key : keysOf("objective")) {
    const auto value = objective.find(std::string(key).c_str());
    if (!value) continue;
    if (found)
      objective.fail(
          fmt::format("{} has several words; one of length, clearance, integral and "
                      "weighted is expected",
                      objective.where()));
    if (key == "length") found = readSettingsOf(MinimumLength(), *value);
    if (key == "clearance") found = readSettingsOf(MaximumClearance(), *value);
    if (key == "integral") found = readIntegral(*value);
    if (key == "weighted") found = readWeighted(*value);
  }
  if (!found)
    objective.fail(
        fmt::format("{} is empty; one of length, clearance, integral and weighted is "
                    "expected",
                    objective.where()));
  return *found;
}

}  // namespace leeway::planner
