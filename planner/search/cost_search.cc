#include "planner/search/cost_search.h"

#include <algorithm>
#include <limits>

#include "leeway/planner/simplify.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/improve/lower_cost.h"

// The least cost, by a planner that knows nothing of costs: a first path is shortened, and then
// moved as long as that lowers what it is proven to cost. Another path may lie on another side of
// what is near, so others are searched and lowered, too.

namespace leeway::planner {

std::optional<CostPath> searchCost(Search& search, PathCost& cost, const SearchTask& task,
                                   double enough) {
  // As a simplification, lowering goes on when iterations are spent.
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
