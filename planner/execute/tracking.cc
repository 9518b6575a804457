#include "planner/execute/tracking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "collision/base/numbers.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/robots/input_error.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/displacement.h"
#include "planner/timing/leg.h"

namespace leeway::planner {

Problem withErrors(const Problem& problem, std::vector<double>& joint_errors, double point_error,
                   const std::string& who) {
  const auto refuse = [&](const std::string& message) {
    throw robots::InputError(problem.name, 0, fmt::format("{}: {}", who, message));
  };
  const std::size_t size = problem.robot.variables.size();
  if (joint_errors.empty()) joint_errors.assign(size, 0);
  if (joint_errors.size() != size)
    refuse(fmt::format("joint_errors has {} numbers; {} are expected, one a planned variable",
                       joint_errors.size(), size));
  for (std::size_t i = 0; i < size; ++i)
    if (!(joint_errors[i] >= 0 && joint_errors[i] < kInfinity))
      refuse(fmt::format("joint_errors[{}] is {}; 0 or more is expected", i, joint_errors[i]));
  const bool has_errors =
      std::any_of(joint_errors.begin(), joint_errors.end(), [](double e) { return e > 0; });
  if (!has_errors && !(point_error > 0)) return problem;
  const CompiledScene scene(problem);
  if (hasRotation(scene.space()))
    refuse("a planned joint is floating; joints with a position each are expected");
  const double errors = Displacement(scene).beyondLimits(joint_errors) + 2 * point_error;
  if (!(errors < kInfinity))
    refuse(
        "joint_errors are too large for a bound on how far the robot is off; less than 1 rad in "
        "all is expected, and 0 for what is behind a prismatic joint without limits");
  const double growth = errors * (1 + kGuardChordShare) + kGuardChordRounding;
  Problem grown = problem;
  grown.margins.common += growth;
  for (PairMargin& m : grown.margins.pairs) m.margin += growth;
  if (auto* length = std::get_if<MinimumLength>(&grown.objective)) length->clearance += growth;
  validate(grown);  // a cloud may lack points that these margins reach
  return grown;
}

bool isWithin(std::span<const double> differences, std::span<const double> joint_errors) {
  for (std::size_t i = 0; i < joint_errors.size(); ++i)
    if (!(std::abs(differences[i]) <= joint_errors[i] + kVerifyWaypoint)) return false;
  return true;
}

}  // namespace leeway::planner
