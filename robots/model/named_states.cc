#include "leeway/robots/named_states.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <utility>

#include "collision/base/numbers.h"

namespace leeway::robots {
namespace {

std::string numberText(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << value;
  return text.str();
}

}  // namespace

std::vector<GroupState> namedStates(const Model& model) {
  std::vector<GroupState> states = model.group_states;
  const auto isTaken = [&](const std::string& name) {
    return !model.whyLeftOut("group state", name).empty() ||
           std::any_of(model.group_states.begin(), model.group_states.end(),
                       [&](const GroupState& state) { return state.name == name; });
  };
  std::vector<double> q = model.defaultConfiguration();
  for (std::size_t v = 0; v < q.size(); ++v) {
    const Variable& variable = model.variables[v];
    if (model.joints[at(variable.joint)].type != JointType::kFloating)
      q[v] = std::clamp(0.0, variable.lower, variable.upper);
  }
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

std::string stateLackFault(const Model& model, std::string_view name,
                           std::span<const int> variables, std::string_view which) {
  std::optional<std::vector<int>> least;
  for (const GroupState& state : namedStates(model)) {
    if (state.name != name) continue;
    std::vector<int> lacking;
    for (const int v : variables)
      if (std::none_of(state.values.begin(), state.values.end(),
                       [v](const auto& value) { return value.first == v; }))
        lacking.push_back(v);
    if (!least || lacking.size() < least->size()) least = std::move(lacking);
  }
  if (!least || least->empty()) return {};
  constexpr std::size_t kNamed = 8;
  const std::size_t count = least->size();
  std::string names;
  for (std::size_t i = 0; i < std::min(count, kNamed); ++i) {
    const bool is_last = i + 1 == count;
    names += (i == 0    ? "'"
              : is_last ? " and '"
                        : ", '") +
             model.variables[at((*least)[i])].name + "'";
  }
  if (count > kNamed) names += " and " + std::to_string(count - kNamed) + " more";
  return "group state '" + std::string(name) + "' lacks " + (count == 1 ? "joint " : "joints ") +
         names + "; a state with a value for " + std::string(which) + " is expected";
}

std::string otherValues(const Model& model, std::string_view name, std::span<const int> variables,
                        std::span<const double> q) {
  for (const GroupState& state : model.group_states) {
    const auto gives = [&](int v) {
      return std::any_of(state.values.begin(), state.values.end(),
                         [v](const auto& value) { return value.first == v; });
    };
    if (state.name != name || !std::all_of(variables.begin(), variables.end(), gives)) continue;
    std::string given, stands;
    int count = 0;
    for (const auto& [v, value] : state.values) {
      if (value == q[at(v)] || std::find(variables.begin(), variables.end(), v) != variables.end())
        continue;
      given += (count == 0 ? "'" : ", '") + model.variables[at(v)].name + "' " + numberText(value);
      stands += (count == 0 ? "" : ", ") + numberText(q[at(v)]);
      ++count;
    }
    if (count == 0) return {};
    return "group state '" + std::string(name) + "' gives " + given +
           (count == 1 ? ", which is not planned and stands at "
                       : ", which are not planned and stand at ") +
           stands;
  }
  return {};
}

}  // namespace leeway::robots
