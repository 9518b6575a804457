// README's C++ program, which prints every number of its answer, to the bit, for
// tests/python/plan_test.py.

#include <cstdio>

#include "leeway/planner/plan.h"

int main() {
  using namespace leeway;
  const auto robot = robots::loadModel("robots/arm7/arm7.urdf", "robots/arm7/arm7.srdf");
  planner::Problem problem = planner::problemFromStates(robot, "arm", "ready", "ready");
  problem.start[0] = -0.8;
  problem.goals[0].ranges[0] = {0.8, 0.8};
  const collision::Pose X_WP{Eigen::Matrix3d::Identity(), {0.5, 0, 0.5}};
  problem.world.objects = {{"post", {{collision::Shape::cylinder(0.05, 0.5), {}, "post"}}, X_WP}};
  problem.margins.common = 0.01;
  const planner::PlanResult result = planner::plan(problem);
  for (const std::vector<double>& row : result.path.positions)
    for (const double value : row) std::printf("%.17g\n", value);
  for (const collision::Interval& edge : result.certificate.segments)
    std::printf("%.17g\n%.17g\n", edge.lower, edge.upper);
  std::printf("%.17g\n", result.length);
  return result.status == planner::PlanStatus::kSolved ? 0 : 1;
}
