#include "planner/problem/read_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>

#include "collision/base/numbers.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/read_poses.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"

namespace leeway::planner {
namespace {

using robots::InputError;
using robots::Joint;
using robots::JointType;
using robots::Model;

bool planned(const Problem& problem, int variable) {
  return std::find(problem.robot.variables.begin(), problem.robot.variables.end(), variable) !=
         problem.robot.variables.end();
}

/// The planar or floating joint of a pose without a joint's name: the only planned one; -1 if there
/// is another number of them.
int plannedBodyJoint(const Problem& problem) {
  int found = -1;
  for (const int v : problem.robot.variables) {
    const int joint = problem.robot.model->variables[at(v)].joint;
    const JointType type = problem.robot.model->joints[at(joint)].type;
    if (type != JointType::kPlanar && type != JointType::kFloating) continue;
    if (found >= 0 && found != joint) return -1;
    found = joint;
  }
  return found;
}

std::vector<std::string> jointNames(const Model& model) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints)
    if (joint.variable_count > 0) names.push_back(joint.name);
  return names;
}

std::string plannedNames(const Problem& problem) {
  std::string names;
  for (const int v : problem.robot.variables)
    names += (names.empty() ? "" : ", ") + problem.robot.model->variables[at(v)].name;
  return names;
}

/// Reads one state. Only goals may have ranges.
class StateReader {
 public:
  StateReader(Problem& problem, bool goal)
      : problem_(problem), model_(*problem.robot.model), goal_(goal) {
    ranges_.resize(model_.variables.size());
  }

  VariableRanges read(const YamlReader& reader) {
    if (reader.isScalar())
      return groupStateRanges(reader.file(), reader.line(), reader.text(), problem_);
    if (reader.isList()) {
      readList(reader);
    } else if (reader.isMap()) {
      readMap(reader);
    } else {
      reader.fail(
          fmt::format("{} is empty; a group state, a list of values or a map by joint is expected",
                      reader.where()));
    }
    return ranges_;
  }

  /// Reads values by joint. For a single planned body, also reads its pose.
  void readMap(const YamlReader& reader) {
    const int body = plannedBodyJoint(problem_);
    if (body >= 0 && reader.has("position") && model_.findJoint("position") < 0) {
      readBodyPose(reader, model_.joints[at(body)]);
      return;
    }
    for (const auto& [name, value] : reader.entries()) readEntry(reader, name, value);
  }

  const VariableRanges& ranges() const { return ranges_; }

 private:
  void readList(const YamlReader& reader) {
    const std::vector<YamlReader> items = reader.items();
    if (items.size() != problem_.robot.variables.size())
      reader.fail(fmt::format("{} is a list of {}; {} values are expected: {}", reader.where(),
                              items.size(), problem_.robot.variables.size(),
                              plannedNames(problem_)));
    for (std::size_t i = 0; i < items.size(); ++i) readValue(items[i], problem_.robot.variables[i]);
  }

  void readEntry(const YamlReader& map, const std::string& name, const YamlReader& value) {
    const int variable = model_.findVariable(name);
    if (variable >= 0) return readValue(value, variable);
    const int index = model_.findJoint(name);
    if (index < 0)
      value.fail(fmt::format("unknown joint '{}' in {}{}", name, map.where(),
                             didYouMean(model_, "virtual joint", name, jointNames(model_))));
    const Joint& joint = model_.joints[at(index)];
    if (joint.type == JointType::kPlanar || joint.type == JointType::kFloating)
      return readBodyPose(value, joint);
    const double number = value.number();
    if (goal_)
      value.fail(fmt::format("joint '{}' in {} {}; a planned joint is expected: {}", name,
                             map.where(), joint.mimic >= 0 ? "follows another joint" : "is fixed",
                             plannedNames(problem_)));
    // Drivers report such joints too, but a configuration has no value for them.
    problem_.warnings.push_back(fmt::format(
        "{}:{}: {} = {} has no effect: joint '{}' {}", value.file(), value.line(), value.where(),
        number, name, joint.mimic >= 0 ? "follows another joint" : "is fixed"));
  }

  void readBodyPose(const YamlReader& map, const Joint& joint) {
    const bool planar = joint.type == JointType::kPlanar;
    map.expectKeys(keysOf(planar ? "planar_pose" : "pose"));
    const YamlReader position = map.at("position", planar ? "[x, y]" : "[x, y, z]");
    const std::vector<YamlReader> items = position.items();
    if (items.size() != (planar ? 2U : 3U))
      position.fail(fmt::format("{} is a list of {}; {} is expected", position.where(),
                                items.size(), planar ? "[x, y]" : "[x, y, z]"));
    for (std::size_t i = 0; i < items.size(); ++i)
      readValue(items[i], joint.first_variable + static_cast<int>(i));
    if (planar) {
      const auto angle = map.find("angle");
      if (angle) return readValue(*angle, joint.first_variable + 2);
      return set(joint.first_variable + 2, 0, 0, map.line());
    }
    const Eigen::Vector4d q = readOrientation(map, problem_.warnings);
    for (int i = 0; i < 4; ++i) set(joint.first_variable + 3 + i, q[i], q[i], map.line());
  }

  void readValue(const YamlReader& value, int variable) {
    if (goal_ && value.isScalar() && value.text() == "any") {
      const robots::Variable& v = model_.variables[at(variable)];
      const bool circle = turnsFreely(variable);
      if (!circle && !(std::isfinite(v.lower) && std::isfinite(v.upper)))
        value.fail(fmt::format(
            "{} is 'any', but {} has no limits; a number or a pair [from, to] is expected",
            value.where(), variableText(model_, variable)));
      if (!circle && !(std::max(-v.lower, v.upper) <= kLargestAngle))
        value.fail(fmt::format(
            "{} is 'any', but the limits of {} are {} to {}, beyond +-{}; a number or a pair "
            "[from, to] is expected",
            value.where(), variableText(model_, variable), v.lower, v.upper, kLargestAngle));
      return set(variable, circle ? -std::numbers::pi : v.lower,
                 circle ? std::numbers::pi : v.upper, value.line());
    }
    if (goal_ && value.isList()) {
      const std::vector<double> range = value.numbers();
      if (range.size() != 2 || !(range[0] <= range[1]))
        value.fail(
            fmt::format("{} is no range; [from, to] with from <= to is expected", value.where()));
      return set(variable, range[0], range[1], value.line());
    }
    const double number = value.number();
    set(variable, number, number, value.line());
  }

  bool turnsFreely(int variable) const {
    const robots::Variable& v = model_.variables[at(variable)];
    const Joint& joint = model_.joints[at(v.joint)];
    return std::isinf(v.lower) && std::isinf(v.upper) &&
           (joint.type == JointType::kContinuous ||
            (joint.type == JointType::kPlanar && variable == joint.first_variable + 2));
  }

  void set(int variable, double lower, double upper, int line) {
    ranges_[at(variable)] = {true, lower, upper, line};
  }

  Problem& problem_;
  const Model& model_;
  bool goal_;
  VariableRanges ranges_;
};

/// Throws unless every planned variable is given and within its limits. `what` is "start" or the
/// goal's name.
void checkPlanned(const std::string& file, int line, const std::string& what,
                  const VariableRanges& given, const Problem& problem) {
  for (const int v : problem.robot.variables) {
    const VariableRange& range = given[at(v)];
    if (!range.given)
      throw InputError(
          file, line,
          fmt::format("{} says nothing of {}; a value for every planned joint is expected: {}",
                      what, variableText(*problem.robot.model, v), plannedNames(problem)));
    if (const auto fault = rangeFault(*problem.robot.model, v, range.lower, range.upper))
      throw InputError(file, range.line > 0 ? range.line : line, what + " has " + *fault);
  }
}

}  // namespace

void takeStart(const std::string& file, int line, const VariableRanges& given, Problem& problem) {
  checkPlanned(file, line, "start", given, problem);
  for (std::size_t v = 0; v < given.size(); ++v)
    if (given[v].given) problem.start[v] = given[v].lower;
}

Goal takeGoal(const std::string& file, int line, const std::string& name,
              const VariableRanges& given, const Problem& problem) {
  checkPlanned(file, line, name, given, problem);
  for (std::size_t v = 0; v < given.size(); ++v)
    if (given[v].given && !planned(problem, static_cast<int>(v)))
      throw InputError(file, given[v].line > 0 ? given[v].line : line,
                       fmt::format("{} names {}, which is not planned; planned are {}", name,
                                   variableText(*problem.robot.model, static_cast<int>(v)),
                                   plannedNames(problem)));
  Goal goal;
  goal.name = name;
  for (const int v : problem.robot.variables)
    goal.ranges.emplace_back(given[at(v)].lower, given[at(v)].upper);
  return goal;
}

VariableRanges groupStateRanges(const std::string& file, int line, const std::string& name,
                                const Problem& problem) {
  const Model& model = *problem.robot.model;
  std::vector<std::string> known;
  const std::string why = model.whyStateLeftOut(name, problem.robot.variables);
  if (!why.empty())
    throw InputError(file, line, fmt::format("group state '{}' is not known{}", name, why));
  for (const robots::GroupState& state : robots::namedStates(model)) {
    const auto covers = [&](int v) {
      return std::any_of(state.values.begin(), state.values.end(),
                         [&](const auto& value) { return value.first == v; });
    };
    // A state of another group is usable if it has all planned variables.
    if (!std::all_of(problem.robot.variables.begin(), problem.robot.variables.end(), covers))
      continue;
    if (state.name != name) {
      known.push_back(state.name);
      continue;
    }
    VariableRanges ranges(model.variables.size());
    for (const auto& [v, value] : state.values)
      if (planned(problem, v)) ranges[at(v)] = {true, value, value, 0};
    return ranges;
  }
  throw InputError(file, line,
                   fmt::format("no group state '{}' for the planned joints{}", name,
                               didYouMean(model, "group state", name, known)));
}

VariableRanges statedRanges(const std::string& what, const std::string& text,
                            const Problem& problem) {
  std::string spaced = text;
  std::replace(spaced.begin(), spaced.end(), ',', ' ');
  std::istringstream words(spaced);
  std::vector<double> values;
  for (std::string word; words >> word;) {
    const std::optional<double> value = robots::parseFinite(word);
    if (!value) return groupStateRanges("", 0, text, problem);
    values.push_back(*value);
  }
  if (values.empty()) return groupStateRanges("", 0, text, problem);
  const std::vector<int>& variables = problem.robot.variables;
  if (values.size() != variables.size())
    throw InputError("", 0,
                     fmt::format("{} '{}' is {} numbers; {} are expected, of {}", what, text,
                                 values.size(), variables.size(), plannedNames(problem)));
  VariableRanges ranges(problem.robot.model->variables.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    ranges[at(variables[i])] = {true, values[i], values[i], 0};
  return ranges;
}

void readStart(const YamlReader& reader, Problem& problem) {
  if (givesPoses(reader, *problem.robot.model)) {
    problem.start_poses = readPoseRegions(reader, problem);
    return;
  }
  const VariableRanges given = StateReader(problem, false).read(reader);
  takeStart(reader.file(), reader.line(), given, problem);
}

Goal readGoal(const YamlReader& reader, const std::string& name, Problem& problem) {
  if (givesPoses(reader, *problem.robot.model)) return {name, {}, readPoseRegions(reader, problem)};
  const VariableRanges given = StateReader(problem, true).read(reader);
  return takeGoal(reader.file(), reader.line(), reader.isScalar() ? reader.text() : name, given,
                  problem);
}

namespace {

/// Takes the values of the joints that are not planned from a state: `joints: open`.
void takePassiveState(const YamlReader& reader, Problem& problem) {
  const Model& model = *problem.robot.model;
  const std::string name = reader.text();
  std::vector<std::string> known;
  std::vector<robots::GroupState> found;
  for (robots::GroupState& state : robots::namedStates(model)) {
    std::erase_if(state.values, [&](const auto& value) { return planned(problem, value.first); });
    if (state.values.empty()) continue;
    known.push_back(state.name);
    if (state.name == name) found.push_back(std::move(state));
  }
  if (found.empty()) {
    const std::string why = model.whyLeftOut("group state", name);
    reader.fail(why.empty() ? fmt::format("no group state '{}' for joints that are not planned{}",
                                          name, didYouMean(model, "group state", name, known))
                            : fmt::format("group state '{}' is not known{}", name, why));
  }
  if (found.size() > 1)
    reader.fail(fmt::format(
        "the groups '{}' and '{}' both have a state '{}' for joints that are not planned; a map by "
        "joint is expected",
        found[0].group, found[1].group, name));
  for (const auto& [v, value] : found[0].values) problem.start[at(v)] = value;
}

}  // namespace

void readPassiveJoints(const YamlReader& reader, Problem& problem) {
  if (reader.isScalar()) return takePassiveState(reader, problem);
  StateReader states(problem, false);
  for (const auto& [name, value] : reader.entries())
    if (const int v = problem.robot.model->findVariable(name); v >= 0 && planned(problem, v))
      value.fail(fmt::format("{} is planned; its value belongs under 'start'",
                             variableText(*problem.robot.model, v)));
  states.readMap(reader);
  const VariableRanges& given = states.ranges();
  for (std::size_t v = 0; v < given.size(); ++v)
    if (given[v].given) problem.start[v] = given[v].lower;
}

}  // namespace leeway::planner
