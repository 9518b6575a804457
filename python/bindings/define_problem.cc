#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "leeway/planner/cloud_notes.h"
#include "leeway/planner/placed_at.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "leeway/planner/save_problem.h"
#include "leeway/robots/cache_folder.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/named_states.h"
#include "leeway/robots/text.h"
#include "python/base/at.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/problem.h"
#include "python/bindings/settings.h"

namespace leeway::python {
namespace {

Problem makeProblem(const Robot& robot, const World* world) {
  planner::Problem problem;
  problem.name = robot.model->name;
  problem.robot.model = robot.model;
  problem.robot.variables.assign(robot.space->variables().begin(), robot.space->variables().end());
  problem.start = robot.model->defaultConfiguration();
  if (world != nullptr) problem.world = world->value;
  return Problem(std::make_shared<const planner::Problem>(std::move(problem)));
}

/// What args or keywords give for parameter `i`, taken out of the keywords; None where nothing
/// does.
py::object takeArgument(const char* call, const py::args& args, py::dict& keywords, std::size_t i,
                        const char* name) {
  if (i < args.size()) {
    if (keywords.contains(name))
      throw py::type_error(std::string(call) + "(): " + name + " is given twice");
    return args[i];
  }
  if (!keywords.contains(name)) return py::none();
  py::object value = keywords[name];
  keywords.attr("pop")(name);
  return value;
}

py::object load(const py::object& file, const py::object& packages, bool cache) {
  planner::ProblemOptions options;
  const std::string path = fileName(file, "file");
  if (!packages.is_none())
    for (const auto& [name, folder] : py::dict(packages))
      options.load.packages.emplace_back(py::str(name), py::str(folder));
  if (cache) options.load.cache = robots::cacheFolder();
  Interrupt interrupt;
  options.load.stop = interrupt.callback();
  return py::cast(interrupt.released([&] {
    return Problem(std::make_shared<const planner::Problem>(
        planner::placeStart(planner::loadProblem(path, options))));
  }));
}

Problem loadMoveit(const Robot& robot, const py::object& scene, const py::object& request,
                   const py::object& meshes) {
  const std::string scene_file = fileName(scene, "scene"),
                    request_file = fileName(request, "request");
  const auto model = robot.model;
  Interrupt interrupt;
  planner::ProblemOptions options;
  options.load.stop = interrupt.callback();
  options.load.meshes = treatments(meshes);
  return interrupt.released([&] {
    return Problem(std::make_shared<const planner::Problem>(
        planner::loadMoveit(model, scene_file, request_file, options)));
  });
}

std::vector<double> configurationFor(const Problem& self, const py::object& state) {
  std::vector<double> q = self->start;
  if (!state.is_none()) self.robot().expand(statePoint(self, state), q);
  return q;
}

Problem attach(const Problem& self, const std::string& object, const std::string& link,
               const std::vector<std::string>& touch, const py::object& state) {
  return Problem(std::make_shared<const planner::Problem>(
      planner::attachObject(*self, object, link, touch, configurationFor(self, state))));
}

Problem detach(const Problem& self, const std::string& object, const py::object& state) {
  return Problem(std::make_shared<const planner::Problem>(
      planner::detachObject(*self, object, configurationFor(self, state))));
}

std::string html(const Problem& problem) {
  const planner::Problem& p = *problem;
  std::vector<std::vector<std::string>> table;
  const std::vector<double> start = startPoint(p);
  const Robot robot = problem.robot();
  std::vector<std::string> heading = {"joint", "start"};
  for (const planner::Goal& goal : p.goals)
    if (goal.poses.empty()) heading.push_back(goal.name);
  for (std::size_t i = 0; i < start.size(); ++i) {
    std::vector<std::string> row = {robot.variableName(i), text(start[i])};
    for (const planner::Goal& goal : p.goals) {
      if (i >= goal.ranges.size()) continue;
      const auto [lower, upper] = goal.ranges[i];
      row.push_back(lower == upper ? text(lower) : text(lower) + " to " + text(upper));
    }
    table.push_back(row);
  }
  return htmlTable(p.name + ", margin " + text(p.margins.common) + " m, among " +
                       std::to_string(p.world.objects.size() + p.world.deforming.size()) +
                       " objects" +
                       (p.steps.empty() ? "" : ", " + std::to_string(p.steps.size()) + " steps"),
                   heading, table);
}

}  // namespace

Problem problemOf(const char* call, const py::args& args, py::dict& keywords, bool needs_start) {
  static constexpr std::array kNames = {"robot", "world", "start", "goal"};
  Problem problem;
  py::dict settings;
  if ((!args.empty() && py::isinstance<Problem>(args[0])) || keywords.contains("problem")) {
    const py::object first = takeArgument(call, args, keywords, 0, "problem");
    if (args.size() > 1 || !py::isinstance<Problem>(first))
      throw py::type_error(std::string(call) + "(): a Problem stands alone, before keywords");
    problem = first.cast<const Problem&>();
  } else {
    if (args.size() > kNames.size())
      throw py::type_error(std::string(call) + "(): " + std::to_string(args.size()) +
                           " positional arguments; a Problem, or robot, world, start and goal are "
                           "expected");
    std::array<py::object, 4> given;
    for (std::size_t i = 0; i < kNames.size(); ++i)
      given[i] = takeArgument(call, args, keywords, i, kNames[i]);
    if (!py::isinstance<Robot>(given[0]))
      throw py::type_error(std::string(call) + "(): the first argument is of type " +
                           Py_TYPE(given[0].ptr())->tp_name +
                           "; a Problem, or a Robot and world, start and goal are expected");
    if (!given[1].is_none() && !py::isinstance<World>(given[1]))
      throw py::type_error(std::string(call) + "(): world is of type " +
                           Py_TYPE(given[1].ptr())->tp_name + "; a World or None is expected");
    problem = makeProblem(given[0].cast<const Robot&>(),
                          given[1].is_none() ? nullptr : &given[1].cast<const World&>());
    // With the settings, in whose order poses find the frames that they name.
    if (!given[2].is_none())
      settings["start"] = given[2];
    else if (needs_start)
      throw py::value_error(std::string(call) +
                            "(): no start is given; a group state, numbers, a dict by joint or a "
                            "FramePose is expected");
    if (!given[3].is_none()) settings["goal"] = given[3];
  }
  for (const auto& [key, value] : py::dict(keywords.attr("copy")()))
    if (isSetting(py::str(key))) {
      settings[key] = value;
      keywords.attr("pop")(key);
    }
  if (!settings.empty()) problem.apply(settings);
  return problem;
}

void requireGoal(const Problem& problem) {
  if (problem->goals.empty() && problem->steps.empty())
    throw py::value_error(
        "no goal is given; a group state, numbers, a dict by joint, a FramePose or steps are "
        "expected");
}

namespace {

/// goalPoint(); of poses the valid configuration nearest to the start.
std::vector<double> placeOf(const planner::Problem& problem, const planner::Goal& goal) {
  if (goal.poses.empty()) return goalPoint(problem, goal);
  return startPoint(
      released([&] { return planner::placedAt(problem, goal.poses, "goal '" + goal.name + "'"); }));
}

}  // namespace

std::vector<double> statePoint(const Problem& problem, const py::object& state) {
  if (py::isinstance<py::str>(state)) {
    const std::string name = word(state, "state");
    if (name == "start") return startPoint(*problem);
    if (name == "goal" && !problem->goals.empty()) return placeOf(*problem, problem->goals.front());
  }
  planner::Problem at_state = *problem;
  if (py::isinstance<py::str>(state))
    if (const std::string others = robots::otherValues(*problem->robot.model, word(state, "state"),
                                                       problem->robot.variables, problem->start);
        !others.empty())
      throw py::value_error(others + ", as others says");
  setStart(at_state, state);
  for (std::size_t v = 0; v < at_state.start.size(); ++v) {
    const std::vector<int>& planned = problem->robot.variables;
    if (at_state.start[v] == problem->start[v] ||
        std::find(planned.begin(), planned.end(), static_cast<int>(v)) != planned.end())
      continue;
    throw py::value_error("the state gives joint '" + problem->robot.model->variables[v].name +
                          "' the value " + text(at_state.start[v]) +
                          "; it is not planned and stands at " + text(problem->start[v]) +
                          ", as others says");
  }
  if (at_state.start_poses.empty()) return startPoint(at_state);
  return startPoint(
      released([&] { return planner::placedAt(at_state, at_state.start_poses, "the state"); }));
}

void defineProblem(py::module_& module) {
  const std::string init = "(robot, world=None, start=None, goal=None, **settings)";
  auto problem = defineClass<py::class_<Problem>>(
      module, "Problem", init,
      "All that a planner needs to know. plan(robot, world, start, goal, ...) makes one for "
      "itself; the keywords are the same.\n\n"
      "Settings, each a keyword and an attribute:\n" +
          settingsDoc() +
          "\n"
          "A problem copies what it is given. What its attributes hand out is its own: "
          "problem.world.add_box(...), problem.margins[a, b] = m, problem.start[0] = 1 change "
          "it. It is checked when it is made or set, and whenever it is used: InputError.",
      [](const py::args& args, const py::kwargs& kwargs) {
        py::dict keywords = kwargs.attr("copy")();
        Problem made = problemOf("Problem", args, keywords);
        noMore("Problem", keywords);
        planner::validate(*made);
        return made;
      });
  defineStatic(
      problem, "load", "(file, *, packages=None, cache=True)",
      "Reads a problem file (YAML). Raises InputError with file and line. A start that is given "
      "by poses becomes joint values at once: what is set later, as constraints, does not "
      "move it.",
      load);
  defineStatic(problem, "load_moveit", "(robot, scene, request, *, meshes=None)",
               "Reads a MoveIt planning scene and a motion plan request (YAML), as "
               "MotionBenchMaker writes them. meshes: {object: {'solid': ..., 'weld': ...}}, as "
               "for Robot.",
               loadMoveit);
  define(problem, "save", "(self, file)",
         "Writes a problem file (YAML) that load() reads back as the same problem; meshes go into "
         "the folder STEM.files beside it. What it wrote is loaded and compared before it replaces "
         "an existing file. Raises InputError for what files cannot say, and where the file cannot "
         "be written.",
         [](const Problem& self, const py::object& file) {
           const std::string path = fileName(file, "file");
           const auto value = self.value();
           Interrupt interrupt;
           const auto stop = interrupt.callback();
           interrupt.released([&] { planner::saveProblem(*value, path, stop); });
         });
  define(problem, "attach", "(self, object, link, touch_links=[], *, state=None)",
         "Returns another problem, with an object of the world held by a link, grasped where it "
         "stands while the robot is at `state` (default: the start). It may touch the link and "
         "`touch_links`. This problem stays as it is.",
         attach);
  define(problem, "detach", "(self, object, *, state=None)",
         "Returns another problem, with a held object put down where it is while the robot is at "
         "`state`. This problem stays as it is.",
         detach);
  define(problem, "copy", "(self)",
         "Another problem with the same content, as copy.copy() and copy.deepcopy() give.",
         [](const Problem& self) { return self; });
  defineCopies(problem, [](const Problem& self) { return self; });
  defineSettings(module, problem);
  defineConstant(
      problem, "robot", [](const Problem& self) { return self.robot(); },
      "The robot and its planned group.");
  defineConstant(
      problem, "warnings",
      [](const Problem& self) { return listOf(planner::problemWarnings(*self)); },
      "What is odd about its robot, files and objects: with file and line if it was loaded; meshes "
      "that are not closed.");
  defineConstant(
      problem, "notes", [](const Problem& self) { return listOf(planner::cloudNotes(*self)); },
      "What no answer covers of its point clouds: points that filters removed, and space that was "
      "not seen.");
  problem.def("__repr__", [](const Problem& self) {
    return "<leeway.Problem '" + self->name + "': " + std::to_string(self.size()) +
           " planned joints among " +
           std::to_string(self->world.objects.size() + self->world.deforming.size()) +
           " objects, margin " + text(self->margins.common) + " m>";
  });
  problem.def("_repr_html_", html);
  define(module, "load", "(file, *, packages=None, cache=True)",
         "Reads a problem file (YAML): Problem.load().", load);
  define(module, "planners", "()",
         "The planners that a problem may name: dicts of name, deterministic, optimizing, summary.",
         [] {
           py::list list;
           for (const planner::PlannerTraits& traits : planner::plannerNames()) {
             py::dict entry;
             entry["name"] = traits.name;
             entry["deterministic"] = traits.deterministic;
             entry["optimizing"] = traits.optimizing;
             entry["summary"] = traits.summary;
             list.append(entry);
           }
           return list;
         });
  define(module, "planner_parameters", "(planner)",
         "The parameters of a planner: {name: default}, as text.", [](const std::string& name) {
           if (planner::findPlanner(name) == nullptr)
             throw py::value_error(*planner::plannerError(name, {}));
           py::dict parameters;
           for (const planner::PlannerParameter& parameter : planner::plannerParameters(name))
             parameters[py::str(parameter.name)] = parameter.value;
           return parameters;
         });
}

}  // namespace leeway::python
