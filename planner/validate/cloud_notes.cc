#include "leeway/planner/cloud_notes.h"

#include <fmt/format.h>

#include <algorithm>

#include "leeway/planner/depth_image.h"

namespace leeway::planner {

bool isUnseenOccupied(const Object& object) {
  return object.cloud && std::any_of(object.geometries.begin(), object.geometries.end(),
                                     [](const auto& g) { return g.name == kUnseenName; });
}

std::vector<std::string> cloudNotes(const Problem& problem) {
  std::vector<std::string> notes;
  for (const Object& object : problem.world.objects) {
    if (!object.cloud) continue;
    for (const CloudFilter& filter : object.cloud->filters)
      if (filter.removed > 0 && filter.name != "thin")
        notes.push_back(
            fmt::format("cloud '{}' leaves out {} {}", object.name, filter.removed, filter.what));
    notes.push_back(
        isUnseenOccupied(object)
            ? fmt::format("cloud '{}': space that its camera did not see counts as occupied within "
                          "its picture and range ({} parts), and as free elsewhere",
                          object.name, object.geometries.size())
            : fmt::format("cloud '{}': space that was not seen counts as free", object.name));
  }
  return notes;
}

}  // namespace leeway::planner
