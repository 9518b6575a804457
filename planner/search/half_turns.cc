#include "planner/search/half_turns.h"

#include <cmath>
#include <cstddef>

namespace leeway::planner {

void splitHalfTurns(const ConfigurationSpace& space, std::vector<std::vector<double>>& path) {
  if (path.empty()) return;
  std::vector<double> here = path[0], next, way(here.size()), written(here.size());
  for (std::size_t i = 1; i < path.size(); ++i) {
    next = path[i];
    space.unwrap(here, next);
    space.difference(path[i - 1], path[i], way);
    space.difference(here, next, written);
    bool is_same_way = true;
    for (const ConfigurationSpace::Part& part : space.parts()) {
      if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
      const auto k = static_cast<std::size_t>(part.first);
      // If not, they are a whole turn apart.
      is_same_way = is_same_way && std::abs(next[k] - here[k] - way[k]) < 1 &&
                    std::abs(written[k] - way[k]) < 1;
    }
    if (!is_same_way) {
      space.interpolate(path[i - 1], path[i], 0.5, next);
      path.insert(path.begin() + static_cast<std::ptrdiff_t>(i), next);
      space.unwrap(here, next);
    }
    here = next;
  }
}

}  // namespace leeway::planner
