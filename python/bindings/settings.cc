#include "python/bindings/settings.h"

#include <algorithm>
#include <cmath>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/robots/text.h"
#include "python/base/define.h"
#include "python/base/released.h"

namespace leeway::python {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

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

py::dict dictOf(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  if (!py::isinstance<py::dict>(value))
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a dict is expected");
  return py::reinterpret_borrow<py::dict>(value);
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

void setFrames(planner::Problem& problem, const py::object& value) {
  std::vector<planner::Frame> frames;
  for (const auto& [key, entry] : dictOf(value, "frames")) {
    const std::string name = py::str(key);
    const auto named = [&](const auto& thing) { return thing.name == name; };
    const auto& held = problem.robot.attachments;
    if (problem.robot.model->findLink(name) >= 0 || hasObject(problem.world, name) ||
        std::any_of(held.begin(), held.end(), [&](const auto& a) { return named(a.object); }))
      throw py::value_error("frame '" + name +
                            "' has the name of a link or object; a name of its own is expected");
    if (!py::isinstance<py::tuple>(entry) || py::len(entry) != 2)
      throw py::type_error("frame '" + name + "' is " + shown(entry) +
                           "; (link, pose) is expected");
    const auto pair = py::reinterpret_borrow<py::tuple>(entry);
    const std::string link_name = py::str(pair[0]);
    const int link = problem.robot.model->findLink(link_name);
    if (link < 0) throw py::value_error("frame '" + name + "': no link '" + link_name + "'");
    frames.push_back({name, link, pose(pair[1], "a frame's pose")});
  }
  problem.robot.frames = std::move(frames);
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
    {"world", "The world, as a copy: set it to change it.",
     [](const P& p) { return py::cast(World{p.world}); },
     [](P& p, V v) {
       if (!py::isinstance<World>(v)) throw py::type_error("world is no World");
       p.world = v.cast<const World&>().value;
     }},
    {"frames", "Frames fixed to links, for poses: {name: (link, pose)}, see FramePose.",
     [](const P& p) {
       py::dict frames;
       for (const planner::Frame& f : p.robot.frames)
         frames[py::str(f.name)] =
             py::make_tuple(p.robot.model->links[at(f.link)].name, matrix(f.X_LF));
       return py::object(frames);
     },
     setFrames},
    {"others", "Values of all joints at the start, those not planned included: {joint: value}.",
     [](const P& p) {
       py::dict values;
       for (std::size_t i = 0; i < p.start.size(); ++i)
         values[py::str(p.robot.model->variables[i].name)] = p.start[i];
       return py::object(values);
     },
     [](P& p, V v) { setStart(p, dictOf(v, "others")); }},
    {"start",
     "The planned joints' values at the start: (joints,) [rad or m]. Poses become such values: the "
     "valid ones that are nearest to what the start was.",
     [](const P& p) {
       const std::vector<double> point = startPoint(p);
       return py::object(array(std::span<const double>(point)));
     },
     setStart},
    {"goal",
     "The first goal: ranges (joints, 2), or a list of FramePoses. Setting it replaces all goals.",
     [](const P& p) {
       return p.goals.empty() ? py::object(py::none()) : goalObject(p, p.goals.front());
     },
     [](P& p, V v) { setGoals(p, v, false); }},
    {"goals", "The goals, each as ranges (joints, 2) or FramePoses; reaching any one will do.",
     [](const P& p) {
       py::list goals;
       for (const planner::Goal& goal : p.goals) goals.append(goalObject(p, goal));
       return py::object(goals);
     },
     [](P& p, V v) { setGoals(p, v, true); }},
    {"steps", "A task in place of goals: TaskSteps, one after the other.", stepList, setSteps},
    {"margin", "All pairs stay farther apart than this [m].",
     [](const P& p) { return py::object(py::float_(p.margins.common)); },
     [](P& p, V v) { p.margins.common = number(v, "margin"); }},
    {"margins",
     "Pairs with a margin of their own: {(a, b): margin} [m]; a and b are names, tuples of names, "
     "or "
     "'robot'. Of entries that name the same pair the last holds.",
     [](const P& p) {
       py::dict margins;
       for (const planner::PairMargin& m : p.margins.pairs)
         margins[py::make_tuple(m.a, m.b)] = m.margin;
       return py::object(margins);
     },
     [](P& p, V v) {
       std::vector<planner::PairMargin> pairs;
       for (const auto& [key, value] : dictOf(v, "margins")) {
         const double margin = number(value, "margins");
         for (const auto& [a, b] : namePairs(p, key, "margins")) pairs.push_back({a, b, margin});
       }
       p.margins.pairs = std::move(pairs);
     }},
    {"allowed", "Pairs (a, b) that may touch, besides those of the SRDF; as in `margins`.",
     [](const P& p) {
       py::list pairs;
       for (const auto& [a, b] : p.contacts.allowed) pairs.append(py::make_tuple(a, b));
       return py::object(pairs);
     },
     [](P& p, V v) {
       std::vector<std::pair<std::string, std::string>> pairs;
       if (!v.is_none())
         for (const py::handle item : py::list(v))
           for (auto& names : namePairs(p, item, "allowed")) pairs.push_back(std::move(names));
       p.contacts.allowed = std::move(pairs);
     }},
    {"objective", "'length', or 'clearance': the least clearance as large as possible.",
     [](const P& p) { return py::object(py::str(toString(p.objective))); },
     [](P& p, V v) {
       const auto objective = planner::objectiveOfName(word(v, "objective"));
       if (!objective) unknownWord("objective", word(v, "objective"), "'length' or 'clearance'");
       // What is asked besides stays where the objective does.
       if (objective->index() != p.objective.index()) p.objective = *objective;
     }},
    {"keep",
     "With the objective 'length': pairs with the world keep this, besides the margins [m].",
     [](const P& p) {
       const auto* length = std::get_if<planner::MinimumLength>(&p.objective);
       return length == nullptr || std::isinf(length->clearance)
                  ? py::object(py::none())
                  : py::object(py::float_(length->clearance));
     },
     [](P& p, V v) {
       planner::MinimumLength minimum;
       if (!v.is_none()) {
         minimum.clearance = notNegative(v, "keep");
         if (!std::holds_alternative<planner::MinimumLength>(p.objective))
           throw py::value_error(
               "keep stands beside the objective 'clearance'; 'length' is expected");
       }
       if (std::holds_alternative<planner::MinimumLength>(p.objective)) p.objective = minimum;
     }},
    {"clearance_of",
     "With the objective 'clearance': of 'world', the others keep their margins, or "
     "'all'.",
     [](const P& p) {
       const auto* clearance = std::get_if<planner::MaximumClearance>(&p.objective);
       return clearance == nullptr
                  ? py::object(py::none())
                  : py::object(py::str(clearance->of == planner::Pairs::kAll ? "all" : "world"));
     },
     [](P& p, V v) {
       if (v.is_none()) return;
       const std::string of = word(v, "clearance_of");
       if (of != "world" && of != "all") unknownWord("clearance_of", of, "'world' or 'all'");
       auto* clearance = std::get_if<planner::MaximumClearance>(&p.objective);
       if (clearance == nullptr)
         throw py::value_error(
             "clearance_of stands beside the objective 'length'; 'clearance' is expected");
       clearance->of = of == "all" ? planner::Pairs::kAll : planner::Pairs::kWorld;
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
    {"push", "Whether a simplified path is pushed off what it hugs, for 3 % of its length at most.",
     [](const P& p) { return py::object(py::bool_(p.planner.push)); },
     [](P& p, V v) { p.planner.push = py::bool_(v); }},
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

bool isSetting(const std::string& name) { return findSetting(name) != nullptr; }

namespace {

/// A start that is given by poses becomes joint values. Where none are valid, the nearest are
/// taken, and who plans is told what is in the way.
void placeStart(planner::Problem& problem) {
  if (problem.start_poses.empty()) return;
  problem = released([&] { return planner::placeStart(problem); });
}

}  // namespace

void applySettings(planner::Problem& problem, const py::dict& settings) {
  const auto given = [&](const char* name) {
    return settings.contains(name) && !py::object(settings[name]).is_none();
  };
  if (given("steps") && (given("goal") || given("goals")))
    throw py::value_error("steps are given beside a goal; one of them is expected");
  // In the table's order: a planner before its parameters, frames before poses.
  for (const Setting& setting : kSettings)
    if (settings.contains(setting.name))
      setting.set(problem, py::reinterpret_borrow<py::object>(settings[setting.name]));
  placeStart(problem);
}

std::string shown(py::handle value) {
  std::string text_of = std::string(py::repr(value)).substr(0, 100);
  std::replace(text_of.begin(), text_of.end(), '\n', ' ');
  return text_of;
}

void defineSettings(py::class_<Problem>& problem) {
  for (const Setting& setting : kSettings)
    defineProperty(
        problem, setting.name, setting.doc,
        [get = setting.get](const Problem& self) { return get(*self.value); },
        [&setting](Problem& self, const py::object& value) {
          planner::Problem changed = *self.value;
          setting.set(changed, value);
          placeStart(changed);
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
