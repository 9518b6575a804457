#include "planner/execute/motion_limits.h"

#include <limits>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

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
    const std::string& name = problem.robot.model->variables[at(v)].name;
    const auto acceleration = execution.accelerations.find(name);
    const auto jerk = execution.jerks.find(name);
    limits.acceleration.push_back(acceleration != execution.accelerations.end()
                                      ? acceleration->second
                                      : limits.velocity[i] / kTimeToVelocityLimit);
    limits.jerk.push_back(jerk != execution.jerks.end() ? jerk->second : kInfinity);
    ++i;
  }
  return limits;
}

MotionLimits defaultMotionLimits(const ConfigurationSpace& space) {
  MotionLimits limits;
  for (const int v : space.variables()) {
    limits.velocity.push_back(velocityLimit(space.model().variables[at(v)]));
    limits.acceleration.push_back(limits.velocity.back() / kTimeToVelocityLimit);
  }
  return limits;
}

}  // namespace leeway::planner
