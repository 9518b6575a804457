#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/replanner.h"
#include "leeway/robots/kinematics.h"

/// Truth of an executed trajectory without hierarchies, sweeps or bounds: every triangle, as the
/// hull of its corners, against every shape of the robot, at many instants.
namespace leeway::planner::test {

/// Minimum distance between the robot at `point` and the obstacles that move, at `time` [m], if
/// below `enough`. Skips pairs in Contacts::allowed.
inline double bruteClearance(const Problem& problem, std::span<const double> point, double time,
                             double enough) {
  std::vector<double> q = problem.start;
  for (std::size_t i = 0; i < point.size(); ++i)
    q[static_cast<std::size_t>(problem.robot.variables[i])] = point[i];
  std::vector<robots::Pose> X_WL(problem.robot.model->links.size());
  robots::forwardKinematics(*problem.robot.model, q, X_WL);
  collision::Scratch scratch;
  double least = enough;
  for (const Object& object : problem.world.objects) {
    if (!object.motion) continue;
    const robots::Pose X_WO = object.motion->poses ? object.motion->poses->pose(time) : object.X_WO;
    for (const robots::Geometry& of : object.geometries)
      for (std::size_t l = 0; l < X_WL.size(); ++l)
        for (const robots::Geometry& g : problem.robot.model->links[l].geometries)
          least = std::min(least, collision::distance(g.shape, X_WL[l] * g.X_BG, of.shape,
                                                      X_WO * of.X_BG, {}, scratch)
                                      .distance.upper);
  }
  for (const DeformingObstacle& obstacle : problem.world.deforming) {
    std::vector<Eigen::Vector3d> vertices(static_cast<std::size_t>(obstacle.mesh->vertexCount()));
    obstacle.motion->evaluate(time, vertices);
    for (Eigen::Vector3d& v : vertices) v = obstacle.object.X_WO * v;
    for (std::size_t l = 0; l < X_WL.size(); ++l) {
      const bool allowed = std::any_of(
          problem.contacts.allowed.begin(), problem.contacts.allowed.end(), [&](const auto& pair) {
            const std::string& link = problem.robot.model->links[l].name;
            return (pair.first == link && pair.second == obstacle.object.name) ||
                   (pair.second == link && pair.first == obstacle.object.name);
          });
      if (allowed) continue;
      for (const robots::Geometry& g : problem.robot.model->links[l].geometries) {
        const robots::Pose X_WG = X_WL[l] * g.X_BG;
        const Eigen::Vector3d center = X_WG * g.shape.boundingCenter();
        const double radius = g.shape.boundingRadius();
        for (const auto& t : obstacle.mesh->triangles()) {
          const std::array<Eigen::Vector3d, 3> corners = {vertices[static_cast<std::size_t>(t[0])],
                                                          vertices[static_cast<std::size_t>(t[1])],
                                                          vertices[static_cast<std::size_t>(t[2])]};
          const double reach =
              std::max((corners[1] - corners[0]).norm(), (corners[2] - corners[0]).norm());
          if ((corners[0] - center).norm() - radius - reach >= least) continue;
          collision::DistanceRequest request;
          request.depth = false;
          least = std::min(
              least, collision::distance(g.shape, X_WG, collision::Shape::convexHull(corners), {},
                                         request, scratch)
                         .distance.upper);
        }
      }
    }
  }
  return least;
}

/// Clearance of an executed trajectory from the obstacles that move, sampled every `step` [s].
inline double denseClearance(const Problem& problem, std::span<const TimedPoint> trajectory,
                             double step, double enough) {
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  double least = enough;
  std::vector<double> point(problem.robot.variables.size());
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const TimedPoint &a = trajectory[i - 1], &b = trajectory[i];
    const int parts = std::max(1, static_cast<int>(std::ceil((b.time - a.time) / step)));
    for (int k = 0; k <= parts; ++k) {
      const double t = static_cast<double>(k) / parts;
      space.interpolate(a.position, b.position, t, point);
      least =
          std::min(least, bruteClearance(problem, point, a.time + t * (b.time - a.time), least));
    }
  }
  return least;
}

}  // namespace leeway::planner::test
