#include "planner/timing/motion_limits.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

/// The robot's own limit, or one that reaches `velocity` in half a second [rad/s^2 or m/s^2].
double accelerationLimit(const robots::Variable& variable, double velocity) {
  const double own = variable.acceleration;
  return own > 0 && own <= kMostLimit ? own : velocity / kTimeToVelocityLimit;
}

double jerkLimit(const robots::Variable& variable) {
  return variable.jerk > 0 && variable.jerk <= kMostLimit ? variable.jerk : kInfinity;
}

void requireLimits(std::span<const double> limits, std::size_t size, const char* what,
                   bool infinite) {
  if (limits.size() != size)
    throw std::invalid_argument("trajectory: " + std::to_string(limits.size()) + " limits of " +
                                what + " for " + std::to_string(size) + " variables");
  for (const double x : limits)
    if (!(x > 0) || (!infinite && !std::isfinite(x)))
      throw std::invalid_argument("trajectory: a limit of " + std::string(what) + " is " +
                                  std::to_string(x) + ", it must be positive");
}

}  // namespace

void requireLimits(const MotionLimits& limits, std::size_t size) {
  requireLimits(limits.velocity, size, "velocity", false);
  requireLimits(limits.acceleration, size, "acceleration", false);
  if (!limits.jerk.empty()) requireLimits(limits.jerk, size, "jerk", true);
}

double velocityLimit(const robots::Variable& variable) {
  const double limit = variable.velocity;
  return limit > 0 && limit <= kMostLimit ? limit : kDefaultVelocity;
}

std::vector<double> velocityLimits(const Problem& problem) {
  std::vector<double> limits;
  for (const int v : problem.robot.variables) {
    const robots::Variable& variable = problem.robot.model->variables[at(v)];
    const auto given = problem.execution.velocities.find(variable.name);
    const double limit =
        given != problem.execution.velocities.end() ? given->second : velocityLimit(variable);
    limits.push_back(limit * problem.execution.speed);
  }
  return limits;
}

MotionLimits motionLimits(const Problem& problem) {
  validate(problem);
  const Execution& execution = problem.execution;
  MotionLimits limits;
  limits.velocity = velocityLimits(problem);
  std::size_t i = 0;
  for (const int v : problem.robot.variables) {
    const robots::Variable& variable = problem.robot.model->variables[at(v)];
    const auto acceleration = execution.accelerations.find(variable.name);
    const auto jerk = execution.jerks.find(variable.name);
    const double most_acceleration = acceleration != execution.accelerations.end()
                                         ? acceleration->second
                                         : accelerationLimit(variable, limits.velocity[i]);
    const double most_jerk = jerk != execution.jerks.end() ? jerk->second : jerkLimit(variable);
    limits.acceleration.push_back(most_acceleration * execution.acceleration_scale);
    limits.jerk.push_back(most_jerk * execution.jerk_scale);
    ++i;
  }
  return limits;
}

MotionLimits defaultMotionLimits(const ConfigurationSpace& space) {
  MotionLimits limits;
  for (const int v : space.variables()) {
    const robots::Variable& variable = space.model().variables[at(v)];
    limits.velocity.push_back(velocityLimit(variable));
    limits.acceleration.push_back(accelerationLimit(variable, limits.velocity.back()));
    limits.jerk.push_back(jerkLimit(variable));
  }
  return limits;
}

double timeAtLimits(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> dq) {
  double time = 0;
  for (const ConfigurationSpace::Part& part : space.parts()) {
    const std::size_t i = at(part.first);
    const double change =
        part.kind == ConfigurationSpace::Kind::kRotation
            ? std::sqrt(dq[i] * dq[i] + dq[i + 1] * dq[i + 1] + dq[i + 2] * dq[i + 2])
            : std::abs(dq[i]);
    time = std::max(time, change / limits[i]);
  }
  return time;
}

}  // namespace leeway::planner
