// Tasks: steps one after the other, each in the world as those before have left it.

#include <algorithm>
#include <cmath>
#include <set>

#include "leeway/planner/task.h"
#include "leeway/robots/text.h"
#include "python/base/define.h"
#include "python/base/warn.h"
#include "python/bindings/settings.h"

namespace leeway::python {
namespace {

constexpr double kLeastLineTolerance = 1e-7;  ///< as in problem files [m, rad]

/// A step as a program gives it; what it names is looked up when a problem takes it.
struct TaskStep {
  std::string name;
  planner::Step step;
  py::object goal = py::none();     // of a move
  py::object allowed = py::list();  // pairs
};

const char* kindOf(const TaskStep& self) {
  static constexpr const char* kKinds[] = {"move", "line", "attach", "detach"};
  return kKinds[self.step.action.index()];
}

TaskStep made(const py::object& name, decltype(planner::Step::action) action) {
  TaskStep step;
  if (!name.is_none()) step.name = py::str(name);
  step.step.action = std::move(action);
  return step;
}

/// A copy of lists in each other, dicts and arrays: what a program changes later is not the step's.
py::object ownCopy(const py::object& value) {
  if (py::isinstance<py::array>(value)) return value.attr("copy")();
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    py::list items;
    for (const py::handle item : value)
      items.append(ownCopy(py::reinterpret_borrow<py::object>(item)));
    return py::isinstance<py::tuple>(value) ? py::object(py::tuple(items)) : py::object(items);
  }
  if (!py::isinstance<py::dict>(value)) return value;
  py::dict entries;
  for (const auto& [key, item] : py::reinterpret_borrow<py::dict>(value))
    entries[key] = ownCopy(py::reinterpret_borrow<py::object>(item));
  return entries;
}

TaskStep moveStep(const py::object& goal, const py::object& name, const py::object& allowed) {
  TaskStep step = made(name, planner::MoveStep());
  step.goal = ownCopy(goal);
  step.allowed = ownCopy(allowed);
  return step;
}

planner::Waypoint makeWaypoint(const py::object& position, const py::object& orientation,
                               const py::object& rpy, const py::object& via) {
  planner::Waypoint made{vector3(position, "position")};
  if (!orientation.is_none() || !rpy.is_none())
    made.rotation = pose(position, orientation, rpy).rotation;
  if (!via.is_none()) made.via = vector3(via, "via");
  return made;
}

/// Waypoints, or rows of arrays: positions, with quaternions, or matrices.
std::vector<planner::Waypoint> waypointsOf(const py::object& poses) {
  std::vector<planner::Waypoint> made;
  for (const py::handle item : py::list(poses)) {
    if (py::isinstance<planner::Waypoint>(item)) {
      made.push_back(item.cast<const planner::Waypoint&>());
      continue;
    }
    const collision::Pose at = pose(item, "poses");
    made.push_back({at.translation});
    if (py::len(item) != 3) made.back().rotation = at.rotation;
  }
  if (made.empty()) throw py::value_error("poses is empty; at least one is expected");
  return made;
}

TaskStep lineStep(const std::string& frame, const py::object& by, const py::object& orientation,
                  const py::object& rpy, const py::object& poses, const py::object& relative_to,
                  double position_tolerance, double angle_tolerance, const py::object& speed,
                  const py::object& name, const py::object& allowed) {
  planner::LineStep line;
  line.frame = frame;
  const bool turns = !orientation.is_none() || !rpy.is_none();
  if (poses.is_none() == (by.is_none() && !turns))
    throw py::value_error(
        poses.is_none()
            ? "the line goes nowhere; by, the way from here (x, y, z) [m], or poses are "
              "expected"
            : "by or a rotation stands beside poses; one of them is expected");
  if (!by.is_none()) line.by = vector3(by, "by");
  if (turns) line.turn = pose(py::none(), orientation, rpy).rotation;
  if (!poses.is_none()) line.poses = waypointsOf(poses);
  if (poses.is_none() && !turns && !(line.by.norm() > 0))
    throw py::value_error("by is of no length; the way from here (x, y, z) [m] is expected");
  if (!relative_to.is_none()) line.relative_to = word(relative_to, "relative_to");
  for (const auto& [value, what] : {std::pair(position_tolerance, "position_tolerance"),
                                    std::pair(angle_tolerance, "angle_tolerance")})
    if (!(value >= kLeastLineTolerance) || std::isinf(value))
      throw py::value_error(std::string(what) + " is " + text(value) + "; at least " +
                            text(kLeastLineTolerance) + " is expected");
  line.position_tolerance = position_tolerance;
  line.angle_tolerance = angle_tolerance;
  if (!speed.is_none()) line.speed = number(speed, "speed");
  if (!(line.speed > 0))
    throw py::value_error("speed is " + text(line.speed) + "; a number above 0 is expected [m/s]");
  TaskStep step = made(name, std::move(line));
  step.allowed = ownCopy(allowed);
  return step;
}

TaskStep loadedLine(const py::object& file, const py::object& frame, const py::object& name) {
  std::vector<std::string> warnings;
  planner::LineStep line = planner::loadWaypoints(
      fileName(file, "file"), frame.is_none() ? std::string() : word(frame, "frame"), warnings);
  for (const std::string& warning : warnings) warn(warning);
  return made(name, std::move(line));
}

TaskStep attachStep(const std::string& object, const std::string& link,
                    const std::vector<std::string>& touch_links, const py::object& name) {
  return made(name, planner::AttachStep{object, link, touch_links});
}

TaskStep detachStep(const std::string& object, const py::object& name) {
  return made(name, planner::DetachStep{object});
}

using NamePairs = std::vector<std::pair<std::string, std::string>>;

planner::Step stepOf(const planner::Problem& problem, const TaskStep& given) {
  planner::Step step = given.step;
  step.name = given.name;
  if (auto* move = std::get_if<planner::MoveStep>(&step.action)) {
    const std::vector<FramePose> poses = framePoses(given.goal);
    // By names, looked up when the step begins; what a problem has looked up stays where it is.
    if (!poses.empty() &&
        std::none_of(poses.begin(), poses.end(), [](const FramePose& p) { return p.found; }))
      for (const FramePose& pose : poses) move->poses.push_back(pose.given);
    else
      move->goal = goalOf(problem, given.goal);
  }
  for (const py::handle item : py::list(given.allowed)) {
    const NamePairs pairs = namePairs(problem, item, "allowed");
    step.allowed.insert(step.allowed.end(), pairs.begin(), pairs.end());
  }
  return step;
}

std::string lineOfStep(const TaskStep& self) {
  return "<leeway.TaskStep: " + std::string(kindOf(self)) +
         (self.name.empty() ? "" : " '" + self.name + "'") + ">";
}

void definePathStep(py::module_& module) {
  using planner::PathStep;
  py::class_<PathStep> step(module, "PathStep", "The stretch of a path that is a task's step.");
  step.def_readonly("name", &PathStep::name, "The step's name.");
  step.def_readonly("first", &PathStep::first, "Its first waypoint.");
  step.def_readonly("last", &PathStep::last,
                    "Its last waypoint; the first one where nothing moves.");
  step.def_readonly(
      "deviation", &PathStep::deviation,
      "Of a line: the frame's origin is proven to be this near to its place on it, at "
      "any time [m].");
  step.def_readonly("turn", &PathStep::turn,
                    "Of a line: the frame is proven to be turned by no more from its rotation "
                    "there [rad].");
  defineConstant(
      step, "places",
      [](const PathStep& self) { return array(std::span<const double>(self.places)); },
      "Of a line: where each of the step's waypoints is on it. Number k of its poses, from 1, is "
      "at "
      "k, its beginning at 0; between waypoints the place moves at a constant rate.");
  step.def("__repr__", [](const PathStep& self) {
    return "<leeway.PathStep '" + self.name + "': waypoints " + std::to_string(self.first) +
           " to " + std::to_string(self.last) + ">";
  });
}

void defineWaypoint(py::module_& module) {
  using planner::Waypoint;
  const std::string init = "(position, orientation=None, rpy=None, *, via=None)";
  auto waypoint = defineClass<py::class_<Waypoint>>(
      module, "Waypoint", init,
      "A place on a line's way, for TaskStep.line(poses=): the position of the "
      "frame's origin [m], its rotation (orientation x y z w, or rpy [rad]; neither: "
      "as at the place before), and a point through which an arc goes there (via; "
      "None: straight).",
      makeWaypoint);
  defineCopiesOfConstant(waypoint);
  defineConstant(
      waypoint, "position", [](const Waypoint& self) { return array(self.position); },
      "Of the frame's origin: (3,) [m].");
  waypoint.def("__repr__", [](const Waypoint& self) {
    return "<leeway.Waypoint at (" + text(self.position.x()) + ", " + text(self.position.y()) +
           ", " + text(self.position.z()) + ")>";
  });
}

}  // namespace

void setSteps(planner::Problem& problem, const py::object& steps) {
  std::vector<planner::Step> made;
  std::map<std::string, int> unnamed;  // as problem files name them: "line", "line 2"
  std::set<std::string> taken;
  for (const py::handle item : steps.is_none() ? py::list() : py::list(steps))
    if (py::isinstance<TaskStep>(item)) taken.insert(item.cast<const TaskStep&>().name);
  for (const py::handle item : steps.is_none() ? py::list() : py::list(steps)) {
    if (!py::isinstance<TaskStep>(item))
      throw py::type_error(std::string("steps hold a ") + Py_TYPE(item.ptr())->tp_name +
                           "; TaskSteps are expected");
    const TaskStep& given = item.cast<const TaskStep&>();
    planner::Step& step = made.emplace_back(stepOf(problem, given));
    while (given.name.empty() && (step.name.empty() || taken.count(step.name) > 0)) {
      const int count = ++unnamed[kindOf(given)];
      step.name = kindOf(given) + (count == 1 ? "" : " " + std::to_string(count));
    }
    // As in files, a goal that is not a group state has the step's name.
    if (auto* move = std::get_if<planner::MoveStep>(&step.action);
        move != nullptr && move->poses.empty() && !py::isinstance<py::str>(given.goal))
      move->goal.name = step.name;
  }
  problem.steps = std::move(made);
}

py::object stepList(const planner::Problem& problem) {
  py::list steps;
  for (const planner::Step& step : problem.steps) {
    TaskStep shown{step.name, {{}, step.action, {}}};
    if (auto* move = std::get_if<planner::MoveStep>(&shown.step.action)) {
      py::list poses;
      for (const planner::FramePose& pose : move->poses) poses.append(FramePose{pose});
      shown.goal = move->poses.empty() ? goalObject(problem, move->goal) : py::object(poses);
      *move = {};
    }
    py::list pairs;
    for (const auto& [a, b] : step.allowed) pairs.append(py::make_tuple(a, b));
    shown.allowed = pairs;
    steps.append(shown);
  }
  return steps;
}

void defineTasks(py::module_& module) {
  definePathStep(module);
  defineWaypoint(module);
  py::class_<TaskStep> step(
      module, "TaskStep",
      "A step of a task: Problem(..., steps=[TaskStep.move(...), TaskStep.attach(...), ...]). "
      "Steps follow each other, each in the world as those before have left it. `name` is for "
      "messages; `allowed`: pairs that may touch during this step. What a step names is looked up "
      "when the task is planned.");
  defineCopiesOfConstant(step);
  defineStatic(step, "move", "(goal, *, name=None, allowed=[])",
               "To a goal, as Problem has it, by whatever path is found.", moveStep);
  defineStatic(
      step, "line",
      "(frame, by=None, *, orientation=None, rpy=None, poses=None, relative_to=None, "
      "position_tolerance=0.001, angle_tolerance=0.01, speed=None, name=None, allowed=[])",
      "A frame, link or held object goes straight and turns at a constant rate. by: (x, y, z) from "
      "where it is [m], and a turn, in the frame's own axes, or in those of `relative_to`: an "
      "object, frame or link, or 'world'. Or through poses, in the world or seen from "
      "`relative_to`: Waypoints, or an array of positions (n, 3), with quaternions (n, 7), or of "
      "matrices (n, 4, 4). At every time of the motion the frame is proven to be as near to its "
      "place on the line as the tolerances say [m, rad]. speed: of its origin on the trajectory, "
      "at most [m/s]; None: the joints' limits alone hold.",
      lineStep);
  defineStatic(
      step, "load_line", "(file, frame=None, *, name=None)",
      "A line through the poses of a file: .csv with columns x, y, z and qx, qy, qz, qw or "
      "roll, pitch, yaw; .yaml or .json. frame: where the file does not name it.",
      loadedLine);
  defineStatic(step, "attach", "(object, link, touch_links=[], *, name=None)",
               "A link takes hold of an object where it stands. It may touch the link and "
               "`touch_links`.",
               attachStep);
  defineStatic(step, "detach", "(object, *, name=None)",
               "A held object is let go of, and stays where it is.", detachStep);
  step.def_readonly("name", &TaskStep::name, "Its name; '': what it does.");
  defineConstant(step, "kind", kindOf, "'move', 'line', 'attach' or 'detach'.");
  step.def("__repr__", lineOfStep);
}

}  // namespace leeway::python
