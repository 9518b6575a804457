#include "planner/search/cost_search.h"

#include <algorithm>
#include <limits>

#include "leeway/planner/simplify.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/improve/lower_cost.h"

// The least cost, by a planner without a notion of costs. A first path is shortened, and then moved
// as long as that lowers its proven cost. A path on another side of an obstacle may cost less, so
// other paths are searched and lowered as well.

namespace leeway::planner {

std::optional<CostPath> searchCost(Search& search, PathCost& cost, const SearchTask& task,
                                   double enough) {
  // Like simplification, lowering continues after the iterations are used up.
  const std::function<bool()> stop = [&task] { return task.limits.over(); };
  const bool simplifies = task.problem.planner.simplify;
  std::optional<CostPath> best;
  double least = std::numeric_limits<double>::infinity();
  std::uint64_t run = 0;
  for (int failures = 0; failures < kCheaperFailures && !(best && task.limits.searchOver());
       ++run) {
    auto path = search.any(task.problem.seed + run, best ? kFirstBudget : 0);
    if (!path) {
      if (!best) return std::nullopt;
      ++failures;
      continue;
    }
    double upper = 0;
    if (simplifies) {
      SimplifyOptions options;
      options.seed = Random(task.problem.seed + run, kSimplifyStream).next();
      options.stop = stop;
      simplify(search.certifier(), *path, options);
      upper = lowerCost(search.certifier(), cost, *path, {options.seed, enough, stop});
    } else {
      upper = cost.path(*path, {.work_limit = kSearchCostWork}).upper;
    }
    ++failures;
    if (best && !(upper < (1 - kCheaperGain) * least)) continue;
    failures = 0;
    least = upper;
    best = CostPath{std::move(*path), simplifies};
    if (least <= enough) break;
  }
  return best;
}

}  // namespace leeway::planner
