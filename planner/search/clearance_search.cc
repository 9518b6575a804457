#include <algorithm>
#include <limits>

#include "planner/base/tolerances.h"
#include "planner/search/push.h"
#include "planner/search/search.h"

// The greatest least clearance, by a planner that knows nothing of clearance. Finding a path that
// keeps the margin c is an ordinary search in the scene with its margins raised to c, where every
// check is as fast as ever. So: find a path, push it away from what is near, and demand more than
// that reaches, at first half of the way to the bound. Where a search fails within its budget,
// demand half as much more; where that becomes too little to matter, double the budget and start
// from half of the way again. This climbs much faster than a tree that measures the clearance of
// every edge: an edge that is not good enough is refused by the first bound that says so.

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Raises the clearance by moving waypoints alone: first to the bound, then by halves of what is
/// left.
void pushTowards(double bound, Search& search, const SearchTask& task, Pairs of,
                 ClearancePath& best) {
  double most = bound;
  for (int k = 0; k < kClearancePushes && !task.limits.searchOver(); ++k) {
    const double target = k == 0 ? bound - kClearanceTolerance : (best.clearance + most) / 2;
    if (!(target > best.clearance + kClearanceTolerance / 2)) return;
    PushOptions options;
    options.target = options.least = target;
    options.longest = kInfinity;
    options.pairs = of;
    options.work = kClearancePushWork;
    options.stop = [&task] { return task.limits.searchOver(); };
    if (push(search.certifier(), best.path, options) > 0)
      best.clearance = target;
    else
      most = target;
  }
}

}  // namespace

std::shared_ptr<const CompiledScene> raised(const CompiledScene& scene, Pairs of, double margin) {
  return of == Pairs::kAll ? scene.withMarginAtLeast(margin) : scene.withWorldMarginAtLeast(margin);
}

std::optional<ClearancePath> searchClearance(const std::shared_ptr<const CompiledScene>& scene,
                                             Search& search, const SearchTask& task, double bound) {
  const Pairs of = std::get<MaximumClearance>(task.problem.objective).of;
  std::uint64_t run = 0;
  auto first = search.any(task.problem.seed);
  if (!first) return std::nullopt;
  const auto measured = [&](const Waypoints& path) {
    return pathClearance(search.certifier(), path, kBoundTolerance, -kInfinity, of);
  };
  ClearancePath best{std::move(*first), 0, {}};
  best.clearance = measured(best.path);
  pushTowards(bound, search, task, of, best);

  std::uint64_t budget = kFirstBudget, iterations = task.limits.iterations();
  double demand = best.clearance + (bound - best.clearance) / 2;
  while (bound - best.clearance > kClearanceTolerance && !task.limits.searchOver()) {
    const auto narrower = raised(*scene, of, demand);
    const auto pool = std::make_shared<CertifierPool>(narrower);
    Search wider(narrower, pool, task);
    auto path = wider.any(task.problem.seed + ++run, budget);
    best.work += pool->statistics();
    best.work += wider.work();
    if (path) {
      best.path = std::move(*path);
      best.clearance = std::max(demand, measured(best.path));
      pushTowards(bound, search, task, of, best);
      demand = best.clearance + (bound - best.clearance) / 2;
      continue;
    }
    demand = best.clearance + (demand - best.clearance) / 2;
    if (demand - best.clearance > kClearanceTolerance) continue;
    // A search without an iteration (no start or no goal has so much room) will not do better
    // later.
    if (task.limits.iterations() == iterations) break;
    iterations = task.limits.iterations();
    budget *= 2;
    demand = best.clearance + (bound - best.clearance) / 2;
  }
  return best;
}

}  // namespace leeway::planner
