#include "python/bindings/settings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/settings.h"
#include "leeway/robots/text.h"
#include "python/base/at.h"
#include "python/base/define.h"
#include "python/base/released.h"

namespace leeway::python {

namespace {

using planner::Setting;
using planner::SettingPlace;

bool truth(const py::object& value, const char* name) {
  if (!isTruth(value))
    throw py::type_error(std::string(name) + " is " + shown(value) + "; True or False is expected");
  return py::bool_(value);
}

py::dict dictOf(const py::object& value, const char* name) {
  if (value.is_none()) return {};
  if (!py::isinstance<py::dict>(value) && Py_TYPE(value.ptr()) != &PyDictProxy_Type)
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a dict is expected");
  return py::dict(value);
}

// ---- Maps by joint.

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
    const std::string joint_name = py::str(joint);
    const int variable = variableOf(problem, joint_name);
    result[problem.robot.model->variables[at(variable)].name] =
        number(limit, (std::string(name) + ": " + joint_name).c_str());
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
  for (const planner::PairMargin& m : problem.margins.pairs) {
    // The last one that names a pair holds: a name that stands twice has its last place.
    const py::tuple key = py::make_tuple(m.a, m.b);
    if (margins.contains(key)) margins.attr("pop")(key);
    margins[key] = m.margin;
  }
  return py::object(margins);
}

void setMargins(planner::Problem& problem, const py::object& value) {
  std::map<std::pair<std::string, std::string>, std::string> groups;  // as read back
  for (const planner::PairMargin& m : problem.margins.pairs) groups[{m.a, m.b}] = m.group;
  std::vector<planner::PairMargin> margins;
  for (const auto& [key, entry] : dictOf(value, "margins")) {
    const NamePairs pairs = namePairs(problem, key, "margins");
    const double margin = number(entry, ("margins: " + textOf(key)).c_str());
    for (const auto& [a, b] : pairs)
      margins.push_back({a, b, margin, pairs.size() > 1 ? textOf(key) : groups[{a, b}]});
  }
  problem.margins.pairs = std::move(margins);
}

py::object getWishes(const planner::Problem& problem) {
  py::dict wishes;
  for (const planner::Wish& wish : problem.margins.wishes) {
    const py::tuple key = sidesOf(wish.pairs), entry = py::make_tuple(wish.clearance, wish.weight);
    if (!wishes.contains(key)) {
      wishes[key] = entry;
      continue;
    }
    // Two wishes for the same pairs both count.
    const py::object before = wishes[key];
    py::list all = py::isinstance<py::list>(before) ? before.cast<py::list>() : py::list();
    if (all.empty()) all.append(before);
    all.append(entry);
    wishes[key] = all;
  }
  return wishes;
}

void setWishes(planner::Problem& problem, const py::object& value) {
  std::map<NamePairs, std::string> names;  // as read back
  for (const planner::Wish& wish : problem.margins.wishes) names[wish.pairs] = wish.name;
  std::vector<planner::Wish> wishes;
  for (const auto& [key, entry] : dictOf(value, "wishes")) {
    const NamePairs pairs = namePairs(problem, key, "wishes");
    const auto named = names.find(pairs);
    // Not `key` within add(): C++20 as of clang 14 cannot capture what a structured binding names.
    const std::string name = named == names.end() ? textOf(key) : named->second;
    const std::string where = "wishes: " + textOf(key);
    const auto add = [&](py::object given) {
      planner::Wish wish;
      if (py::isinstance<py::tuple>(given)) {
        const auto pair = py::reinterpret_borrow<py::tuple>(given);
        if (pair.size() != 2)
          throw py::type_error(where + " is " + shown(given) + "; (clearance, weight) is expected");
        wish.weight = number(pair[1], (where + ": the weight").c_str());
        given = pair[0];
      }
      wish.clearance = number(given, (where + ": the clearance").c_str());
      wish.pairs = pairs;
      wish.name = name;
      wishes.push_back(std::move(wish));
    };
    if (!py::isinstance<py::list>(entry)) {
      add(py::reinterpret_borrow<py::object>(entry));
      continue;
    }
    if (py::len(entry) == 0)
      throw py::value_error(where + " is an empty list; a clearance, or several, are expected");
    for (const py::handle one : py::reinterpret_borrow<py::list>(entry))
      add(py::reinterpret_borrow<py::object>(one));
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

/// Sets the joints that are not planned. Joints that are left out go to their defaults.
void setOthers(planner::Problem& problem, const py::object& value) {
  std::vector<double> q = problem.robot.model->defaultConfiguration();
  for (const int variable : problem.robot.variables) q[at(variable)] = problem.start[at(variable)];
  for (const auto& [name, number_of] : dictOf(value, "others")) {
    const std::string joint = py::str(name);
    const int variable = variableOf(problem, joint);
    const std::vector<int>& planned = problem.robot.variables;
    if (std::find(planned.begin(), planned.end(), variable) != planned.end())
      throw py::value_error("joint '" + joint + "' is planned; its value belongs to start");
    q[at(variable)] = number(number_of, ("others: " + joint).c_str());
  }
  problem.start = std::move(q);
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

py::object pairList(const NamePairs& pairs) {
  py::list list;
  for (const auto& [a, b] : pairs) list.append(py::make_tuple(a, b));
  return py::object(list);
}

using P = planner::Problem;
using V = const py::object&;

/// A setting whose values are of Python's own kinds, in place of its place in the problem.
struct OwnValue {
  const char* name;
  const char* given;      ///< type of what is accepted, for the stubs
  const char* attribute;  ///< and of what the attribute is
  py::object (*get)(const planner::Problem&);
  void (*set)(planner::Problem&, const py::object&);
};

const OwnValue kOwnValues[] = {
    {"world", "World | None", "World", [](const P& p) { return py::cast(World{p.world}); },
     [](P& p, V v) {
       if (!py::isinstance<World>(v)) throw py::type_error("world is no World");
       p.world = v.cast<const World&>().value;
     }},
    {"frames", "Mapping[str, tuple[str, _Pose]]", "Any",
     [](const P& p) {
       py::dict frames;
       for (const planner::Frame& f : p.robot.frames)
         frames[py::str(f.name)] =
             py::make_tuple(p.robot.model->links[at(f.link)].name, matrix(f.X_LF));
       return py::object(frames);
     },
     setFrames},
    {"others", "Mapping[str, float]", "Any", getOthers, setOthers},
    {"start", "_State | None", "Any",
     [](const P& p) {
       const std::vector<double> point = startPoint(p);
       return py::object(array(std::span<const double>(point)));
     },
     setStart},
    {"goal", "_Goal | None", "Any",
     [](const P& p) {
       return p.goals.empty() ? py::object(py::none()) : goalObject(p, p.goals.front());
     },
     [](P& p, V v) { setGoals(p, v, false); }},
    {"goals", "Sequence[_Goal]", "Any",
     [](const P& p) {
       py::list goals;
       for (const planner::Goal& goal : p.goals) goals.append(goalObject(p, goal));
       return py::object(goals);
     },
     [](P& p, V v) { setGoals(p, v, true); }},
    {"steps", "Sequence[TaskStep]", "list[TaskStep]", stepList, setSteps},
    {"constraints", "Sequence[Constraint]", "list[Constraint]", constraintList, setConstraints},
    {"margins", "Mapping[Any, float]", "dict[Any, float]", getMargins, setMargins},
    {"allowed", "Literal['auto'] | Iterable[Any]", "list[Any]",
     [](const P& p) { return pairList(p.contacts.allowed); },
     [](P& p, V v) {
       NamePairs pairs;
       const auto add = [&](py::handle item) {
         NamePairs added;
         if (py::isinstance<py::str>(item) && std::string(py::str(item)) == "auto") {
           P robot;
           robot.robot.model = p.robot.model;
           planner::allowTouching(robot);
           added = std::move(robot.contacts.allowed);
           p.warnings.push_back(robot.warnings.back());
         } else {
           added = namePairs(p, item, "allowed");
         }
         pairs.insert(pairs.end(), added.begin(), added.end());
       };
       if (py::isinstance<py::str>(v))
         add(v);
       else if (!v.is_none())
         for (const py::handle item : py::list(v)) add(item);
       p.contacts.allowed = std::move(pairs);
     }},
    {"checked", "Iterable[Any]", "list[Any]",
     [](const P& p) { return pairList(p.contacts.checked); },
     [](P& p, V v) {
       NamePairs pairs;
       if (!v.is_none())
         for (const py::handle item : py::list(v)) {
           NamePairs added = namePairs(p, item, "checked");
           pairs.insert(pairs.end(), added.begin(), added.end());
         }
       p.contacts.checked = std::move(pairs);
     }},
    {"wishes", "Mapping[Any, float | tuple[float, float] | list[float | tuple[float, float]]]",
     "Any", getWishes, setWishes},
    {"objective", "str | Mapping[str, Any]", "str | dict[str, Any]", getObjective,
     [](P& p, V v) {
       if (py::isinstance<py::dict>(v)) {
         p.objective = costOf(py::reinterpret_borrow<py::dict>(v));
         return;
       }
       const auto objective = planner::objectiveOfName(word(v, "objective"));
       if (!objective) unknownWord("objective", word(v, "objective"), "'length' or 'clearance'");
       // Its own settings stay if the objective does.
       if (objective->index() != p.objective.index()) p.objective = *objective;
     }},
};

const OwnValue* findOwnValue(const Setting& setting) {
  const auto* const found =
      std::find_if(std::begin(kOwnValues), std::end(kOwnValues),
                   [&](const OwnValue& own) { return setting.name == own.name; });
  return found == std::end(kOwnValues) ? nullptr : found;
}

std::string orWords(const planner::WordSetting& choice) {
  std::string all;
  for (const planner::WordSetting::Word& word : choice.words)
    all += (all.empty() ? "'" : " or '") + std::string(word.text) + "'";
  return all;
}

/// Reads a setting of a problem.
struct Get {
  const Setting& setting;
  const P& problem;

  template <class T>
  py::object operator()(SettingPlace<T> place) const {
    const T* const value = settingValue(problem, place);
    if (value == nullptr) return py::none();
    if constexpr (std::is_same_v<T, double>)
      if (*value == setting.range.none) return py::none();
    return py::cast(*value);
  }
  py::object operator()(const planner::WordSetting& choice) const {
    for (const planner::WordSetting::Word& word : choice.words)
      if (word.value == choice.get(problem)) return py::str(std::string(word.text));
    return py::none();
  }
  template <class Other>
  py::object operator()(const Other&) const {
    throw std::logic_error("a setting without a value: " + std::string(setting.name));
  }
};

/// Sets one.
struct Set {
  const Setting& setting;
  P& problem;
  V given;
  const std::string name = std::string(setting.name);

  void operator()(SettingPlace<bool> place) const { *place(problem) = truth(given, name.c_str()); }
  void operator()(SettingPlace<double> place) const {
    if (given.is_none() && setting.isOptional()) {
      if (double* const value = place(problem)) *value = setting.range.none.value();
      return;
    }
    const double value = number(given, name.c_str());
    if (place(problem) == nullptr) refuse();
    *place(problem) = value;
  }
  void operator()(SettingPlace<std::int64_t> place) const {
    *place(problem) = whole<std::int64_t>(given, name.c_str());
  }
  void operator()(SettingPlace<std::uint64_t> place) const {
    *place(problem) = whole<std::uint64_t>(given, name.c_str());
  }
  void operator()(SettingPlace<std::string> place) const {
    *place(problem) = word(given, name.c_str());
  }
  void operator()(SettingPlace<std::map<std::string, std::string>> place) const {
    std::map<std::string, std::string> values;
    for (const auto& [key, value] : dictOf(given, name.c_str()))
      values[py::str(key)] = py::str(value);
    *place(problem) = std::move(values);
  }
  void operator()(SettingPlace<std::map<std::string, double>> place) const {
    *place(problem) = byJoint(problem, given, name.c_str());
  }
  void operator()(const planner::WordSetting& choice) const {
    if (given.is_none() && setting.isOptional()) return;
    const std::string text = word(given, name.c_str());
    for (const planner::WordSetting::Word& known : choice.words) {
      if (text != known.text) continue;
      if (choice.get(problem) < 0) refuse();
      return choice.set(problem, known.value);
    }
    unknownWord(name.c_str(), text, orWords(choice));
  }
  template <class Other>
  void operator()(const Other&) const {
    throw std::logic_error("a setting without a value: " + name);
  }

 private:
  [[noreturn]] void refuse() const {
    throw py::value_error(name + " stands beside the objective '" + toString(problem.objective) +
                          "'; '" + std::string(setting.objective()) + "' is expected");
  }
};

py::object valueOf(const Setting& setting, const P& problem) {
  if (const OwnValue* const own = findOwnValue(setting)) return own->get(problem);
  return std::visit(Get{setting, problem}, setting.value);
}

void setValue(const Setting& setting, P& problem, V value) {
  if (const OwnValue* const own = findOwnValue(setting)) return own->set(problem, value);
  std::visit(Set{setting, problem, value}, setting.value);
}

/// "Time from one look at the world to the next [s]; 0.05 by default."
std::string docOf(const Setting& setting) {
  const std::string plain = findOwnValue(setting) != nullptr ? "" : settingDefault(setting);
  std::string help(setting.help);
  if (!setting.unit.empty())  // behind the first sentence
    help.insert(std::min(help.find(". "), help.size()), " [" + std::string(setting.unit) + "]");
  return help + (plain.empty() ? "" : "; " + plain + " by default") + ".";
}

/// The types of what is accepted, and of the attribute, as stubs have them.
std::pair<std::string, std::string> typesOf(const Setting& setting) {
  if (const OwnValue* const own = findOwnValue(setting)) return {own->given, own->attribute};
  std::string type = "Any", given;
  if (std::holds_alternative<SettingPlace<bool>>(setting.value)) type = "bool";
  if (std::holds_alternative<SettingPlace<double>>(setting.value)) type = "float";
  if (std::holds_alternative<SettingPlace<std::int64_t>>(setting.value) ||
      std::holds_alternative<SettingPlace<std::uint64_t>>(setting.value))
    type = "int";
  if (std::holds_alternative<SettingPlace<std::string>>(setting.value)) type = "str";
  if (std::holds_alternative<SettingPlace<std::map<std::string, std::string>>>(setting.value)) {
    given = "Mapping[str, Any]";
    type = "dict[str, str]";
  }
  if (std::holds_alternative<SettingPlace<std::map<std::string, double>>>(setting.value))
    given = "float | Mapping[str, float]";
  if (const auto* choice = std::get_if<planner::WordSetting>(&setting.value)) {
    type = "Literal[";
    for (const planner::WordSetting::Word& word : choice->words)
      type += (type.back() == '[' ? "\"" : ", \"") + std::string(word.text) + "\"";
    type += "]";
  }
  if (setting.isOptional()) type += " | None";
  return {given.empty() ? type : given, type};
}

/// "number", "whole number", ...: for settings().
const char* settingKind(const Setting& setting) {
  static constexpr const char* kKinds[] = {"own",  "boolean",  "number", "whole number",
                                           "seed", "text",     "map",    "number by joint",
                                           "word", "parameter"};
  static_assert(std::size(kKinds) == std::variant_size_v<decltype(Setting::value)>);
  const auto* const choice = std::get_if<planner::WordSetting>(&setting.value);
  return choice != nullptr && choice->or_map ? "own" : kKinds[setting.value.index()];
}

py::list listSettings() {
  py::list list;
  for (const Setting& setting : planner::settings()) {
    if (setting.name.empty()) continue;
    py::dict entry;
    const auto [given, attribute] = typesOf(setting);
    entry["name"] = std::string(setting.name);
    entry["key"] = std::string(setting.key);
    entry["option"] = std::string(setting.option);
    entry["kind"] = settingKind(setting);
    entry["unit"] = std::string(setting.unit);
    entry["default"] = settingDefault(setting);
    entry["lower"] = setting.range.lower;
    entry["upper"] = setting.range.upper;
    entry["above"] = setting.range.above;
    py::list words;
    if (const auto* choice = std::get_if<planner::WordSetting>(&setting.value))
      for (const planner::WordSetting::Word& word : choice->words)
        words.append(std::string(word.text));
    entry["words"] = words;
    entry["given"] = isKeyword(setting) ? given : "";
    entry["attribute"] = isKeyword(setting) ? attribute : "";
    entry["help"] = std::string(setting.help);
    list.append(entry);
  }
  return list;
}

}  // namespace

bool isSetting(const std::string& name) {
  const Setting* const setting = planner::findSetting(name);
  return setting != nullptr && isKeyword(*setting);
}

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

/// Whether an object never changes: a text, a number, nothing, or one of this module's.
bool isFixed(const py::object& value) {
  static const auto number_types = [] {
    return py::make_tuple(py::module_::import("numbers").attr("Number"),
                          py::module_::import("numpy").attr("generic"))
        .release();
  }();
  const auto metaclassOf = [](PyObject* type) { return Py_TYPE(type); };
  return value.is_none() || py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value) ||
         py::isinstance(value, number_types) ||
         metaclassOf(reinterpret_cast<PyObject*>(Py_TYPE(value.ptr()))) ==
             metaclassOf(py::type::of<World>().ptr());
}

/// Returns an image of an object; another image means that the object has changed. Throws TypeError
/// for other kinds of objects, whose changes might not be seen, ValueError for a list or dict that
/// holds itself.
py::object imageOf(const std::string& name, const py::object& value, int depth = 0) {
  constexpr int kDeepest = 20;  // settings are at most 7 deep
  if (depth > kDeepest)
    throw py::value_error(name + " holds itself, or more than " + std::to_string(kDeepest) +
                          " lists in each other; values are expected");
  if (py::isinstance<World>(value)) return py::int_(value.cast<const World&>().changes);
  if (py::isinstance<py::array>(value))
    return py::make_tuple(value.attr("shape"), py::str(value.attr("dtype")),
                          value.attr("tobytes")());
  const auto imageOfItem = [&](py::handle item) {
    return imageOf(name, py::reinterpret_borrow<py::object>(item), depth + 1);
  };
  py::list images;
  if (py::isinstance<py::dict>(value) || Py_TYPE(value.ptr()) == &PyDictProxy_Type) {
    for (const auto& [key, item] : py::dict(value)) {
      images.append(key);
      images.append(imageOfItem(item));
    }
  } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    for (const py::handle item : value) images.append(imageOfItem(item));
  } else if (isFixed(value)) {
    return value;
  } else {
    throw py::type_error(name + " holds an object of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a list, a tuple, a dict, an array of numpy, a text or a number is "
                         "expected");
  }
  return py::tuple(images);
}

/// The image of an object that was replaced. None for one that holds what a setting cannot hold: it
/// was wrong already.
py::object imageOfReplaced(const std::string& name, const py::object& value) {
  try {
    return imageOf(name, value);
  } catch (const py::builtin_exception&) {
    return py::none();
  }
}

/// Whether anything but its container refers to an object that can change, or to one within it.
bool isHeldElsewhere(PyObject* value) {
  if (PyTuple_Check(value)) {
    for (Py_ssize_t i = 0; i < PyTuple_GET_SIZE(value); ++i)
      if (isHeldElsewhere(PyTuple_GET_ITEM(value, i))) return true;
    return false;
  }
  const py::handle object = value;
  if (!py::isinstance<World>(object) && isFixed(py::reinterpret_borrow<py::object>(object)))
    return false;
  if (Py_REFCNT(value) > 1) return true;  // also one that holds itself
  if (PyList_Check(value)) {
    for (Py_ssize_t i = 0; i < PyList_GET_SIZE(value); ++i)
      if (isHeldElsewhere(PyList_GET_ITEM(value, i))) return true;
  }
  PyObject *key = nullptr, *item = nullptr;
  for (Py_ssize_t at = 0; PyDict_Check(value) && PyDict_Next(value, &at, &key, &item) != 0;)
    if (isHeldElsewhere(item)) return true;
  return false;
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

namespace {

/// The last margin that names a pair holds. One that was changed in its place becomes the last.
void putChangedLast(const py::dict& margins, const py::dict& before) {
  py::list changed;
  for (const auto& [key, margin] : margins)
    if (!before.contains(key) ||
        !isSameImage(py::reinterpret_borrow<py::object>(margin), before[key]))
      changed.append(key);
  for (const py::handle key : changed) margins[key] = margins.attr("pop")(key);
}

}  // namespace

void Problem::takeChanges(const std::string& except) const {
  for (const auto& [name, kept] : replaced_) {
    if (name == except) continue;  // it may be what is set now
    if (!isSameImage(imageOfReplaced(name, kept.object), kept.image))
      throw py::value_error("'" + name +
                            "' was changed after another had taken its place in its problem; "
                            "change the one that the problem has now, or set '" +
                            name + "' again to what is meant");
  }
  std::shared_ptr<planner::Problem> changed;
  for (const Setting& setting : planner::settings()) {
    const auto found = handed_out_.find(std::string(setting.name));
    if (found == handed_out_.end() || setting.name == except) continue;
    const py::object image = imageOf(found->first, found->second.object);
    if (isSameImage(image, found->second.image)) continue;
    if (!changed) changed = std::make_shared<planner::Problem>(*value_);
    if (setting.name == "margins") putChangedLast(found->second.object, getMargins(*value_));
    setValue(setting, *changed, found->second.object);
    // A joint whose value was deleted has its default again.
    if (setting.name == "others") refill(found->second.object, getOthers(*changed));
  }
  if (!changed) return;
  value_ = std::move(changed);
  for (auto& [name, handed_out] : handed_out_)
    if (name != except) handed_out.image = imageOf(name, handed_out.object);
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
  if (given("goal") && given("goals"))
    throw py::value_error("goal is given beside goals; one of them is expected");
  planner::Problem changed = **this;
  // In the table's order: a planner before its parameters, frames before poses.
  for (const Setting& setting : planner::settings()) {
    const std::string name(setting.name);
    if (!isKeyword(setting) || !settings.contains(name)) continue;
    setValue(setting, changed, py::reinterpret_borrow<py::object>(settings[name.c_str()]));
    replaceEnds(name, changed);
  }
  if (given("others") && given("start"))
    for (const auto& [key, value] : dictOf(settings["others"], "others")) {
      const std::string joint = py::str(key);
      if (changed.start[at(variableOf(changed, joint))] != number(value, "others"))
        throw py::value_error("start gives joint '" + joint +
                              "', which has a value in others; one of them is expected");
    }
  placeStart(changed);
  handed_out_.clear();
  value_ = std::make_shared<const planner::Problem>(std::move(changed));
}

py::object Problem::attribute(const Setting& setting) const {
  const std::string name(setting.name);
  if (is_constant_) {
    const py::object value = valueOf(setting, *value_);
    if (py::isinstance<World>(value)) value.cast<World&>().is_constant = true;
    return constant(value);
  }
  if (name == "goal") {  // that of the list, so that a change of it counts
    const py::object goals = attribute(*planner::findSetting("goals"));
    return py::len(goals) == 0 ? py::object(py::none()) : py::object(goals[py::int_(0)]);
  }
  const auto found = handed_out_.find(name);
  if (found != handed_out_.end()) return found->second.object;
  const py::object value = valueOf(setting, *value_);
  if (canChange(value)) handed_out_[name] = {value, imageOf(name, value)};
  return value;
}

void Problem::set(const Setting& setting, const py::object& value) {
  const std::string name(setting.name), replaced = name == "goal" ? "goals" : name;
  if (is_constant_)
    throw py::attribute_error("'" + name +
                              "' is of a problem that was compiled or answered; copy() gives one "
                              "to change");
  planner::Problem changed;
  std::shared_ptr<const planner::Problem> before;
  do {  // again where another thread changed the problem while a start of poses was placed
    takeChanges(replaced);
    before = value_;
    changed = *before;
    setValue(setting, changed, value);
    replaceEnds(name, changed);
    placeStart(changed);
    planner::validate(changed);
  } while (value_ != before);
  // An attribute that is set is another object, as in all of Python: who keeps the old one can set
  // it again.
  for (auto& [of, kept] : replaced_)  // the new value replaces its changes
    if (of == replaced) kept.image = imageOfReplaced(of, kept.object);
  const auto old = handed_out_.find(name);
  if (old != handed_out_.end() && !value.is(old->second.object)) {
    constexpr std::size_t kMostReplaced = 100;
    if (replaced_.size() >= kMostReplaced)  // those that nothing else refers to cannot change
      std::erase_if(replaced_,
                    [](const auto& of) { return !isHeldElsewhere(of.second.object.ptr()); });
    replaced_.emplace_back(
        name, HandedOut{old->second.object, imageOfReplaced(name, old->second.object)});
    handed_out_.erase(old);
  }
  const auto again = std::find_if(replaced_.begin(), replaced_.end(), [&](const auto& kept) {
    return kept.first == name && value.is(kept.second.object);
  });
  if (again != replaced_.end()) {
    handed_out_[name] = {value, imageOf(name, value)};
    replaced_.erase(again);
  }
  // Other objects that were handed out stay the problem's, with its present values.
  for (auto next = handed_out_.begin(); next != handed_out_.end();) {
    const auto handed_out = next++;
    const Setting& of = *planner::findSetting(handed_out->first);
    const py::object fresh = valueOf(of, changed);
    if (handed_out->first != replaced &&
        isSameImage(imageOf(name, valueOf(of, *value_)), imageOf(name, fresh)))
      continue;
    if (Py_TYPE(fresh.ptr()) != Py_TYPE(handed_out->second.object.ptr())) {
      handed_out_.erase(handed_out);  // an objective that is a word now
      continue;
    }
    refill(handed_out->second.object, fresh);
    handed_out->second.image = imageOf(name, handed_out->second.object);
  }
  value_ = std::make_shared<const planner::Problem>(std::move(changed));
}

void defineSettings(py::module_& module, py::class_<Problem>& problem) {
  for (const Setting& setting : planner::settings())
    if (isKeyword(setting))
      defineProperty(
          problem, std::string(setting.name).c_str(), docOf(setting).c_str(),
          [&setting](const Problem& self) { return self.attribute(setting); },
          [&setting](Problem& self, const py::object& value) {
            // (A call without a start keeps the old one.)
            if (value.is_none() && setting.name == "start")
              throw py::type_error("start is None; a state is expected");
            self.set(setting, value);
          });
  define(module, "settings", "()",
         "The settings of a problem: dicts of name (the keyword and attribute), key (in problem "
         "files), option (of the command), kind, unit, default, lower, upper, above (lower itself "
         "is not accepted), words, given and attribute (types), help.",
         listSettings);
}

std::string settingsDoc() {
  std::string all;
  for (const Setting& setting : planner::settings())
    if (isKeyword(setting)) all += std::string(setting.name) + ": " + docOf(setting) + "\n";
  return all;
}

void noMore(const char* call, const py::dict& keywords) {
  for (const auto& [key, value] : keywords) {
    std::vector<std::string> known;
    for (const Setting& setting : planner::settings())
      if (isKeyword(setting)) known.emplace_back(setting.name);
    const std::string name = py::str(key);
    const std::string* const near = robots::nearestName(name, known);
    throw py::type_error(std::string(call) + "(): unknown keyword '" + name + "'" +
                         (near != nullptr ? "; did you mean '" + *near + "'?" : ""));
  }
}

}  // namespace leeway::python
