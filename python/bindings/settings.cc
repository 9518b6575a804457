#include "python/bindings/settings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/robots/text.h"
#include "python/base/at.h"
#include "python/base/define.h"
#include "python/base/released.h"

namespace leeway::python {

struct Setting {
  const char* name;
  const char* doc;
  py::object (*get)(const planner::Problem&);
  void (*set)(planner::Problem&, const py::object&);
};

namespace {

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

py::dict dictOf(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  if (!py::isinstance<py::dict>(value) && Py_TYPE(value.ptr()) != &PyDictProxy_Type)
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a dict is expected");
  return py::dict(value);
}

// ---- Maps by joint.

py::object getByJoint(const std::map<std::string, double>& values) { return py::cast(values); }

std::map<std::string, double> byJoint(const planner::Problem& problem, const py::object& value,
                                      const char* name) {
  std::map<std::string, double> result;
  if (value.is_none()) return result;
  if (!py::isinstance<py::dict>(value)) {
    const double all = number(value, name);
    for (const int variable : problem.robot.variables)
      result[problem.robot.model->variables[at(variable)].name] = all;
    return result;
  }
  for (const auto& [joint, limit] : py::reinterpret_borrow<py::dict>(value)) {
    const int variable = variableOf(problem, py::str(joint));
    result[problem.robot.model->variables[at(variable)].name] = number(limit, name);
  }
  return result;
}

void setFrames(planner::Problem& problem, const py::object& value) {
  std::vector<planner::Frame> frames;
  for (const auto& [key, entry] : dictOf(value, "frames")) {
    const std::string name = py::str(key);
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

// ---- What a path costs.

using NamePairs = std::vector<std::pair<std::string, std::string>>;

/// Pairs as they were given: names of one side, and of the other.
py::tuple sidesOf(const NamePairs& pairs) {
  std::vector<std::string> sides[2];
  for (const auto& [a, b] : pairs) {
    if (std::find(sides[0].begin(), sides[0].end(), a) == sides[0].end()) sides[0].push_back(a);
    if (std::find(sides[1].begin(), sides[1].end(), b) == sides[1].end()) sides[1].push_back(b);
  }
  const auto side = [](const std::vector<std::string>& names) {
    return names.size() == 1 ? py::object(py::str(names[0])) : py::object(py::tuple(listOf(names)));
  };
  return py::make_tuple(side(sides[0]), side(sides[1]));
}

/// "robot and tray".
std::string textOf(py::handle key) {
  std::string text_of;
  for (const py::handle side : py::reinterpret_borrow<py::tuple>(key))
    text_of += (text_of.empty() ? "" : " and ") +
               std::string(py::isinstance<py::str>(side) ? py::str(side) : py::repr(side));
  return text_of;
}

py::object getMargins(const planner::Problem& problem) {
  py::dict margins;
  for (const planner::PairMargin& m : problem.margins.pairs)
    margins[py::make_tuple(m.a, m.b)] = m.margin;
  return py::object(margins);
}

void setMargins(planner::Problem& problem, const py::object& value) {
  std::map<std::pair<std::string, std::string>, std::string> groups;  // as read back
  for (const planner::PairMargin& m : problem.margins.pairs) groups[{m.a, m.b}] = m.group;
  std::vector<planner::PairMargin> margins;
  for (const auto& [key, entry] : dictOf(value, "margins")) {
    const double margin = number(entry, "margins");
    const NamePairs pairs = namePairs(problem, key, "margins");
    for (const auto& [a, b] : pairs)
      margins.push_back({a, b, margin, pairs.size() > 1 ? textOf(key) : groups[{a, b}]});
  }
  problem.margins.pairs = std::move(margins);
}

py::object getWishes(const planner::Problem& problem) {
  py::dict wishes;
  for (const planner::Wish& wish : problem.margins.wishes)
    wishes[sidesOf(wish.pairs)] = py::make_tuple(wish.clearance, wish.weight);
  return wishes;
}

void setWishes(planner::Problem& problem, const py::object& value) {
  std::vector<planner::Wish> wishes;
  for (const auto& [key, entry] : dictOf(value, "wishes")) {
    planner::Wish wish;
    auto given = py::reinterpret_borrow<py::object>(entry);
    if (py::isinstance<py::tuple>(given)) {
      const auto pair = py::reinterpret_borrow<py::tuple>(given);
      if (pair.size() != 2)
        throw py::type_error("wishes: " + shown(given) + "; (clearance, weight) is expected");
      wish.weight = number(pair[1], "wishes: a weight");
      given = pair[0];
    }
    wish.clearance = number(given, "wishes: a clearance");
    wish.pairs = namePairs(problem, key, "wishes");
    wish.name = textOf(key);
    wishes.push_back(std::move(wish));
  }
  problem.margins.wishes = std::move(wishes);
}

/// The values of joints that are not planned.
py::object getOthers(const planner::Problem& problem) {
  py::dict values;
  const std::vector<int>& planned = problem.robot.variables;
  for (std::size_t v = 0; v < problem.start.size(); ++v)
    if (std::find(planned.begin(), planned.end(), static_cast<int>(v)) == planned.end())
      values[py::str(problem.robot.model->variables[v].name)] = problem.start[v];
  return values;
}

void setOthers(planner::Problem& problem, const py::object& value) {
  for (const auto& [name, number_of] : dictOf(value, "others")) {
    const std::string joint = py::str(name);
    const int variable = variableOf(problem, joint);
    const std::vector<int>& planned = problem.robot.variables;
    if (std::find(planned.begin(), planned.end(), variable) != planned.end())
      throw py::value_error("joint '" + joint + "' is planned; its value belongs to start");
    problem.start[at(variable)] = number(number_of, ("others: " + joint).c_str());
  }
}

const char* wordOf(planner::Pairs pairs) {
  return pairs == planner::Pairs::kAll ? "all" : pairs == planner::Pairs::kSelf ? "self" : "world";
}

py::object getObjective(const planner::Problem& problem) {
  const auto* cost = std::get_if<planner::MinimumCost>(&problem.objective);
  if (cost == nullptr) return py::str(toString(problem.objective));
  py::dict weighted, result;
  py::list integral, worst;
  weighted["length"] = cost->length;
  for (const planner::CostTerm& term : cost->terms) {
    py::dict entry;
    const bool is_hinge = term.nearness.kind == planner::Nearness::Kind::kHinge;
    entry[is_hinge ? "hinge" : "inverse"] = term.nearness.distance;
    entry["of"] = wordOf(term.of);
    entry["weight"] = term.weight;
    (term.worst ? worst : integral).append(entry);
  }
  if (!integral.empty()) weighted["integral"] = integral;
  if (!worst.empty()) weighted["worst"] = worst;
  result["weighted"] = weighted;
  return result;
}

void expectKeys(const py::dict& map, std::initializer_list<const char*> known,
                const std::string& name) {
  for (const auto& [key, value] : map) {
    const std::string text = py::str(key);
    if (std::find(known.begin(), known.end(), text) != known.end()) continue;
    std::string expected;
    for (const char* word : known) expected += (expected.empty() ? "" : ", ") + std::string(word);
    throw py::value_error(name + " has the key '" + text + "'; one of " + expected +
                          " is expected");
  }
}

planner::CostTerm costTerm(const py::object& value, const std::string& name, bool weighs) {
  const py::dict map = dictOf(value, name.c_str());
  if (weighs)
    expectKeys(map, {"hinge", "inverse", "of", "weight"}, name);
  else
    expectKeys(map, {"hinge", "inverse", "of"}, name);
  if (map.contains("hinge") == map.contains("inverse"))
    throw py::value_error(name + " is " + shown(value) + "; one of hinge and inverse is expected");
  planner::CostTerm term;
  const char* kind = map.contains("hinge") ? "hinge" : "inverse";
  if (map.contains("inverse")) term.nearness.kind = planner::Nearness::Kind::kInverse;
  term.nearness.distance = number(map[kind], kind);
  if (map.contains("weight")) term.weight = number(map["weight"], "weight");
  if (!map.contains("of")) return term;
  const std::string of = word(map["of"], "of");
  for (const planner::Pairs pairs :
       {planner::Pairs::kWorld, planner::Pairs::kSelf, planner::Pairs::kAll})
    if (of == wordOf(pairs)) {
      term.of = pairs;
      return term;
    }
  unknownWord("of", of, "'world', 'self' or 'all'");
}

planner::MinimumCost costOf(const py::dict& objective) {
  expectKeys(objective, {"integral", "weighted"}, "objective");
  if (objective.size() != 1)
    throw py::value_error("objective is " + shown(objective) +
                          "; one of integral and weighted is expected");
  if (objective.contains("integral"))
    return {0, {costTerm(objective["integral"], "integral", false)}};
  const py::dict weighted = dictOf(objective["weighted"], "weighted");
  expectKeys(weighted, {"length", "integral", "worst"}, "weighted");
  planner::MinimumCost cost;
  if (weighted.contains("length")) cost.length = number(weighted["length"], "length");
  for (const char* key : {"integral", "worst"}) {
    if (!weighted.contains(key)) continue;
    const py::object terms = weighted[key];
    py::list list = py::isinstance<py::dict>(terms) ? py::list() : py::list(terms);
    if (py::isinstance<py::dict>(terms)) list.append(terms);
    for (const py::handle term : list) {
      cost.terms.push_back(costTerm(py::reinterpret_borrow<py::object>(term), key, true));
      cost.terms.back().worst = std::string(key) == "worst";
    }
  }
  return cost;
}

using P = planner::Problem;
using V = const py::object&;

const Setting kSettings[] = {
    {"name", "The problem's name, for messages.",
     [](const P& p) { return py::object(py::str(p.name)); },
     [](P& p, V v) { p.name = word(v, "name"); }},
    {"world", "The world; to set it copies.", [](const P& p) { return py::cast(World{p.world}); },
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
    {"others", "Values of the joints that are not planned: {joint: value}.", getOthers, setOthers},
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
     getMargins, setMargins},
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
    {"wishes",
     "Clearances that pairs keep where that is not too dear, see `margins` for names: {(a, b): "
     "clearance}, or {(a, b): (clearance, weight)} [m]. To miss one costs its weight, 1 by "
     "default, "
     "times the integral of 1 - d / clearance over the path's length, where the pair's clearance d "
     "is below it. Not with the objective 'clearance'.",
     getWishes, setWishes},
    {"objective",
     "'length'; 'clearance': the least clearance as large as possible; or a dict of what a path "
     "costs, as in problem files: {'integral': {'hinge': 0.1}}, or {'weighted': {'length': 1, "
     "'integral': {'hinge': 0.1, 'weight': 2}}}.",
     getObjective,
     [](P& p, V v) {
       if (py::isinstance<py::dict>(v)) {
         p.objective = costOf(py::reinterpret_borrow<py::dict>(v));
         return;
       }
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
         minimum.clearance = number(v, "keep");
         if (!std::holds_alternative<planner::MinimumLength>(p.objective))
           throw py::value_error(std::string("keep stands beside the objective '") +
                                 toString(p.objective) + "'; 'length' is expected");
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
         throw py::value_error(std::string("clearance_of stands beside the objective '") +
                               toString(p.objective) + "'; 'clearance' is expected");
       clearance->of = of == "all" ? planner::Pairs::kAll : planner::Pairs::kWorld;
     }},
    {"at_most_longer",
     "With the objective 'clearance': how much longer the path may be than the shortest that is "
     "found, as a share of that one's length.",
     [](const P& p) {
       const auto* clearance = std::get_if<planner::MaximumClearance>(&p.objective);
       return clearance == nullptr || std::isinf(clearance->at_most_longer)
                  ? py::object(py::none())
                  : py::object(py::float_(clearance->at_most_longer));
     },
     [](P& p, V v) {
       auto* clearance = std::get_if<planner::MaximumClearance>(&p.objective);
       if (v.is_none()) {
         if (clearance != nullptr)
           clearance->at_most_longer = std::numeric_limits<double>::infinity();
         return;
       }
       const double longer = number(v, "at_most_longer");
       if (clearance == nullptr)
         throw py::value_error(std::string("at_most_longer stands beside the objective '") +
                               toString(p.objective) + "'; 'clearance' is expected");
       clearance->at_most_longer = longer;
     }},
    {"planner", "Name of the planner, see planners().",
     [](const P& p) { return py::object(py::str(p.planner.name)); },
     [](P& p, V v) { p.planner.name = word(v, "planner"); }},
    {"parameters", "Parameters of the planner, by its names, as text.",
     [](const P& p) { return py::cast(p.planner.parameters); },
     [](P& p, V v) {
       std::map<std::string, std::string> parameters;
       for (const auto& [key, value] : dictOf(v, "parameters"))
         parameters[py::str(key)] = py::str(value);
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
     [](P& p, V v) { p.limits.time = number(v, "time"); }},
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
     [](P& p, V v) { p.execution.step = number(v, "step"); }},
    {"duration", "An execution that has not reached the goal within this fails [s].",
     [](const P& p) { return py::object(py::float_(p.execution.duration)); },
     [](P& p, V v) { p.execution.duration = number(v, "duration"); }},
    {"speed", "Share of the velocity limits that is used, in (0, 1].",
     [](const P& p) { return py::object(py::float_(p.execution.speed)); },
     [](P& p, V v) { p.execution.speed = number(v, "speed"); }},
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
     [](P& p, V v) { p.execution.look_ahead = number(v, "look_ahead"); }},
    {"buffer", "Paths keep this besides the margin from what deforms, where they can [m].",
     [](const P& p) { return py::object(py::float_(p.execution.buffer)); },
     [](P& p, V v) { p.execution.buffer = number(v, "buffer"); }},
    {"patience", "How long to wait for a valid path before planning another [s].",
     [](const P& p) { return py::object(py::float_(p.execution.patience)); },
     [](P& p, V v) { p.execution.patience = number(v, "patience"); }},
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

namespace {

/// Goals or steps that are set take the place of the others.
void replaceEnds(const std::string& name, planner::Problem& problem) {
  if ((name == "goal" || name == "goals") && !problem.goals.empty()) problem.steps.clear();
  if (name == "steps" && !problem.steps.empty()) problem.goals.clear();
}

/// Kinds of objects that a problem hands out and keeps.
bool canChange(const py::object& value) {
  return py::isinstance<py::list>(value) || py::isinstance<py::dict>(value) ||
         py::isinstance<py::array>(value) || py::isinstance<World>(value);
}

/// Returns an image of an object; another image means that the object has changed.
py::object imageOf(const py::object& value) {
  if (py::isinstance<World>(value)) return py::int_(value.cast<const World&>().changes);
  if (py::isinstance<py::array>(value))
    return py::make_tuple(value.attr("shape"), py::str(value.attr("dtype")),
                          value.attr("tobytes")());
  py::list images;
  if (py::isinstance<py::dict>(value)) {
    for (const auto& [key, item] : py::reinterpret_borrow<py::dict>(value)) {
      images.append(key);
      images.append(imageOf(py::reinterpret_borrow<py::object>(item)));
    }
  } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    for (const py::handle item : value)
      images.append(imageOf(py::reinterpret_borrow<py::object>(item)));
  } else {
    return value;
  }
  return py::tuple(images);
}

bool isSameImage(const py::object& x, const py::object& y) {
  const int same = PyObject_RichCompareBool(x.ptr(), y.ptr(), Py_EQ);
  if (same < 0) PyErr_Clear();  // what cannot be compared is read again
  return same == 1;
}

/// Gives a thing that was handed out the content of another of its kind.
void refill(const py::object& handed_out, const py::object& fresh) {
  if (py::isinstance<World>(handed_out)) {
    handed_out.cast<World&>().value = fresh.cast<const World&>().value;
  } else if (py::isinstance<py::dict>(handed_out)) {
    handed_out.attr("clear")();
    handed_out.attr("update")(fresh);
  } else {
    const py::object all = py::isinstance<py::array>(handed_out)
                               ? py::object(py::ellipsis())
                               : py::object(py::slice(std::nullopt, std::nullopt, std::nullopt));
    handed_out[all] = fresh;
  }
}

}  // namespace

void Problem::takeChanges(const std::string& except) const {
  std::shared_ptr<planner::Problem> changed;
  for (const Setting& setting : kSettings) {
    const auto found = handed_out_.find(setting.name);
    if (found == handed_out_.end() || setting.name == except) continue;
    const py::object image = imageOf(found->second.object);
    if (isSameImage(image, found->second.image)) continue;
    if (!changed) changed = std::make_shared<planner::Problem>(*value_);
    setting.set(*changed, found->second.object);
  }
  if (!changed) return;
  value_ = std::move(changed);
  for (auto& [name, handed_out] : handed_out_)
    if (name != except) handed_out.image = imageOf(handed_out.object);
}

const std::shared_ptr<const planner::Problem>& Problem::value() const {
  takeChanges();
  return value_;
}

void Problem::apply(const py::dict& settings) {
  const auto given = [&](const char* name) {
    return settings.contains(name) && !py::object(settings[name]).is_none();
  };
  if (given("steps") && (given("goal") || given("goals")))
    throw py::value_error("steps are given beside a goal; one of them is expected");
  planner::Problem changed = **this;
  // In the table's order: a planner before its parameters, frames before poses.
  for (const Setting& setting : kSettings) {
    if (!settings.contains(setting.name)) continue;
    setting.set(changed, py::reinterpret_borrow<py::object>(settings[setting.name]));
    replaceEnds(setting.name, changed);
  }
  placeStart(changed);
  handed_out_.clear();
  value_ = std::make_shared<const planner::Problem>(std::move(changed));
}

py::object Problem::attribute(const Setting& setting) const {
  const std::string name = setting.name;
  if (is_constant_) {
    const py::object value = setting.get(*value_);
    if (py::isinstance<World>(value)) value.cast<World&>().is_constant = true;
    return constant(value);
  }
  if (name == "goal") {  // that of the list, so that a change of it counts
    const py::object goals = attribute(*findSetting("goals"));
    return py::len(goals) == 0 ? py::object(py::none()) : py::object(goals[py::int_(0)]);
  }
  const auto found = handed_out_.find(name);
  if (found != handed_out_.end()) return found->second.object;
  const py::object value = setting.get(*value_);
  if (canChange(value)) handed_out_[name] = {value, imageOf(value)};
  return value;
}

void Problem::set(const Setting& setting, const py::object& value) {
  const std::string name = setting.name, replaced = name == "goal" ? "goals" : name;
  if (is_constant_)
    throw py::attribute_error("'" + name +
                              "' is of a problem that was compiled or answered; copy() gives one "
                              "to change");
  takeChanges(replaced);
  planner::Problem changed = *value_;
  setting.set(changed, value);
  replaceEnds(name, changed);
  placeStart(changed);
  planner::validate(changed);
  // Objects that were handed out stay the problem's, with the values that its settings have now.
  for (auto next = handed_out_.begin(); next != handed_out_.end();) {
    const auto handed_out = next++;
    const Setting& of = *findSetting(handed_out->first);
    const py::object fresh = of.get(changed);
    if (handed_out->first != replaced && isSameImage(imageOf(of.get(*value_)), imageOf(fresh)))
      continue;
    if (Py_TYPE(fresh.ptr()) != Py_TYPE(handed_out->second.object.ptr())) {
      handed_out_.erase(handed_out);  // an objective that is a word now
      continue;
    }
    refill(handed_out->second.object, fresh);
    handed_out->second.image = imageOf(handed_out->second.object);
  }
  value_ = std::make_shared<const planner::Problem>(std::move(changed));
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
        [&setting](const Problem& self) { return self.attribute(setting); },
        [&setting](Problem& self, const py::object& value) { self.set(setting, value); });
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
