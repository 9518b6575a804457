#include "python/execution/seen_cloud.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "python/base/define.h"
#include "python/bindings/shapes.h"
#include "python/bindings/world.h"

namespace leeway::python {

CloudGiven cloudGiven(const planner::Problem& problem, const CloudArguments& of,
                      std::span<const double> state) {
  CloudGiven given;
  if (!of.pose.is_none()) given.X_WO = pose(of.pose, "pose");
  planner::PointCloud cloud = cloudOf(of.points, of.radius);
  const std::vector<std::string> carve = namesOf(of.carve, "carve");
  const double margin = number(of.carve_margin, "carve_margin");
  if (carve.empty() && margin != 0)
    throw py::value_error("carve_margin stands without carve; both are expected");
  if (!carve.empty()) {
    if (!given.X_WO)
      throw py::value_error("carve stands without pose; the pose of the cloud's frame is expected");
    if (state.empty())
      throw py::value_error("carve stands without state; where the robot is is expected");
    std::vector<double> configuration = problem.start;
    for (std::size_t i = 0; i < state.size(); ++i)
      configuration[static_cast<std::size_t>(problem.robot.variables[i])] = state[i];
    std::string what;
    for (const std::string& name : carve) what += (what.empty() ? "" : ", ") + name;
    cloud = planner::carved(cloud, *given.X_WO,
                            planner::shapesToCarve(problem, carve, configuration), margin, what);
  }
  if (!cloud.balls.empty()) cloud = thinnedAs(of.thin, of.most_balls, std::move(cloud));
  given.cloud = std::make_shared<const planner::PointCloud>(std::move(cloud));
  return given;
}

}  // namespace leeway::python
