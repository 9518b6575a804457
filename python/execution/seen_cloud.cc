#include "python/execution/seen_cloud.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "python/base/define.h"
#include "python/bindings/shapes.h"
#include "python/bindings/world.h"

namespace leeway::python {

CloudGiven cloudGiven(const planner::Problem& problem, const CloudArguments& of,
                      std::span<const double> state, const std::string& object, double time,
                      const std::set<std::string>& turned) {
  CloudGiven given;
  if (!of.pose.is_none()) given.X_WO = seenPose(problem.world, object, of.pose, time, turned);
  planner::ScanFilters filters;
  if (std::vector<std::string> names = namesOf(of.carve, "carve"); !names.empty())
    filters.carve = std::move(names);
  filters.carve_margin = number(of.carve_margin, "carve_margin");
  filters.state.assign(state.begin(), state.end());
  if (!of.thin.is_none()) filters.thin = number(of.thin, "thin");
  if (!of.most_balls.is_none())
    filters.most_balls = whole<std::size_t>(of.most_balls, "most_balls");
  given.cloud = std::make_shared<const planner::PointCloud>(
      planner::filteredScan(problem, cloudOf(of.points, of.radius), given.X_WO, filters));
  return given;
}

}  // namespace leeway::python
