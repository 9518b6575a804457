#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/collision/time_to_impact.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/link_motion.h"
#include "python/base/at.h"
#include "python/base/busy.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/scene.h"

namespace leeway::python {
namespace {

/// A body of the scene that a link carries, what bounds its motion, and where the last look saw it.
struct Mover {
  int body, link;
  robots::RelativeMotion motion;
  collision::PointMotion bounds = {};
  robots::Pose X_WL = {};
};

/// Time to impact of a robot in a scene. One thread at a time: `busy` is read and written with the
/// interpreter's lock held.
struct Monitor {
  Scene scene;
  collision::Workspace workspace;
  collision::ImpactSchedule schedule;
  std::vector<Mover> movers;
  std::vector<double> velocity_limits, acceleration_limits;  // one a variable of the model
  std::vector<double> q;                                     // the whole configuration
  double last_time = -std::numeric_limits<double>::infinity();
  bool busy = false;

  Monitor(Scene of, std::vector<double> velocities, std::vector<double> accelerations);
  const robots::Model& model() const { return scene.compiled->model(); }
};

struct Report {
  double safe_until;
  std::pair<std::string, std::string> next;
  std::vector<std::pair<std::string, std::string>> imminent;
  int violated;
};

/// A ball around all shapes of a body, in its frame.
void boundingBall(const collision::Body& body, Eigen::Vector3d& center, double& radius) {
  center.setZero();
  for (const collision::Geometry& geometry : body.geometries)
    center += geometry.X_BG * geometry.shape.boundingCenter() /
              static_cast<double>(body.geometries.size());
  radius = 0;
  for (const collision::Geometry& geometry : body.geometries)
    radius = std::max(radius, (geometry.X_BG * geometry.shape.boundingCenter() - center).norm() +
                                  geometry.shape.boundingRadius());
  radius *= 1 + 1e-12;  // outwards, above the rounding of these lines
}

Monitor::Monitor(Scene of, std::vector<double> velocities, std::vector<double> accelerations)
    : scene(std::move(of)),
      workspace(scene.compiled->scene()),
      schedule(scene.compiled->scene()),
      velocity_limits(std::move(velocities)),
      acceleration_limits(std::move(accelerations)),
      q(scene.problem->start) {
  // Joints that are not planned stand where the start has them, which limits need not allow.
  std::vector<robots::VariableRange> ranges(q.size());
  for (std::size_t v = 0; v < q.size(); ++v) ranges[v] = {q[v], q[v]};
  const std::vector<robots::VariableRange> limits = robots::limitRanges(model());
  for (const int v : scene.compiled->space().variables()) ranges[at(v)] = limits[at(v)];
  const auto bodies = scene.compiled->scene().bodies();
  for (int body = 0; body < static_cast<int>(bodies.size()); ++body) {
    const int link = scene.compiled->bodyLink(body);
    if (link < 0) continue;
    Eigen::Vector3d center;
    double radius = 0;
    boundingBall(bodies[at(body)], center, radius);
    movers.push_back({.body = body,
                      .link = link,
                      .motion = robots::relativeMotion(model(), link, -1, center, radius, ranges)});
  }
}

constexpr char kBusyMonitor[] = "another thread is using this Monitor";

/// One number a planned joint, spread over the model's variables; 0 for those that stand.
std::vector<double> spread(const Scene& scene, const std::vector<double>& planned) {
  std::vector<double> all(scene.compiled->model().variables.size(), 0);
  scene.problem.robot().expand(planned, all);
  return all;
}

std::unique_ptr<Monitor> makeMonitor(const Scene& scene, const py::object& accelerations,
                                     const py::object& velocities) {
  if (const std::string nothing = scene.compiled->nothingChecked(); !nothing.empty())
    throw py::value_error("Monitor: nothing is checked: " + nothing);
  const planner::World& world = scene.problem->world;
  const auto refuse = [](const std::string& name, const char* how) {
    throw py::value_error("Monitor: '" + name + "' " + how +
                          "; obstacles that stand still are expected (a Guard follows others)");
  };
  for (const planner::Object& object : world.objects)
    if (object.motion) refuse(object.name, "moves");
  for (const planner::DeformingObstacle& obstacle : world.deforming)
    if (obstacle.motion || obstacle.speed_bound != 0) refuse(obstacle.object.name, "deforms");
  const Robot robot = scene.problem.robot();
  std::vector<double> velocity;
  if (velocities.is_none())
    for (const int variable : robot.space->variables())
      velocity.push_back(robot.model->variables[at(variable)].velocity);
  else
    velocity = numbers(velocities, "velocities", robot.size());
  const std::vector<double> acceleration = numbers(accelerations, "accelerations", robot.size());
  for (const double limit : acceleration)
    if (limit < 0) throw py::value_error("accelerations are below 0; limits are expected");
  for (const double limit : velocity)
    if (limit < 0) throw py::value_error("velocities are below 0; limits are expected");
  return std::make_unique<Monitor>(scene, spread(scene, velocity), spread(scene, acceleration));
}

/// Whether the body's points may have moved from its last pose to X_WL in `passed` seconds. One
/// that has moved farther broke the bounds by which its pairs were postponed.
bool mayHaveMoved(const Mover& mover, const robots::Pose& X_WL, double passed) {
  const Eigen::Vector3d center = X_WL * mover.motion.center_L - mover.X_WL * mover.motion.center_L;
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(mover.X_WL.rotation.transpose() * X_WL.rotation));
  const collision::PointMotion& of = mover.bounds;
  const double farthest =
      std::min(of.speed_cap * passed, (of.speed + of.acceleration * passed / 2) * passed);
  return center.norm() + turn.angle() * mover.motion.radius <= farthest;  // false for NaN
}

/// Where all bodies are, and how fast they may be from now on.
void placeAll(Monitor& self, double time, std::span<const double> rates) {
  const robots::Model& model = self.model();
  std::vector<robots::Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, self.q, X_WL);
  double reach = 0;
  for (Mover& mover : self.movers) {
    if (!mayHaveMoved(mover, X_WL[at(mover.link)], time - self.last_time)) {
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      self.schedule.setMotion(mover.body, {kInfinity, kInfinity, kInfinity}, time);
    }
    mover.X_WL = X_WL[at(mover.link)];
    mover.bounds = robots::pointMotion(model, mover.motion, rates,
                                       {self.velocity_limits, self.acceleration_limits});
    self.workspace.setPose(mover.body, mover.X_WL);
    reach = std::max(reach, X_WL[at(mover.link)].translation.norm() + mover.motion.center_L.norm() +
                                mover.motion.radius);
    self.schedule.setMotion(mover.body, mover.bounds, time);
  }
  self.last_time = time;
  self.workspace.pose_error = robots::kinematicsRounding(model, reach * (1 + 1e-9));
}

Report look(Monitor& self, double time, const py::object& state, const py::object& rates,
            double horizon) {
  const Busy busy(self.busy, kBusyMonitor);
  const std::vector<double> point = numbers(state, "q", self.scene.size());
  // Bounds on speeds and cropped clouds hold within the limits.
  if (const std::string broken = self.scene.compiled->space().brokenLimit(point); !broken.empty())
    throw py::value_error("q: " + broken + "; a position within the limits is expected");
  const std::vector<double> speeds = spread(self.scene, numbers(rates, "rates", self.scene.size()));
  if (!std::isfinite(time) || !(horizon >= 0) || std::isinf(horizon))
    throw py::value_error("time must be finite and horizon at least 0 and finite");
  if (time < self.last_time)
    throw py::value_error("time: " + text(time) + " s is before the last look, at " +
                          text(self.last_time) + " s; times never run backwards");
  self.scene.problem.robot().expand(point, self.q);
  Report report{};
  released([&] {
    placeAll(self, time, speeds);
    const collision::ImpactReport found = self.schedule.advance(time, horizon, self.workspace);
    report.safe_until = found.safe_until;
    report.violated = found.violated;
    report.next = pairNames(*self.scene.compiled, found.next_pair);
    for (const std::int32_t pair : self.schedule.imminent()) {
      auto names = pairNames(*self.scene.compiled, pair);
      // Bodies of several shapes have several pairs.
      if (std::find(report.imminent.begin(), report.imminent.end(), names) == report.imminent.end())
        report.imminent.push_back(std::move(names));
    }
  });
  return report;
}

}  // namespace

void defineMonitor(py::module_& module) {
  py::class_<Report> report(module, "Impact", "What a Monitor says of one look.");
  report.def_readonly("safe_until", &Report::safe_until,
                      "No pair can come down to its margin before this time [s].");
  defineConstant(
      report, "next",
      [](const Report& self) { return pairObject(self.next.first, self.next.second); },
      "The pair that is due next, or None.");
  defineConstant(
      report, "imminent",
      [](const Report& self) {
        py::list list;
        for (const auto& [a, b] : self.imminent) list.append(py::make_tuple(a, b));
        return list;
      },
      "Pairs of bodies that are not proven to keep their margin until time + horizon.");
  report.def_readonly("violated", &Report::violated,
                      "How many pairs of their shapes are proven to be at or below it now.");
  report.def("__repr__", [](const Report& self) {
    return "<leeway.Impact: safe until " + text(self.safe_until) + " s, " +
           std::to_string(self.imminent.size()) + " imminent>";
  });
  const std::string init = "(scene, *, accelerations, velocities=None)";
  auto monitor = defineClass<py::class_<Monitor>>(
      module, "Monitor", init,
      "How long nothing can touch: looks at a robot in a Scene again and again, and "
      "at those pairs only that are due. For one thread at a time.\n\n"
      "`accelerations` and `velocities` (joints,) are the joints' limits [rad/s^2 or "
      "m/s^2, rad/s or m/s]; velocities by default those of the URDF, unlimited where it "
      "has none. Joints that are not planned stand.",
      makeMonitor);
  define(
      monitor, "look", "(self, time, q, rates, horizon=0.1)",
      "Where the robot is at `time` [s], q (joints,) within the limits, how fast its joints are, "
      "rates (joints,) [rad/s or m/s], and what could come to its margin within `horizon` [s]: "
      "an Impact. Times must not run backwards. What has moved farther than its limits allow is "
      "looked at anew.",
      look);
  defineConstant(
      monitor, "counts",
      [](const Monitor& self) {
        py::dict counts;
        counts["looks"] = self.schedule.statistics.advances;
        counts["pairs"] = self.schedule.statistics.looks;
        counts["exact"] = self.schedule.statistics.exact;
        return counts;
      },
      "{looks, pairs (looked at), exact (queries)} so far.");
  monitor.def("__repr__", [](const Monitor& self) {
    return "<leeway.Monitor of " + std::to_string(self.movers.size()) + " moving bodies>";
  });
  define(module, "time_to_impact", "(gap, speed, acceleration=0.0, speed_cap=None)",
         "The earliest time [s] at which a gap [m] can be used up by two bodies that close at "
         "`speed` [m/s], accelerate by at most `acceleration` [m/s^2] and never close faster than "
         "`speed_cap`, rounded down; inf when nothing moves.",
         [](double gap, double speed, double acceleration, const py::object& cap) {
           const double most =
               cap.is_none() ? std::numeric_limits<double>::infinity() : number(cap, "speed_cap");
           return collision::timeToImpact(gap, {speed, acceleration, most});
         });
}

}  // namespace leeway::python
