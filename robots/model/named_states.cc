#include "leeway/robots/named_states.h"

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"

namespace leeway::robots {

std::vector<GroupState> namedStates(const Model& model) {
  std::vector<GroupState> states = model.group_states;
  const auto isTaken = [&](const std::string& name) {
    return !model.whyLeftOut("group state", name).empty() ||
           std::any_of(model.group_states.begin(), model.group_states.end(),
                       [&](const GroupState& state) { return state.name == name; });
  };
  std::vector<double> q = model.defaultConfiguration();
  const auto add = [&](const char* name) {
    if (isTaken(name) || q.empty()) return;
    GroupState state{name, "all", {}};
    for (std::size_t v = 0; v < q.size(); ++v) state.values.emplace_back(static_cast<int>(v), q[v]);
    states.push_back(std::move(state));
  };
  add("zero");
  for (std::size_t v = 0; v < q.size(); ++v) {
    const Variable& variable = model.variables[v];
    const Joint& joint = model.joints[at(variable.joint)];
    const bool is_quaternion =
        joint.type == JointType::kFloating && static_cast<int>(v) >= joint.first_variable + 3;
    // Halves, because the limits' sum may overflow.
    if (!is_quaternion && std::isfinite(variable.lower) && std::isfinite(variable.upper))
      q[v] = variable.lower / 2 + variable.upper / 2;
  }
  add("middle");
  return states;
}

}  // namespace leeway::robots
