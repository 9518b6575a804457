#include "planner/execute/unchecked_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "leeway/planner/cloud_notes.h"
#include "leeway/planner/point_cloud.h"

namespace leeway::planner {

nlohmann::ordered_json uncheckedJson(std::span<const UncheckedPairs> unchecked) {
  int all = 0;
  nlohmann::ordered_json reasons = nlohmann::ordered_json::array();
  for (const UncheckedPairs& group : unchecked) {
    all += group.count;
    nlohmann::ordered_json reason = {{"reason", toString(group.why)}, {"pairs", group.count}};
    for (const auto& [a, b] : group.names)
      reason["names"].push_back(nlohmann::ordered_json::array({a, b}));
    reasons.push_back(std::move(reason));
  }
  return {{"pairs", all}, {"reasons", reasons}};
}

nlohmann::ordered_json cloudJson(const Object& object) {
  const PointCloud& cloud = *object.cloud;
  nlohmann::ordered_json filters = nlohmann::ordered_json::array(), within;
  for (const CloudFilter& filter : cloud.filters)
    filters.push_back({{"name", filter.name}, {"what", filter.what}, {"removed", filter.removed}});
  if (std::isfinite(cloud.completeWithin())) within = cloud.completeWithin();
  return {{"name", object.name},
          {"balls", cloud.size()},
          {"largest_radius", cloud.largestRadius()},
          {"unseen", isUnseenOccupied(object) ? "occupied" : "free"},
          {"complete_within", within},
          {"filters", filters},
          {"bytes", cloud.size() * sizeof(PointCloud::Ball)}};
}

nlohmann::ordered_json cloudsJson(const Problem& problem) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Object& object : problem.world.objects)
    if (object.cloud) list.push_back(cloudJson(object));
  return list;
}

}  // namespace leeway::planner
