#include "leeway/planner/replanner.h"

#include <cmath>
#include <set>
#include <string>

#include "python/base/busy.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/deforming.h"
#include "python/bindings/plan.h"
#include "python/bindings/scene.h"
#include "python/bindings/settings.h"
#include "python/bindings/view.h"
#include "python/bindings/world.h"
#include "python/execution/joint_errors.h"
#include "python/execution/seen_cloud.h"

namespace leeway::python {
namespace {

using planner::ReplanResult;
using planner::ReplanStep;

/// A Replanner of one thread at a time: `busy` is read and written with the interpreter's lock
/// held.
struct Execution {
  Problem problem;
  py::object stop = py::none();
  Interrupt* interrupt = nullptr;  ///< of the step that runs
  std::unique_ptr<planner::Replanner> replanner;
  bool busy = false;
  std::set<std::string> turned = {};  ///< objects, see seenPose()

  std::size_t size() const { return problem.size(); }
};

constexpr char kBusyReplanner[] = "another call is using this Replanner";

py::array_t<double> timedPoints(std::span<const planner::TimedPoint> points, std::size_t columns) {
  std::vector<double> values;
  for (const planner::TimedPoint& point : points) {
    values.push_back(point.time);
    values.insert(values.end(), point.position.begin(), point.position.end());
  }
  return array(std::move(values),
               {static_cast<py::ssize_t>(points.size()), static_cast<py::ssize_t>(columns + 1)});
}

std::unique_ptr<Execution> makeExecution(const py::args& args, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  auto made = std::make_unique<Execution>();
  if (keywords.contains("stop")) made->stop = keywords.attr("pop")("stop");
  py::object errors = py::none();
  if (keywords.contains("joint_errors")) errors = keywords.attr("pop")("joint_errors");
  made->problem = problemOf("Replanner", args, keywords, true);
  noMore("Replanner", keywords);
  requireGoal(made->problem);
  const std::shared_ptr<const planner::Problem> value = made->problem.value();
  planner::ReplanOptions options;
  options.joint_errors = jointErrors(errors, made->size());
  options.stop = [self = made.get()] { return self->interrupt != nullptr && (*self->interrupt)(); };
  made->replanner = released([&] { return std::make_unique<planner::Replanner>(*value, options); });
  return made;
}

/// A step, and the problem whose names it uses.
struct Step {
  ReplanStep value;
  std::shared_ptr<const planner::Problem> problem;

  std::size_t columns() const { return problem->robot.variables.size(); }
};

/// An execution so far, or a whole one.
struct Executed {
  ReplanResult value;
  std::shared_ptr<const planner::Problem> problem;
  std::vector<ReplanStep> taken;  ///< of a whole one, for view()
};

Step step(Execution& self) {
  const Busy busy(self.busy, kBusyReplanner);
  Interrupt interrupt(self.stop);
  self.interrupt = &interrupt;
  struct Reset {
    Execution& of;
    ~Reset() { of.interrupt = nullptr; }
  } const reset{self};
  Step result{released([&] { return self.replanner->step(); }), self.problem.value()};
  interrupt.rethrow();
  return result;
}

void setVertices(Execution& self, const std::string& object, const py::object& vertices,
                 const py::object& time, const py::object& bound) {
  const Busy busy(self.busy, kBusyReplanner);
  const std::vector<Eigen::Vector3d> given = points(vertices, "vertices");
  const double speed_bound = speedBoundOf(bound);
  const double when = time.is_none() ? self.replanner->time() : number(time, "time");
  released([&] { self.replanner->setVertices(object, given, when, speed_bound); });
}

void setPose(Execution& self, const std::string& object, const py::object& given,
             const py::object& time, const py::object& bound, const py::object& turn_bound) {
  const Busy busy(self.busy, kBusyReplanner);
  const double speed = speedBoundOf(bound), turning = speedBoundOf(turn_bound, "turn_bound");
  const double when = time.is_none() ? self.replanner->time() : number(time, "time");
  const collision::Pose X_WO = seenPose(self.problem->world, object, given, when, self.turned);
  released([&] { self.replanner->setPose(object, X_WO, when, speed, turning); });
  if (isTurned(X_WO)) self.turned.insert(object);
}

void setCloud(Execution& self, const std::string& object, const py::object& points,
              const py::object& radius, const py::object& time, const py::object& bound,
              const py::object& given_pose, const py::object& thin, const py::object& most_balls,
              const py::object& carve, const py::object& carve_margin, const py::object& state) {
  const Busy busy(self.busy, kBusyReplanner);
  std::vector<double> place(self.replanner->state().begin(), self.replanner->state().end());
  if (!state.is_none()) place = numbers(state, "state", self.size());
  const std::shared_ptr<const planner::Problem> problem = self.problem.value();
  const double when = time.is_none() ? self.replanner->time() : number(time, "time");
  const CloudGiven seen =
      cloudGiven(*problem, {points, radius, given_pose, thin, most_balls, carve, carve_margin},
                 place, object, when, self.turned);
  const double speed_bound = speedBoundOf(bound);
  released([&] { self.replanner->setCloud(object, seen.cloud, when, speed_bound, seen.X_WO); });
  if (seen.X_WO && isTurned(*seen.X_WO)) self.turned.insert(object);
}

void setState(Execution& self, const py::object& state) {
  const Busy busy(self.busy, kBusyReplanner);
  self.replanner->setState(numbers(state, "state", self.size()));
}

/// A property that reads the replanner: not while another thread is in a step.
template <typename Read>
auto reading(Read read) {
  return [read](Execution& self) {
    const Busy busy(self.busy, kBusyReplanner);
    return read(self);
  };
}

Executed replan(const py::args& args, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  const auto take = [&](const char* name) -> py::object {
    if (!keywords.contains(name)) return py::none();
    return keywords.attr("pop")(name);
  };
  const py::object on_step = take("on_step"), stop = take("stop"), most = take("steps");
  const int steps = most.is_none() ? 0 : whole<int>(most, "steps");
  const Problem problem = problemOf("replan", args, keywords, true);
  noMore("replan", keywords);
  requireGoal(problem);
  if (!on_step.is_none() && PyCallable_Check(on_step.ptr()) == 0)
    throw py::type_error("on_step is no function; one of (step) is expected");
  Interrupt interrupt(stop);
  planner::ReplanOptions options;
  options.stop = interrupt.callback();
  std::vector<ReplanStep> all;
  const std::shared_ptr<const planner::Problem> value = problem.value();
  const auto told = [&](const ReplanStep& taken) {
    all.push_back(taken);
    if (on_step.is_none()) return;
    const py::gil_scoped_acquire locked;
    try {
      on_step(Step{taken, value});
    } catch (...) {
      interrupt.fail();
    }
  };
  ReplanResult result = released([&] { return planner::replan(*value, options, told, steps); });
  interrupt.rethrow();
  return {std::move(result), value, std::move(all)};
}

void defineStep(py::module_& module) {
  py::class_<Step> step_class(module, "Step",
                              "One step of an execution: from one look at the world to the next.");
  const auto property = constantsOf(step_class, &Step::value);
  property("index", &ReplanStep::index, "Counts from 0.");
  property("time", &ReplanStep::time, "Of the look at the world [s].");
  property(
      "decision", [](const ReplanStep& s) { return toString(s.decision); },
      "'plan' (a new path), 'follow', 'wait' (come to rest, or stand), 'evade' or 'unsafe' (as "
      "'wait', but nothing is certified).");
  property("why", &ReplanStep::why,
           "Why it waits, evades or is unsafe, in words; '' where it goes along a path.");
  property("certified", &ReplanStep::certified,
           "The motion, and the stop after it, are proven to keep all margins at every time.");
  property("exposed", &ReplanStep::exposed,
           "Not certified, because an obstacle may reach the robot where it stands: the motion is "
           "proven until it rests.");
  property("look_ahead", &ReplanStep::look_ahead,
           "For so long after the step going on, coming to rest, or standing is certified [s].");
  property(
      "lower", [](const ReplanStep& s) { return s.clearance.lower; },
      "The clearance over the whole step is at least this [m]. It may be below the margin of a "
      "pair, which `certified` proves.");
  property(
      "upper", [](const ReplanStep& s) { return s.clearance.upper; },
      "The least clearance is at most this [m].");
  property(
      "closest", [](const ReplanStep& s) { return pairObject(s.closest_a, s.closest_b); },
      "Names of the closest pair, or None.");
  property("path_held", &ReplanStep::path_held,
           "The rest of the path is certified in the world as seen.");
  property(
      "broken", [](const ReplanStep& s) { return pairObject(s.broken_a, s.broken_b); },
      "If not, the pair that broke it, or None.");
  property("reached", &ReplanStep::reached, "The motion ends in a goal.");
  property("remaining", &ReplanStep::remaining_s,
           "Duration of the rest of the path [s], at least; inf without a path.");
  property(
      "times",
      [](const ReplanStep& s) {
        py::dict times;
        times["update"] = s.update_s;
        times["certify"] = s.certify_s;
        times["plan"] = s.plan_s;
        times["clearance"] = s.clearance_s;
        return times;
      },
      "What it took [s]: {update, certify, plan, clearance}.");
  defineConstant(
      step_class, "motion",
      [](const Step& self) { return timedPoints(self.value.motion, self.columns()); },
      "Where to be when: (n, 1 + joints), the time [s] and the joints' values; between two rows at "
      "constant speed, whose changes keep the limits on acceleration and jerk.");
  defineConstant(
      step_class, "stop",
      [](const Step& self) { return timedPoints(self.value.stop, self.columns()); },
      "Rows after the motion, likewise, in which the robot comes to rest if no other step is "
      "taken; "
      "(0, 1 + joints) where it rests.");
  defineConstant(
      step_class, "log", [](const Step& self) { return logLine(*self.problem, self.value); },
      "The step as one line of a log, without the line's end: JSON with what was observed and the "
      "motion, for verify_log().");
  step_class.def("__repr__", [](const Step& self) {
    return "<leeway.Step " + std::to_string(self.value.index) + " at " + text(self.value.time) +
           " s: " + toString(self.value.decision) +
           (self.value.certified ? ", certified>" : ", not certified>");
  });
}

void defineExecuted(py::module_& module) {
  py::class_<Executed> executed(module, "Executed",
                                "A whole execution. True if the goal is reached, every step "
                                "certified.");
  const auto property = constantsOf(executed, &Executed::value);
  property(
      "status", [](const ReplanResult& r) { return toString(r.status); },
      "'reached', 'exposed' (an obstacle may reach the robot, which stands), 'unsafe', 'timeout', "
      "'stopped' or 'nothing_checked'.");
  property(
      "trajectory", [](const ReplanResult& r) { return timedPoints(r.trajectory, r.names.size()); },
      "What was executed: (n, 1 + joints), the time [s] and the joints' values; empty for "
      "Replanner.executed.");
  property(
      "joint_names", [](const ReplanResult& r) { return listOf(r.names); },
      "Names of the trajectory's columns after the first.");
  property("steps", &ReplanResult::steps, "Steps taken.");
  property("replans", &ReplanResult::replans, "Paths planned besides the first.");
  property("certified", &ReplanResult::certified, "Every step was.");
  property(
      "lower", [](const ReplanResult& r) { return r.clearance.lower; },
      "The clearance of all steps is at least this [m].");
  property(
      "upper", [](const ReplanResult& r) { return r.clearance.upper; },
      "The least clearance is at most this [m].");
  defineConstant(
      executed, "log", [](const Executed& self) { return logLine(*self.problem, self.value); },
      "The last line of a log, after those of the steps (Step.log), without the line's end.");
  define(executed, "view", "(self, file, *, visual=False, stop=None)",
         std::string("Writes what `leeway view` shows of this execution: the motion among the "
                     "obstacles as they moved, and its clearance. ") +
             kViewDoc,
         [](const Executed& self, const py::object& file, bool visual, const py::object& stop) {
           if (self.taken.empty())
             throw py::value_error("view: there is no step to show; a whole execution is expected");
           const Executed held = self;
           view::PageOptions chosen;
           chosen.visual = visual;
           writeView(file, stop, std::move(chosen),
                     [&](const std::string& path, const view::PageOptions& options) {
                       view::writePage(path, *held.problem, held.taken, held.value.status, options);
                     });
         });
  executed.def("__bool__", [](const Executed& self) {
    return self.value.status == planner::ReplanStatus::kReached && self.value.certified;
  });
  executed.def("__repr__", [](const Executed& self) {
    return std::string("<leeway.Executed: ") + toString(self.value.status) + ", " +
           std::to_string(self.value.steps) + " steps, " + std::to_string(self.value.replans) +
           " replans" + (self.value.certified ? ">" : ", not certified>");
  });
}

}  // namespace

void defineReplanner(py::module_& module) {
  defineStep(module);
  defineExecuted(module);
  const std::string init =
      "(robot, world=None, start=None, goal=None, *, joint_errors=0, stop=None, **settings)";
  auto execution = defineClass<py::class_<Execution>>(
      module, "Replanner", init,
      "Executes a problem among obstacles that move, step by step; also "
      "Replanner(problem, **settings). Each step is proven against all that the "
      "obstacles can do in it. `joint_errors`: how far joints are from the motion at most [rad or "
      "m]; a state that is set within it changes nothing. For one thread at a time.",
      makeExecution);
  define(execution, "step", "(self)",
         "Decides and takes the next step. Costs as much as planning; a signal or `stop` ends "
         "planning.",
         step);
  define(execution, "set_vertices", "(self, name, vertices, time=None, speed_bound=None)",
         "The vertices of an obstacle (n, 3) [m] as seen at `time` (default: now) [s]; none is "
         "faster than `speed_bound` [m/s] from then on. Replaces its motion for good.",
         setVertices);
  define(
      execution, "set_pose", "(self, name, pose, time=None, speed_bound=None, turn_bound=None)",
      "The pose of an object with a motion (World.set_motion()) as seen at `time` (default: now) "
      "[s]: x y z of one that is not turned, or with a quaternion x y z w behind it, or (4, 4). "
      "From then on its origin is "
      "not faster than `speed_bound` [m/s], and it turns by at most `turn_bound` [rad/s]. "
      "Replaces its motion for good.",
      setPose);
  define(execution, "set_cloud",
         std::string("(self, name, points, radius, time=None, speed_bound=None, *, ") +
             kCloudSignature,
         std::string(kCloudDoc) + " Default: `time` now, `state` the robot's now.", setCloud);
  defineProperty(
      execution, "state", "The robot's state now: (joints,); set it to where the robot truly is.",
      reading([](Execution& self) { return constant(array(self.replanner->state())); }), setState);
  defineConstant(execution, "time", reading([](Execution& self) { return self.replanner->time(); }),
                 "Of the next look at the world [s].");
  defineConstant(execution, "path", reading([](Execution& self) {
                   return array(self.replanner->path(), self.size());
                 }),
                 "The rest of the path: (n, joints); (0, joints) without one.");
  defineConstant(execution, "reached",
                 reading([](Execution& self) { return self.replanner->reached(); }),
                 "The state is in a goal, and the path is used up.");
  defineConstant(execution, "replans",
                 reading([](Execution& self) { return self.replanner->replans(); }),
                 "Paths planned besides the first.");
  defineConstant(execution, "executed", reading([](Execution& self) {
                   return Executed{self.replanner->executed(), self.problem.value(), {}};
                 }),
                 "The steps so far: an Executed without its trajectory.");
  defineConstant(execution, "scene", reading([](Execution& self) {
                   return Scene(self.problem, self.replanner->scene());
                 }),
                 "The Scene of the last look: constant, for any thread.");
  execution.def("__repr__", [](Execution& self) {
    return self.busy ? std::string("<leeway.Replanner, in a step>")
                     : "<leeway.Replanner at " + text(self.replanner->time()) + " s>";
  });
  define(module, "replan",
         "(robot, world=None, start=None, goal=None, *, on_step=None, steps=None, stop=None, "
         "**settings)",
         "Executes a problem until a goal is reached, a step is not certified, or its duration is "
         "over; also replan(problem, **settings). Calls on_step(step) after each; `steps` limits "
         "their number.",
         replan);
}

}  // namespace leeway::python
