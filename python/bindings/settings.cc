#include "python/bindings/settings.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "leeway/planner/planners.h"
#include "leeway/robots/text.h"
#include "python/base/define.h"

namespace leeway::python {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A wrong value, in one line.
std::string shown(py::handle value) {
  std::string text_of = std::string(py::repr(value)).substr(0, 100);
  std::replace(text_of.begin(), text_of.end(), '\n', ' ');
  return text_of;
}

std::string word(const py::object& value, const char* name) {
  if (!py::isinstance<py::str>(value))
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a word is expected");
  return value.cast<std::string>();
}

std::int64_t whole(const py::object& value, const char* name) {
  const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  const long long result = index ? PyLong_AsLongLong(index.ptr()) : -1;
  if (!index || PyErr_Occurred() != nullptr || result < 0) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + " is " + shown(value) +
                          "; a whole number of at least 0 is expected");
  }
  return result;
}

double notNegative(const py::object& value, const char* name) {
  const double given = number(value, name);
  if (given < 0)
    throw py::value_error(std::string(name) + " is " + text(given) + "; at least 0 is expected");
  return given;
}

double positive(const py::object& value, const char* name) {
  const double given = number(value, name);
  if (!(given > 0))
    throw py::value_error(std::string(name) + " is " + text(given) +
                          "; a positive number is expected");
  return given;
}

/// Pairs of names: a list of (a, b).
std::pair<std::string, std::string> namePair(const py::handle item, const char* name) {
  if (py::isinstance<py::tuple>(item) || py::isinstance<py::list>(item)) {
    const auto pair = py::reinterpret_borrow<py::sequence>(item);
    if (py::len(pair) == 2 && py::isinstance<py::str>(pair[0]) && py::isinstance<py::str>(pair[1]))
      return {pair[0].cast<std::string>(), pair[1].cast<std::string>()};
  }
  throw py::type_error(std::string(name) + " holds " + shown(item) +
                       "; pairs (a, b) of names are expected");
}

py::dict dictOf(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  if (!py::isinstance<py::dict>(value))
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a dict is expected");
  return py::reinterpret_borrow<py::dict>(value);
}

int variableOf(const planner::Problem& problem, const std::string& name) {
  const int variable = problem.robot.model->findVariable(name);
  if (variable >= 0) return variable;
  std::vector<std::string> known;
  for (const robots::Variable& v : problem.robot.model->variables) known.push_back(v.name);
  const std::string* const near = robots::nearestName(name, known);
  throw py::value_error("no joint '" + name + "'" +
                        (near != nullptr ? "; did you mean '" + *near + "'?" : ""));
}

std::size_t count(const planner::Problem& problem) { return problem.robot.variables.size(); }

// ---- Goals.

using Range = std::pair<double, double>;

Range rangeOf(const planner::Problem& problem, int variable, const py::handle& value) {
  const robots::Variable& v = problem.robot.model->variables[at(variable)];
  if (py::isinstance<py::str>(value)) {
    if (value.cast<std::string>() != "any")
      unknownWord("goal", value.cast<std::string>(), "a number, (from, to) or 'any'");
    if (std::isfinite(v.lower) && std::isfinite(v.upper)) return {v.lower, v.upper};
    const robots::Joint& joint = problem.robot.model->joints[at(v.joint)];
    const bool turns =
        joint.type == robots::JointType::kContinuous ||
        (joint.type == robots::JointType::kPlanar && variable == joint.first_variable + 2);
    if (turns) return {-std::numbers::pi, std::numbers::pi};
    throw py::value_error("goal: joint '" + v.name + "' is 'any', but has no limits");
  }
  if (py::isinstance<py::tuple>(value) || py::isinstance<py::list>(value)) {
    const std::vector<double> range = numbers(value, ("goal of " + v.name).c_str(), 2);
    if (range[0] > range[1])
      throw py::value_error("goal of " + v.name + " is from " + text(range[0]) + " to " +
                            text(range[1]) + "; from <= to is expected");
    return {range[0], range[1]};
  }
  const double given = number(value, ("goal of " + v.name).c_str());
  return {given, given};
}

planner::Goal goalOf(const planner::Problem& problem, const py::object& goal) {
  planner::Goal result;
  result.name = "goal";
  if (py::isinstance<py::str>(goal)) {
    result.name = goal.cast<std::string>();
    const Robot robot(problem.robot.model, problem.robot.variables);
    const auto point = py::cast(robot).attr("state")(goal).cast<std::vector<double>>();
    for (const double value : point) result.ranges.emplace_back(value, value);
    return result;
  }
  if (py::isinstance<py::dict>(goal)) {
    std::unordered_map<int, Range> given;
    for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(goal)) {
      const int variable = variableOf(problem, py::str(name));
      given[variable] = rangeOf(problem, variable, value);
    }
    for (const int variable : problem.robot.variables) {
      const auto found = given.find(variable);
      if (found == given.end())
        throw py::value_error("goal says nothing of joint '" +
                              problem.robot.model->variables[at(variable)].name + "'");
      result.ranges.push_back(found->second);
    }
    return result;
  }
  // A list of numbers, ranges and words; else an array.
  if (py::isinstance<py::list>(goal) || py::isinstance<py::tuple>(goal)) {
    const auto list = py::reinterpret_borrow<py::sequence>(goal);
    if (py::len(list) != count(problem))
      throw py::value_error("goal holds " + std::to_string(py::len(list)) + " values; " +
                            std::to_string(count(problem)) + " are expected");
    for (std::size_t i = 0; i < count(problem); ++i)
      result.ranges.push_back(rangeOf(problem, problem.robot.variables[i], list[i]));
    return result;
  }
  for (const double value : numbers(goal, "goal", count(problem)))
    result.ranges.emplace_back(value, value);
  return result;
}

py::object getGoals(const planner::Problem& problem) {
  py::list goals;
  for (const planner::Goal& goal : problem.goals) {
    std::vector<double> values;
    for (const auto& [lower, upper] : goal.ranges) values.insert(values.end(), {lower, upper});
    goals.append(array(std::move(values), {static_cast<py::ssize_t>(goal.ranges.size()), 2}));
  }
  return goals;
}

// ---- Maps by joint.

py::object getByJoint(const std::map<std::string, double>& values) { return py::cast(values); }

std::map<std::string, double> byJoint(const planner::Problem& problem, const py::object& value,
                                      const char* name) {
  std::map<std::string, double> result;
  if (value.is_none()) return result;
  if (!py::isinstance<py::dict>(value)) {
    const double all = positive(value, name);
    for (const int variable : problem.robot.variables)
      result[problem.robot.model->variables[at(variable)].name] = all;
    return result;
  }
  for (const auto& [joint, limit] : py::reinterpret_borrow<py::dict>(value)) {
    const int variable = variableOf(problem, py::str(joint));
    result[problem.robot.model->variables[at(variable)].name] =
        positive(py::reinterpret_borrow<py::object>(limit), name);
  }
  return result;
}

// ---- The table.

struct Setting {
  const char* name;
  const char* doc;
  py::object (*get)(const planner::Problem&);
  void (*set)(planner::Problem&, const py::object&);
};

using P = planner::Problem;
using V = const py::object&;

const Setting kSettings[] = {
    {"name", "The problem's name, for messages.",
     [](const P& p) { return py::object(py::str(p.name)); },
     [](P& p, V v) { p.name = word(v, "name"); }},
    {"start", "The planned joints' values at the start: (joints,) [rad or m].",
     [](const P& p) {
       const std::vector<double> point = startPoint(p);
       return py::object(array(std::span<const double>(point)));
     },
     setStart},
    {"others", "Values of all joints at the start, those not planned included: {joint: value}.",
     [](const P& p) {
       py::dict values;
       for (std::size_t i = 0; i < p.start.size(); ++i)
         values[py::str(p.robot.model->variables[i].name)] = p.start[i];
       return py::object(values);
     },
     [](P& p, V v) { setStart(p, dictOf(v, "others")); }},
    {"goal", "The first goal: ranges (joints, 2). Setting it replaces all goals.",
     [](const P& p) {
       return p.goals.empty() ? py::object(py::none()) : py::object(py::list(getGoals(p))[0]);
     },
     [](P& p, V v) { setGoals(p, v, false); }},
    {"goals", "The goals, each as ranges (joints, 2); reaching any one of them will do.", getGoals,
     [](P& p, V v) { setGoals(p, v, true); }},
    {"world", "The world, as a copy: set it to change it.",
     [](const P& p) { return py::cast(World{p.world}); },
     [](P& p, V v) {
       if (!py::isinstance<World>(v)) throw py::type_error("world is no World");
       p.world = v.cast<const World&>().value;
     }},
    {"margin", "All pairs stay farther apart than this [m].",
     [](const P& p) { return py::object(py::float_(p.margins.common)); },
     [](P& p, V v) { p.margins.common = number(v, "margin"); }},
    {"margins", "Pairs with a margin of their own: {(a, b): margin} [m].",
     [](const P& p) {
       py::dict margins;
       for (const planner::PairMargin& m : p.margins.pairs)
         margins[py::make_tuple(m.a, m.b)] = m.margin;
       return py::object(margins);
     },
     [](P& p, V v) {
       std::vector<planner::PairMargin> pairs;
       for (const auto& [key, value] : dictOf(v, "margins")) {
         const auto [a, b] = namePair(key, "margins");
         pairs.push_back({a, b, number(value, "margins")});
       }
       p.margins.pairs = std::move(pairs);
     }},
    {"allowed", "Pairs (a, b) that may touch, besides those of the SRDF.",
     [](const P& p) {
       py::list pairs;
       for (const auto& [a, b] : p.contacts.allowed) pairs.append(py::make_tuple(a, b));
       return py::object(pairs);
     },
     [](P& p, V v) {
       std::vector<std::pair<std::string, std::string>> pairs;
       if (!v.is_none())
         for (const py::handle item : py::list(v)) pairs.push_back(namePair(item, "allowed"));
       p.contacts.allowed = std::move(pairs);
     }},
    {"objective", "'length', or 'clearance': the least clearance as large as possible.",
     [](const P& p) { return py::object(py::str(toString(p.objective))); },
     [](P& p, V v) {
       const auto objective = planner::objectiveOfName(word(v, "objective"));
       if (!objective) unknownWord("objective", word(v, "objective"), "'length' or 'clearance'");
       p.objective = *objective;
     }},
    {"planner", "Name of the planner, see planners().",
     [](const P& p) { return py::object(py::str(p.planner.name)); },
     [](P& p, V v) {
       if (const auto error = planner::plannerError(word(v, "planner"), {}))
         throw py::value_error(*error);
       p.planner.name = word(v, "planner");
     }},
    {"parameters", "Parameters of the planner, by its names, as text.",
     [](const P& p) { return py::cast(p.planner.parameters); },
     [](P& p, V v) {
       std::map<std::string, std::string> parameters;
       for (const auto& [key, value] : dictOf(v, "parameters"))
         parameters[py::str(key)] = py::str(value);
       if (const auto error = planner::plannerError(p.planner.name, parameters))
         throw py::value_error(*error);
       p.planner.parameters = std::move(parameters);
     }},
    {"simplify", "Whether the path that is found is shortened.",
     [](const P& p) { return py::object(py::bool_(p.planner.simplify)); },
     [](P& p, V v) { p.planner.simplify = py::bool_(v); }},
    {"time", "Planning and simplification end after this [s].",
     [](const P& p) { return py::object(py::float_(p.limits.time)); },
     [](P& p, V v) { p.limits.time = positive(v, "time"); }},
    {"iterations", "The planner ends after so many iterations; 0: no limit.",
     [](const P& p) { return py::object(py::int_(p.limits.iterations)); },
     [](P& p, V v) { p.limits.iterations = whole(v, "iterations"); }},
    {"seed", "The same seed gives the same bytes.",
     [](const P& p) { return py::object(py::int_(p.seed)); },
     [](P& p, V v) { p.seed = static_cast<std::uint64_t>(whole(v, "seed")); }},
    {"start_time", "Time of the obstacles' motions at which execution begins [s].",
     [](const P& p) { return py::object(py::float_(p.execution.start)); },
     [](P& p, V v) { p.execution.start = number(v, "start_time"); }},
    {"step", "From one look at the world to the next, in execution [s].",
     [](const P& p) { return py::object(py::float_(p.execution.step)); },
     [](P& p, V v) { p.execution.step = positive(v, "step"); }},
    {"duration", "An execution that has not reached the goal within this fails [s].",
     [](const P& p) { return py::object(py::float_(p.execution.duration)); },
     [](P& p, V v) { p.execution.duration = positive(v, "duration"); }},
    {"speed", "Share of the velocity limits that is used, in (0, 1].",
     [](const P& p) { return py::object(py::float_(p.execution.speed)); },
     [](P& p, V v) {
       if (positive(v, "speed") > 1) throw py::value_error("speed is above 1; (0, 1] is expected");
       p.execution.speed = number(v, "speed");
     }},
    {"velocities", "Velocity limits: {joint: limit}, or one number for all [rad/s or m/s].",
     [](const P& p) { return getByJoint(p.execution.velocities); },
     [](P& p, V v) { p.execution.velocities = byJoint(p, v, "velocities"); }},
    {"accelerations", "Acceleration limits: {joint: limit}, or one number [rad/s^2 or m/s^2].",
     [](const P& p) { return getByJoint(p.execution.accelerations); },
     [](P& p, V v) { p.execution.accelerations = byJoint(p, v, "accelerations"); }},
    {"jerks", "Jerk limits: {joint: limit}, or one number [rad/s^3 or m/s^3]; default: none.",
     [](const P& p) { return getByJoint(p.execution.jerks); },
     [](P& p, V v) { p.execution.jerks = byJoint(p, v, "jerks"); }},
    {"corners", "'stop', or 'blend': corners are cut where the cut is proven to keep the margins.",
     [](const P& p) {
       return py::object(
           py::str(p.execution.corners == planner::Corners::kBlend ? "blend" : "stop"));
     },
     [](P& p, V v) {
       const std::string name = word(v, "corners");
       if (name != "stop" && name != "blend") unknownWord("corners", name, "'stop' or 'blend'");
       p.execution.corners = name == "blend" ? planner::Corners::kBlend : planner::Corners::kStop;
     }},
    {"foresight", "'motion': the obstacles' motion is known; 'speed_bound': only a bound on it.",
     [](const P& p) {
       return py::object(py::str(
           p.execution.foresight == planner::Foresight::kMotion ? "motion" : "speed_bound"));
     },
     [](P& p, V v) {
       const std::string name = word(v, "foresight");
       if (name != "motion" && name != "speed_bound")
         unknownWord("foresight", name, "'motion' or 'speed_bound'");
       p.execution.foresight =
           name == "motion" ? planner::Foresight::kMotion : planner::Foresight::kSpeedBound;
     }},
    {"look_ahead", "After each step so much more should be certified [s].",
     [](const P& p) { return py::object(py::float_(p.execution.look_ahead)); },
     [](P& p, V v) { p.execution.look_ahead = notNegative(v, "look_ahead"); }},
    {"buffer", "Paths keep this besides the margin from what deforms, where they can [m].",
     [](const P& p) { return py::object(py::float_(p.execution.buffer)); },
     [](P& p, V v) { p.execution.buffer = notNegative(v, "buffer"); }},
    {"patience", "How long to wait for a valid path before planning another [s].",
     [](const P& p) { return py::object(py::float_(p.execution.patience)); },
     [](P& p, V v) { p.execution.patience = notNegative(v, "patience"); }},
};

const Setting* findSetting(const std::string& name) {
  const auto* const found = std::find_if(std::begin(kSettings), std::end(kSettings),
                                         [&](const Setting& s) { return name == s.name; });
  return found == std::end(kSettings) ? nullptr : found;
}

}  // namespace

void setStart(planner::Problem& problem, const py::object& start) {
  if (start.is_none()) return;
  std::vector<double> q = problem.start;
  if (py::isinstance<py::dict>(start)) {
    for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(start)) {
      const std::string joint = py::str(name);
      q[at(variableOf(problem, joint))] = number(value, ("start of " + joint).c_str());
    }
  } else {
    const Robot robot(problem.robot.model, problem.robot.variables);
    const std::vector<double> point =
        py::isinstance<py::str>(start)
            ? py::cast(robot).attr("state")(start).cast<std::vector<double>>()
            : numbers(start, "start", count(problem));
    robot.expand(point, q);
  }
  problem.start = std::move(q);
}

void setGoals(planner::Problem& problem, const py::object& goal, bool several) {
  std::vector<planner::Goal> goals;
  if (goal.is_none()) {
    // None yet: plan() will ask for one.
  } else if (several) {
    for (const py::handle item : py::list(goal))
      goals.push_back(goalOf(problem, py::reinterpret_borrow<py::object>(item)));
    if (goals.empty()) throw py::value_error("goals are empty; at least one is expected");
    for (std::size_t i = 1; i < goals.size(); ++i)
      if (goals[i].name == "goal") goals[i].name += " " + std::to_string(i + 1);
  } else {
    goals.push_back(goalOf(problem, goal));
  }
  problem.goals = std::move(goals);
}

bool isSetting(const std::string& name) { return findSetting(name) != nullptr; }

void applySettings(planner::Problem& problem, const py::dict& settings) {
  // In the table's order: a planner before its parameters.
  for (const Setting& setting : kSettings)
    if (settings.contains(setting.name))
      setting.set(problem, py::reinterpret_borrow<py::object>(settings[setting.name]));
}

void defineSettings(py::class_<Problem>& problem) {
  for (const Setting& setting : kSettings)
    defineProperty(
        problem, setting.name, setting.doc,
        [get = setting.get](const Problem& self) { return get(*self.value); },
        [&setting](Problem& self, const py::object& value) {
          planner::Problem changed = *self.value;
          setting.set(changed, value);
          self.change() = std::move(changed);
        });
}

void noMore(const char* call, const py::dict& keywords) {
  for (const auto& [key, value] : keywords) {
    std::vector<std::string> known;
    for (const Setting& setting : kSettings) known.emplace_back(setting.name);
    const std::string name = py::str(key);
    const std::string* const near = robots::nearestName(name, known);
    throw py::type_error(std::string(call) + "(): unknown keyword '" + name + "'" +
                         (near != nullptr ? "; did you mean '" + *near + "'?" : ""));
  }
}

}  // namespace leeway::python
