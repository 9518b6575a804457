#include "planner/execute/unchecked_json.h"

#include <nlohmann/json.hpp>

namespace leeway::planner {

nlohmann::ordered_json uncheckedJson(std::span<const UncheckedPairs> unchecked) {
  int all = 0;
  nlohmann::ordered_json reasons = nlohmann::ordered_json::array();
  for (const UncheckedPairs& group : unchecked) {
    all += group.count;
    nlohmann::ordered_json reason = {{"reason", toString(group.why)}, {"pairs", group.count}};
    for (const auto& [a, b] : group.names)
      reason["names"].push_back(nlohmann::ordered_json::array({a, b}));
    reasons.push_back(std::move(reason));
  }
  return {{"pairs", all}, {"reasons", reasons}};
}

}  // namespace leeway::planner
