#include "planner/problem/read_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>

#include "collision/base/numbers.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/text.h"
#include "planner/base/cells.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/largest_value.h"
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

/// The planar or floating joint that a pose without a joint's name means: the only one of these
/// variables, else -1.
int onlyBodyJoint(const Model& model, std::span<const int> variables) {
  int found = -1;
  for (const int v : variables) {
    const int joint = model.variables[at(v)].joint;
    const JointType type = model.joints[at(joint)].type;
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

std::string namesOf(const Model& model, std::span<const int> variables) {
  std::string names;
  for (const int v : variables) names += (names.empty() ? "" : ", ") + model.variables[at(v)].name;
  return names;
}

/// The end of a message about a name that is neither a joint's nor a group's.
std::string nearJointOrGroup(const Model& model, const std::string& name) {
  const std::vector<std::string> groups = groupNames(model);
  std::vector<std::string> known = jointNames(model), all = known;
  all.insert(all.end(), groups.begin(), groups.end());
  const std::string* const near = robots::nearestName(name, all);
  if (near != nullptr && model.findGroup(*near) >= 0) known = groups;
  return didYouMean(model, "virtual joint", name, known);
}

std::string plannedNames(const Problem& problem) {
  return namesOf(*problem.robot.model, problem.robot.variables);
}

/// The values of a group state. Throws, naming file and line, when no state of that name has a
/// value for every one of `variables`. Of several, that of the group of this name goes first.
VariableRanges groupStateRanges(const std::string& file, int line, const std::string& name,
                                const Model& model, std::span<const int> variables,
                                const std::string& group = {}) {
  std::vector<std::string> known;
  const std::string why = model.whyStateLeftOut(name, variables);
  if (!why.empty())
    throw InputError(file, line, fmt::format("group state '{}' is not known{}", name, why));
  std::vector<robots::GroupState> states = robots::namedStates(model);
  std::stable_partition(states.begin(), states.end(),
                        [&](const auto& state) { return state.group == group; });
  for (const robots::GroupState& state : states) {
    VariableRanges ranges(model.variables.size());
    for (const auto& [v, value] : state.values)
      if (std::find(variables.begin(), variables.end(), v) != variables.end())
        ranges[at(v)] = {true, value, value, 0};
    // A state of another group serves if it has all of the variables.
    if (!std::all_of(variables.begin(), variables.end(),
                     [&](int v) { return ranges[at(v)].given; }))
      continue;
    if (state.name == name) return ranges;
    known.push_back(state.name);
  }
  const std::string of = fmt::format("joint of group '{}'", group);
  if (const std::string fault = robots::stateLackFault(
          model, name, variables, "each " + (group.empty() ? "planned joint" : of));
      !fault.empty())
    throw InputError(file, line, fault);
  throw InputError(
      file, line,
      fmt::format("no group state '{}' for {}{}", name,
                  group.empty() ? "the planned joints" : fmt::format("group '{}'", group),
                  didYouMean(model, "group state", name, known)));
}

/// Whether a variable is an angle without limits.
bool turnsWithoutLimits(const Model& model, int variable) {
  const robots::Variable& v = model.variables[at(variable)];
  const Joint& joint = model.joints[at(v.joint)];
  return std::isinf(v.lower) && std::isinf(v.upper) &&
         (joint.type == JointType::kContinuous ||
          (joint.type == JointType::kPlanar && variable == joint.first_variable + 2));
}

/// The whole range of a variable, which `where` calls 'any'. Throws where it has none.
VariableRange anyRange(const Model& model, int variable, const std::string& where,
                       const std::string& file, int line) {
  const robots::Variable& v = model.variables[at(variable)];
  if (turnsWithoutLimits(model, variable)) return {true, -std::numbers::pi, std::numbers::pi, line};
  if (!(std::isfinite(v.lower) && std::isfinite(v.upper)))
    throw InputError(
        file, line,
        fmt::format("{} is 'any', but {} has no limits; a number or a pair [from, to] is expected",
                    where, variableText(model, variable)));
  if (const double most = largestValue(model, variable); !(std::max(-v.lower, v.upper) <= most))
    throw InputError(
        file, line,
        fmt::format("{} is 'any', but the limits of {} are {} to {}, beyond +-{}; a number or a "
                    "pair [from, to] is expected",
                    where, variableText(model, variable), v.lower, v.upper, most));
  return {true, v.lower, v.upper, line};
}

/// Reads one state. Only goals may have ranges.
class StateReader {
 public:
  StateReader(Problem& problem, bool goal)
      : problem_(problem),
        model_(*problem.robot.model),
        goal_(goal),
        variables_(problem.robot.variables) {
    ranges_.resize(model_.variables.size());
  }

  VariableRanges read(const YamlReader& reader) {
    if (reader.isScalar())
      return groupStateRanges(reader.file(), reader.line(), reader.text(), model_, variables_,
                              group_);
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
    const int body = onlyBodyJoint(model_, variables_);
    if (body >= 0 && reader.has("position") && model_.findJoint("position") < 0) {
      readBodyPose(reader, model_.joints[at(body)]);
      return;
    }
    for (const auto& [name, value] : reader.entries()) readEntry(reader, name, value);
  }

  const VariableRanges& ranges() const { return ranges_; }

 private:
  /// The joints of one group alone.
  StateReader(const StateReader& whole, const robots::Group& group)
      : problem_(whole.problem_),
        model_(whole.model_),
        goal_(whole.goal_),
        variables_(group.variables),
        group_(group.name) {
    ranges_.resize(model_.variables.size());
  }

  void readList(const YamlReader& reader) {
    const std::vector<YamlReader> items = reader.items();
    if (items.size() != variables_.size())
      reader.fail(fmt::format("{} is a list of {}; {} values are expected: {}", reader.where(),
                              items.size(), variables_.size(), namesOf(model_, variables_)));
    for (std::size_t i = 0; i < items.size(); ++i) readValue(items[i], variables_[i]);
  }

  /// A state of one group's joints, and of no others.
  void readGroup(const YamlReader& value, const robots::Group& group) {
    StateReader own(*this, group);
    if (goal_ && value.isScalar() && value.text() == "any")
      for (const int v : group.variables) own.readValue(value, v);
    else
      own.ranges_ = own.read(value);
    for (std::size_t i = 0; i < own.ranges_.size(); ++i) {
      const VariableRange& range = own.ranges_[i];
      const auto v = static_cast<int>(i);
      if (!range.given) continue;
      if (std::find(group.variables.begin(), group.variables.end(), v) == group.variables.end())
        throw InputError(value.file(), range.line,
                         fmt::format("{} names {}, which group '{}' does not have; its joints are "
                                     "expected: {}",
                                     value.where(), variableText(model_, v), group.name,
                                     namesOf(model_, group.variables)));
      set(v, range.lower, range.upper, value, range.line);
    }
  }

  void readEntry(const YamlReader& map, const std::string& name, const YamlReader& value) {
    const int variable = model_.findVariable(name);
    if (variable >= 0) return readValue(value, variable);
    const int index = model_.findJoint(name);
    if (const int group = index < 0 ? model_.findGroup(name) : -1; group >= 0)
      return readGroup(value, model_.groups[at(group)]);
    if (index < 0)
      value.fail(fmt::format("unknown joint '{}' in {}{}", name, map.where(),
                             nearJointOrGroup(model_, name)));
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
      return set(joint.first_variable + 2, 0, 0, map);
    }
    const Eigen::Vector4d q = readOrientation(map, problem_.warnings);
    for (int i = 0; i < 4; ++i) set(joint.first_variable + 3 + i, q[i], q[i], map);
  }

  void readValue(const YamlReader& value, int variable) {
    if (goal_ && value.isScalar() && value.text() == "any") {
      const VariableRange range =
          anyRange(model_, variable, value.where(), value.file(), value.line());
      return set(variable, range.lower, range.upper, value);
    }
    if (goal_ && value.isList()) {
      const std::vector<double> range = value.numbers();
      if (range.size() != 2 || !(range[0] <= range[1]))
        value.fail(
            fmt::format("{} is no range; [from, to] with from <= to is expected", value.where()));
      return set(variable, range[0], range[1], value);
    }
    const double number = value.number();
    set(variable, number, number, value);
  }

  /// `line`: 0 for a group state's values.
  void set(int variable, double lower, double upper, const YamlReader& value, int line) {
    VariableRange& range = ranges_[at(variable)];
    if (range.given)
      value.fail(fmt::format("{} gives {} again, which has a value already; one is expected",
                             value.where(), variableText(model_, variable)));
    range = {true, lower, upper, line};
  }
  void set(int variable, double lower, double upper, const YamlReader& value) {
    set(variable, lower, upper, value, value.line());
  }

  Problem& problem_;
  const Model& model_;
  bool goal_;
  std::span<const int> variables_;  // those that a list gives
  std::string group_;               // whose they are; empty: the planned ones
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

/// Sets the values of problem.start that are given. Throws for one outside the problem's bounds,
/// and warns of one outside the robot's own.
void takeValues(const std::string& file, int line, const std::string& what,
                const VariableRanges& given, Problem& problem) {
  for (std::size_t v = 0; v < given.size(); ++v) {
    if (!given[v].given) continue;
    if (const auto fault = boundsFault(*problem.robot.model, static_cast<int>(v), given[v].lower))
      throw InputError(file, given[v].line > 0 ? given[v].line : line, what + " has " + *fault);
    problem.start[v] = given[v].lower;
    if (const auto off = passiveWarning(problem, static_cast<int>(v)); off && !file.empty())
      problem.warnings.push_back(fmt::format("{}:{}: {} has {}", file,
                                             given[v].line > 0 ? given[v].line : line, what, *off));
  }
}

}  // namespace

std::vector<std::string> groupNames(const Model& model) {
  std::vector<std::string> names;
  for (const robots::Group& group : model.groups) names.push_back(group.name);
  return names;
}

std::vector<std::string> namedGroups(const Model& model, const std::string& text) {
  if (robots::isGroup(model, text)) return {text};
  std::vector<std::string> names;
  for (const std::string_view name : cellsBetween(text, ',')) names.emplace_back(name);
  return names;
}

void takeGroups(const std::string& file, int line, std::span<const std::string> names,
                Problem& problem) {
  const Model& model = *problem.robot.model;
  for (const std::string& name : names)
    if (!robots::isGroup(model, name)) {
      std::vector<std::string> known = groupNames(model);
      // A joint is suggested for what is nearly its name only where no group is.
      const std::vector<std::string> joints = jointNames(model);
      if (known.size() < 2) known.insert(known.end(), joints.begin(), joints.end());
      throw InputError(file, line,
                       fmt::format("robot '{}' has no group or joint '{}'{}", model.name, name,
                                   didYouMean(model, "group", name, known)));
    }
  if (const std::string fault = robots::groupsFault(model, names); !fault.empty())
    throw InputError(file, line, fault);
  problem.robot.variables = robots::variablesOf(model, names);
}

void takeChain(const std::string& file, int line, const std::string& base, const std::string& tip,
               Problem& problem) {
  const Model& model = *problem.robot.model;
  const auto linkOf = [&](const std::string& name) {
    const int link = model.findLink(name);
    if (link >= 0) return link;
    std::vector<std::string> known;
    for (const robots::Link& other : model.links) known.push_back(other.name);
    throw InputError(file, line,
                     fmt::format("chain: robot '{}' has no link '{}'{}", model.name, name,
                                 didYouMean(name, known)));
  };
  problem.robot.variables = robots::chainVariables(model, linkOf(base), linkOf(tip));
  if (problem.robot.variables.empty())
    throw InputError(file, line,
                     fmt::format("chain: no joint between '{}' and '{}' can move by itself; two "
                                 "links with such a joint between them are expected",
                                 base, tip));
}

void takeStart(const std::string& file, int line, const VariableRanges& given, Problem& problem) {
  checkPlanned(file, line, "start", given, problem);
  takeValues(file, line, "start", given, problem);
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

namespace {

/// The words between commas and blanks.
struct StatedWords {
  std::vector<double> numbers;  ///< those that are finite numbers
  std::size_t count = 0;
  std::size_t empty = 0;  ///< the number of the first empty value, from 1; 0: none

  bool areNumbers() const { return count > 0 && numbers.size() == count; }
};

StatedWords statedWords(const std::string& text) {
  StatedWords read;
  std::istringstream parts(text + ',');  // a last comma has an empty value after it
  for (std::string part; std::getline(parts, part, ',');) {
    std::istringstream words(part);
    const std::size_t before = read.count;
    for (std::string word; words >> word; ++read.count)
      if (const auto value = robots::parseFinite(word)) read.numbers.push_back(*value);
    if (read.count == before && read.empty == 0) read.empty = read.count + 1;
  }
  return read;
}

/// A group state, or a value of each of `variables`; `group` as for groupStateRanges().
VariableRanges statedRanges(const std::string& what, const std::string& text, const Model& model,
                            std::span<const int> variables, const std::string& group = {}) {
  const StatedWords words = statedWords(text);
  if (!words.areNumbers())
    return groupStateRanges("", 0, std::string(withoutBlanks(text)), model, variables, group);
  if (words.empty > 0)
    throw InputError(
        "", 0,
        fmt::format("value {} of {} '{}' is empty; {} numbers are expected, of {}", words.empty,
                    what, text, variables.size(), namesOf(model, variables)));
  const std::vector<double>& values = words.numbers;
  if (values.size() != variables.size())
    throw InputError("", 0,
                     fmt::format("{} '{}' is {} numbers; {} are expected, of {}", what, text,
                                 values.size(), variables.size(), namesOf(model, variables)));
  VariableRanges ranges(model.variables.size());
  for (std::size_t i = 0; i < variables.size(); ++i)
    ranges[at(variables[i])] = {true, values[i], values[i], 0};
  return ranges;
}

}  // namespace

bool namesState(const std::string& text) {
  return text.find('=') == std::string::npos && !statedWords(text).areNumbers();
}

VariableRanges statedRanges(const std::string& what, const std::string& text,
                            const Problem& problem) {
  const Model& model = *problem.robot.model;
  if (text.find('=') == std::string::npos)
    return statedRanges(what, text, model, problem.robot.variables);
  VariableRanges ranges(model.variables.size());
  // GROUP=STATE, JOINT=VALUE: what is before a '=' begins after the last comma or blank.
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t equals = text.find('=', begin);
    const std::size_t next = text.find('=', equals + 1);
    std::size_t end = next == std::string::npos ? text.size() : text.find_last_of(", ", next) + 1;
    if (end <= equals) end = text.size();
    const std::string name(withoutBlanks(std::string_view(text).substr(begin, equals - begin)));
    const int group = model.findGroup(name);
    const int variable = group < 0 ? model.findVariable(name) : -1;
    if (group < 0 && variable < 0)
      throw InputError("", 0,
                       fmt::format("{} '{}' names '{}', which is not a group or joint{}", what,
                                   text, name, nearJointOrGroup(model, name)));
    std::string state = text.substr(equals + 1, end - equals - 1);
    state.erase(state.find_last_not_of(", ") + 1);
    const std::vector<int> of =
        group >= 0 ? model.groups[at(group)].variables : std::vector{variable};
    VariableRanges own(model.variables.size());
    const auto isAny = [&](const robots::GroupState& known) {
      return known.name == state && group >= 0 && known.group == name;
    };
    const bool is_state = std::any_of(model.group_states.begin(), model.group_states.end(), isAny);
    if (what == "goal" && state == "any" && !is_state)
      for (const int v : of) own[at(v)] = anyRange(model, v, what + " of " + name, "", 0);
    else
      own = statedRanges(what + " of " + name, state, model, of, group >= 0 ? name : "");
    for (std::size_t v = 0; v < own.size(); ++v) {
      if (!own[v].given) continue;
      if (ranges[v].given)
        throw InputError("", 0,
                         fmt::format("{} '{}' gives {} twice; once is expected", what, text,
                                     variableText(model, static_cast<int>(v))));
      ranges[v] = own[v];
    }
    begin = end;
  }
  return ranges;
}

void warnOfOthers(const std::string& state, const std::string& where, Problem& problem) {
  const std::string others =
      robots::otherValues(*problem.robot.model, state, problem.robot.variables, problem.start);
  if (!others.empty()) problem.warnings.push_back(where + ": " + others);
}

namespace {

void warnOfOthers(const YamlReader& reader, Problem& problem) {
  if (!reader.isScalar()) return;
  warnOfOthers(reader.text(),
               fmt::format("{}:{}: {}", reader.file(), reader.line(), reader.where()), problem);
}

}  // namespace

void readStart(const YamlReader& reader, const VariableRanges& passive, Problem& problem) {
  if (givesPoses(reader, *problem.robot.model)) {
    problem.start_poses = readPoseRegions(reader, problem);
    return;
  }
  const VariableRanges given = StateReader(problem, false).read(reader);
  for (std::size_t v = 0; v < passive.size(); ++v)
    if (passive[v].given && given[v].given)
      throw InputError(reader.file(), given[v].line > 0 ? given[v].line : reader.line(),
                       fmt::format("start gives {}, which has a value under 'joints'; one of them "
                                   "is expected",
                                   variableText(*problem.robot.model, static_cast<int>(v))));
  takeStart(reader.file(), reader.line(), given, problem);
  warnOfOthers(reader, problem);
}

Goal readGoal(const YamlReader& reader, const std::string& name, Problem& problem) {
  if (givesPoses(reader, *problem.robot.model)) return {name, {}, readPoseRegions(reader, problem)};
  const VariableRanges given = StateReader(problem, true).read(reader);
  warnOfOthers(reader, problem);
  return takeGoal(reader.file(), reader.line(), reader.isScalar() ? reader.text() : name, given,
                  problem);
}

namespace {

/// Takes the values of the joints that are not planned from a state: `joints: open`.
VariableRanges takePassiveState(const YamlReader& reader, Problem& problem) {
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
  VariableRanges given(model.variables.size());
  for (const auto& [v, value] : found[0].values) given[at(v)] = {true, value, value, 0};
  takeValues(reader.file(), reader.line(), fmt::format("group state '{}'", name), given, problem);
  return given;
}

}  // namespace

VariableRanges readPassiveJoints(const YamlReader& reader, Problem& problem) {
  if (reader.isScalar()) return takePassiveState(reader, problem);
  StateReader states(problem, false);
  for (const auto& [name, value] : reader.entries())
    if (const int v = problem.robot.model->findVariable(name); v >= 0 && planned(problem, v))
      value.fail(fmt::format("{} is planned; its value belongs under 'start'",
                             variableText(*problem.robot.model, v)));
  states.readMap(reader);
  takeValues(reader.file(), reader.line(), reader.where(), states.ranges(), problem);
  return states.ranges();
}

}  // namespace leeway::planner
