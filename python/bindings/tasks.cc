// Tasks: steps one after the other, each in the world as those before have left it.

#include <algorithm>
#include <cmath>

#include "leeway/planner/task.h"
#include "leeway/robots/text.h"
#include "python/base/define.h"
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

TaskStep moveStep(const py::object& goal, const py::object& name, const py::object& allowed) {
  TaskStep step = made(name, planner::MoveStep());
  step.goal = goal;
  step.allowed = allowed;
  return step;
}

TaskStep lineStep(const std::string& frame, const py::object& by, const py::object& relative_to,
                  double position_tolerance, double angle_tolerance, const py::object& name,
                  const py::object& allowed) {
  planner::LineStep straight;
  straight.frame = frame;
  straight.by = vector3(by, "by");
  if (!(straight.by.norm() > 0))
    throw py::value_error("by is of no length; the way from here (x, y, z) [m] is expected");
  if (!relative_to.is_none()) straight.relative_to = relative_to.cast<std::string>();
  for (const auto& [value, what] : {std::pair(position_tolerance, "position_tolerance"),
                                    std::pair(angle_tolerance, "angle_tolerance")})
    if (!(value >= kLeastLineTolerance) || std::isinf(value))
      throw py::value_error(std::string(what) + " is " + text(value) + "; at least " +
                            text(kLeastLineTolerance) + " is expected");
  straight.position_tolerance = position_tolerance;
  straight.angle_tolerance = angle_tolerance;
  TaskStep step = made(name, std::move(straight));
  step.allowed = allowed;
  return step;
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
  step.def_readonly("deviation", &PathStep::deviation,
                    "Of a line: the frame's origin is proven to be this near to it [m].");
  step.def_readonly("turn", &PathStep::turn,
                    "Of a line: the frame is proven to turn by no more [rad].");
  step.def("__repr__", [](const PathStep& self) {
    return "<leeway.PathStep '" + self.name + "': waypoints " + std::to_string(self.first) +
           " to " + std::to_string(self.last) + ">";
  });
}

}  // namespace

void setSteps(planner::Problem& problem, const py::object& steps) {
  std::vector<planner::Step> made;
  std::map<std::string, int> unnamed;  // as problem files name them: "line", "line 2"
  for (const py::handle item : steps.is_none() ? py::list() : py::list(steps)) {
    if (!py::isinstance<TaskStep>(item))
      throw py::type_error(std::string("steps hold a ") + Py_TYPE(item.ptr())->tp_name +
                           "; TaskSteps are expected");
    const TaskStep& given = item.cast<const TaskStep&>();
    made.push_back(stepOf(problem, given));
    if (!given.name.empty()) continue;
    const int count = ++unnamed[kindOf(given)];
    made.back().name = kindOf(given) + (count == 1 ? "" : " " + std::to_string(count));
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
  py::class_<TaskStep> step(
      module, "TaskStep",
      "A step of a task: Problem(..., steps=[TaskStep.move(...), TaskStep.attach(...), ...]). "
      "Steps follow each other, each in the world as those before have left it. `name` is for "
      "messages; `allowed`: pairs that may touch during this step. What a step names is looked up "
      "when the task is planned.");
  defineCopiesOfConstant(step);
  defineStatic(step, "move", "(goal, *, name=None, allowed=[])",
               "To a goal, as Problem has it, by whatever path is found.", moveStep,
               py::arg("goal"), py::kw_only(), py::arg("name") = py::none(),
               py::arg("allowed") = py::list());
  defineStatic(step, "line",
               "(frame, by, *, relative_to=None, position_tolerance=0.001, angle_tolerance=0.01, "
               "name=None, allowed=[])",
               "The origin of a frame, link or held object moves along a straight line, and the "
               "frame does not turn. by: (x, y, z) from where it is [m], in the frame's own axes, "
               "or in those of `relative_to`: an object, frame or link, or 'world'. Every point of "
               "the motion is proven to be as near to the line as the tolerances say [m, rad].",
               lineStep, py::arg("frame"), py::arg("by"), py::kw_only(),
               py::arg("relative_to") = py::none(), py::arg("position_tolerance") = 1e-3,
               py::arg("angle_tolerance") = 1e-2, py::arg("name") = py::none(),
               py::arg("allowed") = py::list());
  defineStatic(step, "attach", "(object, link, touch_links=[], *, name=None)",
               "A link takes hold of an object where it stands. It may touch the link and "
               "`touch_links`.",
               attachStep, py::arg("object"), py::arg("link"),
               py::arg("touch_links") = std::vector<std::string>(), py::kw_only(),
               py::arg("name") = py::none());
  defineStatic(step, "detach", "(object, *, name=None)",
               "A held object is let go of, and stays where it is.", detachStep, py::arg("object"),
               py::kw_only(), py::arg("name") = py::none());
  step.def_readonly("name", &TaskStep::name, "Its name; '': what it does.");
  defineConstant(step, "kind", kindOf, "'move', 'line', 'attach' or 'detach'.");
  step.def("__repr__", lineOfStep);
}

}  // namespace leeway::python
