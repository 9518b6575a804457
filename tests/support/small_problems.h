#pragma once

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "leeway/robots/model.h"

/// Small models and problems for the planner's tests, made without files.
namespace leeway::planner::test {

inline collision::Pose at(double x, double y, double z) {
  collision::Pose pose;
  pose.translation = {x, y, z};
  return pose;
}

inline Object box(const std::string& name, const Eigen::Vector3d& half_extents, double x, double y,
                  double z) {
  return {name, {{collision::Shape::box(half_extents), {}, name}}, at(x, y, z)};
}

inline Goal pointGoal(const std::string& name, const std::vector<double>& q) {
  Goal goal;
  goal.name = name;
  for (const double x : q) goal.ranges.emplace_back(x, x);
  return goal;
}

inline Problem problemOf(std::shared_ptr<const robots::Model> model, std::vector<double> start,
                         std::vector<double> goal) {
  Problem problem;
  problem.name = "test";
  for (std::size_t i = 0; i < model->variables.size(); ++i)
    problem.robot.variables.push_back(static_cast<int>(i));
  problem.robot.model = std::move(model);
  problem.start = std::move(start);
  problem.goals.push_back(pointGoal("goal", goal));
  problem.limits.time = 20;
  return problem;
}

/// A disc of radius 0.1 that translates in [-2, 2]^2 and rotates: x, y, theta.
inline std::shared_ptr<const robots::Model> disc() {
  return robots::freeBody("disc", {{collision::Shape::cylinder(0.1, 0.1), {}, "disc"}},
                          robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0});
}

/// From left to right of a wall at x = 0 whose only gap is 0.6 wide, at y = 1.2: the straight path
/// is blocked.
inline Problem wallProblem() {
  Problem problem = problemOf(disc(), {-1, -1, 0}, {1, -1, 0});
  problem.world.objects.push_back(
      box("lower wall", {0.05, 1.7, 0.5}, 0, -0.8, 0));                             // y -2.5 to 0.9
  problem.world.objects.push_back(box("upper wall", {0.05, 0.5, 0.5}, 0, 2.0, 0));  // y 1.5 to 2.5
  return problem;
}

/// From left to right past a block at the origin: the passage above it is 0.4 wide, the one below
/// 1.4. The start is closer to the narrow one, so the shortest path takes it.
inline Problem corridorProblem() {
  Problem problem = problemOf(disc(), {-1.2, 0.7, 0}, {1.2, 0.7, 0});
  problem.world.objects.push_back(box("block", {0.2, 0.8, 0.5}, 0, 0.2, 0));    // y -0.6 to 1.0
  problem.world.objects.push_back(box("ceiling", {0.2, 0.5, 0.5}, 0, 1.9, 0));  // y 1.4 to 2.4
  problem.world.objects.push_back(box("floor", {0.2, 0.5, 0.5}, 0, -2.5, 0));   // y -3 to -2
  return problem;
}

/// A box that flies freely in [-1, 1]^3.
inline std::shared_ptr<const robots::Model> flyingBox() {
  return robots::freeBody("flyer", {{collision::Shape::box({0.1, 0.05, 0.02}), {}, "box"}},
                          robots::JointType::kFloating, {-1, -1, -1}, {1, 1, 1});
}

}  // namespace leeway::planner::test
