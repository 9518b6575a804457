#include "leeway/planner/trajectory.h"

#include <cmath>

#include "leeway/planner/path_io.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/plan.h"

namespace leeway::python {
namespace {

/// More rows than this are a mistake in the period.
constexpr double kMostRows = 1e7;

struct Trajectory {
  Result result;
  planner::Trajectory value;
  double period;

  std::size_t size() const { return static_cast<std::size_t>(value.space().size()); }
};

/// 0, period, 2 period, ..., and the end.
std::vector<double> sampleTimes(const Trajectory& trajectory) {
  std::vector<double> times;
  const double end = trajectory.value.duration();
  for (double i = 0; i * trajectory.period < end; ++i) times.push_back(i * trajectory.period);
  times.push_back(end);
  return times;
}

/// What is asked of a trajectory at a time.
using Value = void (planner::Trajectory::*)(double, std::span<double>) const;

py::array_t<double> sampled(const Trajectory& self, std::span<const double> times,
                            std::vector<py::ssize_t> shape, Value value) {
  std::vector<double> values(times.size() * self.size());
  released([&] {
    for (std::size_t i = 0; i < times.size(); ++i)
      (self.value.*value)(times[i], {&values[i * self.size()], self.size()});
  });
  shape.push_back(static_cast<py::ssize_t>(self.size()));
  return array(std::move(values), std::move(shape));
}

py::array_t<double> sampled(const Trajectory& self, Value value) {
  const std::vector<double> times = sampleTimes(self);
  return sampled(self, times, {static_cast<py::ssize_t>(times.size())}, value);
}

template <Value kValue>
py::array_t<double> asked(const Trajectory& self, const py::object& time) {
  const Rows times = scalars(time, "time");
  return sampled(self, times.values, times.shape, kValue);
}

}  // namespace

std::optional<planner::Path> motionOfTrajectory(const py::object& object) {
  if (!py::isinstance<Trajectory>(object)) return std::nullopt;
  const planner::Trajectory& trajectory = object.cast<const Trajectory&>().value;
  // Orientations do not move on cubics; their motion has no blends, and is a path of lines.
  if (trajectory.space().interpolation() == std::string(planner::kSpaceGeodesic))
    return object.cast<const Trajectory&>().result.value.path;
  return planner::motionOf(trajectory);
}

py::object trajectoryObject(const Result& result, double period) {
  if (!(period > 0) || std::isinf(period))
    throw py::value_error("period is " + text(period) + "; a positive time is expected");
  planner::Problem problem = *result.problem;
  // A condition of plan_where() was asked on the edges: a blend may lead through what it refuses.
  if (!result.value.certificate.conditions.empty())
    problem.execution.corners = planner::Corners::kStop;
  planner::Trajectory made =
      released([&] { return planner::trajectoryOf(problem, result.value.path); });
  if (made.duration() / period > kMostRows)
    throw py::value_error("period is " + text(period) + "; the trajectory takes " +
                          text(made.duration()) + " s: more than ten million rows");
  return py::cast(Trajectory{result, std::move(made), period});
}

void defineTrajectory(py::module_& module) {
  py::class_<Trajectory> trajectory(
      module, "Trajectory",
      "A path with times: it follows the certified edges, or proven blends at corners. Between "
      "times of `knots` joints move on cubics.");
  defineConstant(
      trajectory, "duration", [](const Trajectory& self) { return self.value.duration(); }, "[s]");
  defineConstant(
      trajectory, "times",
      [](const Trajectory& self) {
        const std::vector<double> times = sampleTimes(self);
        return array(std::span<const double>(times));
      },
      "0, period, ... and the end: (n,) [s].");
  defineConstant(
      trajectory, "positions",
      [](const Trajectory& self) { return sampled(self, &planner::Trajectory::configuration); },
      "At `times`: (n, joints) [rad or m].");
  defineConstant(
      trajectory, "velocities",
      [](const Trajectory& self) { return sampled(self, &planner::Trajectory::velocity); },
      "At `times`: (n, joints) [rad/s or m/s].");
  defineConstant(
      trajectory, "accelerations",
      [](const Trajectory& self) { return sampled(self, &planner::Trajectory::acceleration); },
      "At `times`: (n, joints) [rad/s^2 or m/s^2].");
  defineConstant(
      trajectory, "knots",
      [](const Trajectory& self) {
        const std::vector<double> knots = self.value.knots();
        return array(std::span<const double>(knots));
      },
      "Times at which acceleration or its derivative jumps: (n,) [s].");
  defineConstant(
      trajectory, "waypoint_times",
      [](const Trajectory& self) { return array(self.value.times()); },
      "When each waypoint is passed, or the middle of its blend: (waypoints,) [s].");
  defineConstant(
      trajectory, "blends", [](const Trajectory& self) { return self.value.cutCorners().size(); },
      "How many corners are blended.");
  define(trajectory, "position", "(self, time)",
         "Configurations at times (...,) [s]: (..., joints); held before 0 and after the end.",
         asked<&planner::Trajectory::configuration>);
  define(trajectory, "velocity", "(self, time)", "Velocities at times (...,) [s]: (..., joints).",
         asked<&planner::Trajectory::velocity>);
  define(trajectory, "acceleration", "(self, time)",
         "Accelerations at times (...,) [s]: (..., joints).",
         asked<&planner::Trajectory::acceleration>);
  define(trajectory, "save", "(self, file)",
         "Writes times, positions, velocities and accelerations, every period and at knots: .json, "
         ".yaml (both without accelerations that jump) or .csv. Whole or not at all.",
         [](const Trajectory& self, const py::object& file) {
           const std::string path = fileName(file, "file");
           const Trajectory held = self;
           released([&] {
             planner::writeTrajectory(path, *held.result.problem, held.result.value, held.value,
                                      held.period);
           });
         });
  trajectory.def("__repr__", [](const Trajectory& self) {
    return "<leeway.Trajectory of " + text(self.value.duration()) + " s, " +
           std::to_string(self.value.waypoints().size()) + " waypoints>";
  });
}

}  // namespace leeway::python
