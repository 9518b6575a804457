#include "leeway/planner/guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "python/base/busy.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/deforming.h"
#include "python/bindings/plan.h"
#include "python/bindings/settings.h"
#include "python/bindings/world.h"
#include "python/execution/joint_errors.h"
#include "python/execution/seen_cloud.h"

namespace leeway::python {
namespace {

constexpr char kBusyGuard[] = "another call is using this Guard";

/// A Guard of one thread at a time: `busy` is read and written with the interpreter's lock held.
struct Guarding {
  Problem problem;
  std::unique_ptr<planner::Guard> guard;
  bool busy = false;
  std::set<std::string> turned = {};  ///< objects, see seenPose()

  std::size_t size() const { return problem.size(); }
};

/// An answer that outlives the next call.
struct Answer {
  planner::GuardAnswer value;
  std::vector<double> start, motion;
  std::string a, b, joint;
};

Answer copyOf(const planner::GuardAnswer& answer, const Problem& problem) {
  Answer copy{answer,
              {answer.start.begin(), answer.start.end()},
              {answer.motion.begin(), answer.motion.end()},
              std::string(answer.a),
              std::string(answer.b),
              {}};
  if (answer.variable >= 0) {
    const planner::PlannedRobot& robot = problem.value()->robot;
    const int v = robot.variables[static_cast<std::size_t>(answer.variable)];
    copy.joint = robot.model->variables[static_cast<std::size_t>(v)].name;
  }
  return copy;
}

std::unique_ptr<Guarding> makeGuard(const py::args& args, const py::kwargs& kwargs) {
  py::dict keywords = kwargs.attr("copy")();
  const auto take = [&](const char* name) -> py::object {
    if (!keywords.contains(name)) return py::none();
    return keywords.attr("pop")(name);
  };
  auto made = std::make_unique<Guarding>();
  planner::GuardOptions options;
  const auto set = [&](const char* name, double& value) {
    if (const py::object given = take(name); !given.is_none()) value = number(given, name);
  };
  set("period", options.period);
  set("point_error", options.point_error);
  set("horizon", options.horizon);
  if (const py::object given = take("most_setpoints"); !given.is_none())
    options.most_setpoints = whole<int>(given, "most_setpoints");
  if (const py::object given = take("work"); !given.is_none())
    options.work = whole<std::int64_t>(given, "work");
  const py::object errors = take("joint_errors");
  made->problem = problemOf("Guard", args, keywords, true);
  noMore("Guard", keywords);
  options.joint_errors = jointErrors(errors, made->size());
  const std::shared_ptr<const planner::Problem> value = made->problem.value();
  made->guard = released([&] { return std::make_unique<planner::Guard>(*value, options); });
  return made;
}

/// Numbers of a policy. If one is not finite, the guard gets that number alone, and stops the
/// robot: this is not an error of the program.
std::vector<double> given(const py::object& value, const char* name, std::size_t columns,
                          int axes) {
  if (value.is_none()) return {};
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  for (py::ssize_t i = 0; array && i < array.size(); ++i)
    if (!std::isfinite(array.data()[i])) return {array.data()[i]};
  return rows(value, name, columns, axes).values;
}

/// Coefficients of polynomials, one row a planned variable; see given().
std::vector<double> coefficients(const py::object& value, std::size_t variables) {
  const py::array array = py::array::ensure(value);
  if (!array || array.ndim() != 2 || array.shape(0) != static_cast<py::ssize_t>(variables))
    throw py::value_error(
        "polynomials: an array of shape (" + std::to_string(variables) +
        ", terms) is expected, the coefficients of 1, t, t^2, ... for each planned variable");
  return given(value, "polynomials", static_cast<std::size_t>(array.shape(1)), 2);
}

Answer check(Guarding& self, const py::object& setpoints, const py::object& position,
             const py::object& velocity, const py::object& time, const py::object& polynomials,
             const py::object& duration) {
  const Busy busy(self.busy, kBusyGuard);
  const std::vector<double> points = given(setpoints, "setpoints", self.size(), 2);
  const std::vector<double> place = given(position, "position", self.size(), 1);
  const std::vector<double> rate = given(velocity, "velocity", self.size(), 1);
  if (polynomials.is_none() != duration.is_none() ||
      (!polynomials.is_none() && !setpoints.is_none()))
    throw py::value_error("setpoints, or polynomials with their duration, are expected");
  std::vector<double> curves;
  if (!polynomials.is_none()) curves = coefficients(polynomials, self.size());
  planner::GuardRequest request{.setpoints = points,
                                .polynomials = curves,
                                .position = place,
                                .velocity = rate,
                                .time = std::nullopt};
  if (!time.is_none()) request.time = number(time, "time");
  if (!duration.is_none()) request.duration = number(duration, "duration");
  released([&] { self.guard->check(request); });
  return copyOf(self.guard->answer(), self.problem);
}

/// Whether numbers of a sensor are finite. If one is not, the guard refuses the observation: this
/// is not an error of the program. True for what is not numbers.
bool areFinite(const py::object& value) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  return !array || std::all_of(array.data(), array.data() + array.size(),
                               [](double x) { return std::isfinite(x); });
}

double timeOf(const py::object& time) {
  return areFinite(time) ? number(time, "time") : std::numeric_limits<double>::quiet_NaN();
}

const char* setVerticesOf(Guarding& self, const std::string& object, const py::object& vertices,
                          const py::object& time, const py::object& bound) {
  const Busy busy(self.busy, kBusyGuard);
  std::vector<Eigen::Vector3d> given;  // of no use where not finite
  if (areFinite(vertices)) given = points(vertices, "vertices");
  const double when = timeOf(time), speed_bound = speedBoundOf(bound);
  return planner::toString(
      released([&] { return self.guard->setVertices(object, given, when, speed_bound); }));
}

/// The answer's word. What is taken, also if it jumped, is what the guard has seen last.
const char* judged(Guarding& self, const std::string& object, const collision::Pose& X_WO,
                   planner::Observation answer) {
  const bool is_taken =
      answer == planner::Observation::kTaken || answer == planner::Observation::kJumped;
  if (is_taken && isTurned(X_WO)) self.turned.insert(object);
  return planner::toString(answer);
}

const char* setPoseOf(Guarding& self, const std::string& object, const py::object& given,
                      const py::object& time, const py::object& bound,
                      const py::object& turn_bound) {
  const Busy busy(self.busy, kBusyGuard);
  const double when = timeOf(time), speed = speedBoundOf(bound);
  collision::Pose X_WO;
  if (areFinite(given))
    X_WO =
        seenPose(self.problem->world, object, given, std::isfinite(when) ? when : 0, self.turned);
  else
    X_WO.translation.setConstant(std::numeric_limits<double>::quiet_NaN());
  const double turning = speedBoundOf(turn_bound, "turn_bound");
  const planner::Observation answer =
      released([&] { return self.guard->setPose(object, X_WO, when, speed, turning); });
  return judged(self, object, X_WO, answer);
}

const char* setCloudOf(Guarding& self, const std::string& object, const py::object& points,
                       const py::object& radius, const py::object& time, const py::object& bound,
                       const py::object& given_pose, const py::object& thin,
                       const py::object& most_balls, const py::object& carve,
                       const py::object& carve_margin, const py::object& state) {
  const Busy busy(self.busy, kBusyGuard);
  std::vector<double> place;
  if (!state.is_none()) place = numbers(state, "state", self.size());
  const std::shared_ptr<const planner::Problem> problem = self.problem.value();
  const bool is_sensible = given_pose.is_none() || areFinite(given_pose);
  // Without a pose nothing can be carved out, and the guard refuses the observation.
  const py::object sure = is_sensible ? given_pose : py::none();
  const py::object names = is_sensible ? carve : py::tuple();
  const py::object margin = is_sensible ? carve_margin : py::float_(0.0);
  const double when = timeOf(time);
  CloudGiven seen = cloudGiven(*problem, {points, radius, sure, thin, most_balls, names, margin},
                               place, object, std::isfinite(when) ? when : 0, self.turned);
  if (!is_sensible) {
    seen.X_WO.emplace();
    seen.X_WO->translation.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  const double speed = speedBoundOf(bound);
  const planner::Observation answer =
      released([&] { return self.guard->setCloud(object, seen.cloud, when, speed, seen.X_WO); });
  return judged(self, object, seen.X_WO.value_or(collision::Pose()), answer);
}

void lookAt(Guarding& self, const py::object& time) {
  const Busy busy(self.busy, kBusyGuard);
  const double when = time.is_none() ? self.guard->nextTime() : number(time, "time");
  released([&] { self.guard->look(when); });
}

void defineAnswer(py::module_& module) {
  py::class_<Answer> answer(module, "GuardAnswer",
                            "What a Guard lets pass. True if all setpoints pass.");
  const auto property = constantsOf(answer, &Answer::value);
  property("passed", &planner::GuardAnswer::passed,
           "How many setpoints, from the first on, may be executed.");
  property("certified", &planner::GuardAnswer::certified,
           "`motion` is proven: what passed, and the stop after it.");
  property("on_polynomials", &planner::GuardAnswer::on_polynomials,
           "To so many of the first rows of `motion` the robot follows polynomials.");
  property("time", &planner::GuardAnswer::time, "When `motion` begins [s].");
  property("goes_on", &planner::GuardAnswer::goes_on,
           "`motion` is what was left of the last answer's: no new stop is proven.");
  property(
      "reason", [](const planner::GuardAnswer& a) { return planner::toString(a.reason); },
      "'passed', or why the next setpoint does not: 'limit', 'not_free', 'not_certified', 'work', "
      "'stale', 'jumped' or 'invalid'.");
  property("in_stop", &planner::GuardAnswer::in_stop,
           "The reason concerns the stop after that setpoint, not the way to it.");
  property(
      "limit",
      [](const planner::GuardAnswer& a) -> py::object {
        return a.variable < 0 ? py::object(py::none()) : py::str(planner::toString(a.limit));
      },
      "'position', 'velocity', 'acceleration', 'jerk', or None.");
  property("value", &planner::GuardAnswer::value,
           "What would break `limit` [rad or m, per s, s^2 or s^3].");
  property("allowed", &planner::GuardAnswer::allowed, "The limit that would be broken.");
  property("edges", &planner::GuardAnswer::edges, "Edges that were asked for.");
  property("queries", &planner::GuardAnswer::distance_queries,
           "Distance queries that were needed.");
  property("work", &planner::GuardAnswer::work, "What it cost, about a thousand a microsecond.");
  defineConstant(
      answer, "pair",
      [](const Answer& self) -> py::object {
        if (self.a.empty()) return py::none();
        return py::make_tuple(self.a, self.b.empty() ? py::object(py::none()) : py::str(self.b));
      },
      "Names of the pair that the reason concerns, or None.");
  defineConstant(
      answer, "joint",
      [](const Answer& self) -> py::object {
        return self.joint.empty() ? py::object(py::none()) : py::str(self.joint);
      },
      "Whose `limit` would be broken, or None.");
  defineConstant(
      answer, "start",
      [](const Answer& self) { return array(std::span<const double>(self.start)); },
      "Where `motion` begins: (joints,).");
  defineConstant(
      answer, "motion",
      [](const Answer& self) {
        const auto columns = static_cast<py::ssize_t>(self.start.size());
        return array(self.motion,
                     {static_cast<py::ssize_t>(self.motion.size()) / columns, columns});
      },
      "Setpoints, one a period after `time`: those that passed, then the stop: (n, joints).");
  answer.def("__bool__", [](const Answer& self) {
    return self.value.certified && self.value.reason == planner::GuardReason::kPassed;
  });
  answer.def("__repr__", [](const Answer& self) {
    return "<leeway.GuardAnswer: " + std::to_string(self.value.passed) + " passed, " +
           planner::toString(self.value.reason) +
           (self.value.certified ? ", certified>" : ", not certified>");
  });
}

}  // namespace

void defineGuard(py::module_& module) {
  defineAnswer(module);
  const std::string init =
      "(robot, world=None, start=None, goal=None, *, period=0.02, joint_errors=0, point_error=0, "
      "most_setpoints=64, work=2000000, horizon=2, **settings)";
  auto guard = defineClass<py::class_<Guarding>>(
      module, "Guard", init,
      "Lets those setpoints pass that are proven free and within limits, with a proven stop "
      "after them; also Guard(problem, **settings). `period` between setpoints [s]; "
      "`joint_errors` and `point_error`: how far joints [rad or m] and points of the robot [m] "
      "are off at most; `work`: what a call may cost; `horizon`: for how long after look() "
      "obstacles are bounded [s]. For one thread at a time.",
      makeGuard);
  define(guard, "check",
         "(self, setpoints=None, position=None, velocity=None, time=None, *, polynomials=None, "
         "duration=None)",
         "What passes of setpoints (n, joints), and the stop after it. `position`, `velocity`: "
         "(joints,), where the robot was measured (default: on the last answer's motion). `time` "
         "[s]: default next_time. Without setpoints it stops. In place of setpoints: `polynomials` "
         "(joints, terms), the coefficients of 1, t, t^2, ... with t from when the motion begins "
         "to `duration`, a whole number of periods [s].",
         check);
  define(guard, "set_vertices", "(self, name, vertices, time, speed_bound=None)",
         "The vertices of a deforming obstacle (n, 3) [m] as seen at `time` [s]; none is faster "
         "than `speed_bound` [m/s] from then on. Returns 'taken', 'jumped', 'invalid' or 'late'. "
         "Counts from the next look() on.",
         setVerticesOf);
  define(guard, "set_pose", "(self, name, pose, time, speed_bound=None, turn_bound=None)",
         "The pose of an object with a motion (World.set_motion()) as seen at `time` [s]: x y z of "
         "one that is not turned, or with a quaternion x y z w behind it, or (4, 4). From then on "
         "its origin is not faster than "
         "`speed_bound` [m/s], and it turns by at most `turn_bound` [rad/s]. The rest as for "
         "set_vertices().",
         setPoseOf);
  define(guard, "set_cloud",
         std::string("(self, name, points, radius, time, speed_bound=None, *, ") + kCloudSignature,
         std::string(kCloudDoc) +
             " Returns 'taken', 'invalid' or 'late'; a cloud never jumps. Nothing passes until the "
             "next look().",
         setCloudOf);
  define(guard, "look", "(self, time=None)",
         "Bounds where obstacles can be from `time` on (default: next_time) [s].", lookAt);
  defineConstant(
      guard, "next_time",
      [](Guarding& self) {
        const Busy busy(self.busy, kBusyGuard);
        return self.guard->nextTime();
      },
      "The time of a call without one [s].");
  guard.def("__repr__", [](Guarding& self) {
    return self.busy ? std::string("<leeway.Guard, in a call>")
                     : "<leeway.Guard at " + text(self.guard->nextTime()) + " s>";
  });
}

}  // namespace leeway::python
