#include "planner/search/clearance_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/planner/simplify.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/improve/push.h"

// The greatest least clearance, by a planner without a notion of clearance. Finding a path that
// keeps the clearance c is an ordinary search in the scene with its margins raised to c, where
// every check is as fast as usual. So this search finds a path, pushes it away from obstacles, and
// then requires a greater clearance, at first halfway to the bound. If a search fails within its
// budget, the required increase is halved. If the increase becomes too small to matter, the budget
// is doubled and the increase starts again halfway to the bound. This is much faster than a tree
// that measures the clearance of every edge, because the first bound that fails rejects an edge.
//
// If the path's length is also limited, each path that is found is simplified in its raised scene.
// A path that is too long counts as not found.

namespace leeway::planner {
namespace {

class ClearanceSearch {
 public:
  ClearanceSearch(const std::shared_ptr<const CompiledScene>& scene, Search& search,
                  const SearchTask& task, double bound)
      : scene_(scene),
        search_(search),
        task_(task),
        objective_(std::get<MaximumClearance>(task.problem.objective)),
        is_limited_(std::isfinite(objective_.at_most_longer)),
        bound_(bound),
        near_(std::clamp(kNearBound * bound, kNearestBound, kClearanceTolerance)) {}

  std::optional<ClearancePath> run() {
    if (!findFirst()) return std::nullopt;
    describe();
    pushTowardsBound();
    climb();
    if (task_.problem.planner.simplify) shorten();
    best_.longest = longest();
    task_.limits.describe(nullptr);
    return std::move(best_);
  }

 private:
  /// A scene with raised margins, and its search.
  struct Raised {
    Raised(const CompiledScene& base, Pairs of, double margin, const SearchTask& task)
        : Raised(raised(base, of, margin), task) {}
    Raised(const std::shared_ptr<const CompiledScene>& scene, const SearchTask& task)
        : pool(std::make_shared<CertifierPool>(scene)), search(scene, pool, task) {}
    std::shared_ptr<CertifierPool> pool;
    Search search;
  };

  bool isOver() { return task_.limits.searchOver(); }
  bool isClimbOver() { return isOver() || task_.limits.isPast(kClimbShare); }
  double length(const Waypoints& path) const { return pathLength(scene_->space(), path); }
  double longest() const {
    return is_limited_ ? (1 + objective_.at_most_longer) * best_.shortest : kInfinity;
  }
  double halfway() const { return best_.clearance + (bound_ - best_.clearance) / 2; }

  std::optional<Waypoints> find(Search& search, std::uint64_t budget) {
    auto path = search.any(task_.problem.seed + runs_++, budget);
    if (!best_.path.empty()) describe();  // a search may have its own description
    return path;
  }

  /// Reports the best path so far to the caller's progress. The path changes only while no search
  /// runs.
  void describe() {
    task_.limits.describe([this] {
      char text[64];
      // Rounded outwards, because they are bounds.
      std::snprintf(text, sizeof text, ", keeps %.1f mm, none keeps above %.1f",
                    std::floor(1e4 * best_.clearance) / 10, std::ceil(1e4 * bound_) / 10);
      return std::string(text);
    });
  }

  void shortenPath(EdgeCertifier& certifier, Waypoints& path) {
    if (!task_.problem.planner.simplify) return;
    SimplifyOptions options;
    options.seed = Random(task_.problem.seed + runs_, kSimplifyStream).next();
    options.stop = [this] { return isOver(); };
    simplify(certifier, path, options);
  }

  /// If the length is limited, takes the shortest of several paths.
  bool findFirst() {
    double shortest = kInfinity;
    for (int run = 0; run < (is_limited_ ? kShortestRuns : 1); ++run) {
      if (run > 0 && isClimbOver()) break;
      auto path = find(search_, run > 0 ? kFirstBudget : 0);
      if (!path) {
        if (run == 0) return false;
        continue;
      }
      shortenPath(search_.certifier(), *path);
      const double its = length(*path);
      if (run > 0 && !(its < shortest)) continue;
      shortest = its;
      best_.path = std::move(*path);
    }
    if (is_limited_) best_.shortest = shortest;
    pushAsPlain();
    return true;
  }

  double measured(const Waypoints& path) {
    return pathClearance(search_.certifier(), path, kBoundTolerance, -kInfinity, objective_.of);
  }

  PushOptions pushOptions() {
    PushOptions options;
    options.pairs = objective_.of;
    options.longest = longest();
    options.stop = [this] { return isOver(); };
    return options;
  }

  /// The push of the objective `length`, so that the clearance is at least as great.
  void pushAsPlain() {
    PushOptions options = pushOptions();
    options.target = std::min(kPushClearance, bound_ - near_);
    options.least = kPushLeast;
    options.work = kPushWork;
    best_.clearance = push(search_.certifier(), best_.path, options);
    // Measured only then, because measuring a path close to an obstacle is expensive.
    if (!(best_.clearance > 0)) best_.clearance = measured(best_.path);
  }

  /// Raises the clearance only by moving waypoints: first to the bound, then by halves of the
  /// remaining gain.
  void pushTowardsBound() {
    double most = bound_;
    for (int k = 0; k < kClearancePushes && !isClimbOver(); ++k) {
      const double target = k == 0 ? bound_ - near_ : (best_.clearance + most) / 2;
      if (!(target > best_.clearance + near_ / 2)) return;
      PushOptions options = pushOptions();
      options.target = options.least = target;
      options.work = kClearancePushWork;
      if (push(search_.certifier(), best_.path, options) > 0)
        best_.clearance = target;
      else
        most = target;
    }
  }

  void climb() {
    Limits& limits = task_.limits;
    std::uint64_t budget = kFirstBudget, iterations = limits.iterations();
    double demand = halfway();
    while (bound_ - best_.clearance > near_ && !isClimbOver()) {
      if (reach(demand, budget)) {
        pushTowardsBound();
        demand = halfway();
        continue;
      }
      demand = best_.clearance + (demand - best_.clearance) / 2;
      if (demand - best_.clearance > near_) continue;
      // A search without an iteration (no start or no goal has that clearance) cannot succeed
      // later.
      if (limits.iterations() == iterations) break;
      iterations = limits.iterations();
      budget *= 2;
      demand = halfway();
    }
  }

  /// Whether a path with this clearance is found.
  bool reach(double demand, std::uint64_t budget) {
    Raised wider(*scene_, objective_.of, demand, task_);
    auto path = find(wider.search, budget);
    if (path && is_limited_) shortenPath(wider.pool->local().certifier, *path);
    count(wider);
    if (!path || !(length(*path) <= longest())) return false;
    if (is_limited_) best_.shortest = std::min(best_.shortest, length(*path));
    best_.path = std::move(*path);
    best_.clearance = std::max(demand, measured(best_.path));
    return true;
  }

  /// Uses the rest of the limits for shorter paths with the same clearance.
  void shorten() {
    const double kept = best_.clearance - near_ / 4;
    Raised wider(*scene_, objective_.of, kept, task_);
    EdgeCertifier& certifier = wider.pool->local().certifier;
    shortenPath(certifier, best_.path);
    best_.simplified = !isOver();
    best_.clearance = kept;
    double shortest = length(best_.path);
    for (int failures = 0; failures < kShorterFailures && !isOver(); ++failures) {
      auto path = find(wider.search, kFirstBudget);
      if (!path) continue;
      shortenPath(certifier, *path);
      const double its = length(*path);
      if (!(its < (1 - kShorterGain) * shortest)) continue;
      shortest = its;
      best_.path = std::move(*path);
      failures = -1;
    }
    if (is_limited_) best_.shortest = std::min(best_.shortest, shortest);
    count(wider);
  }

  void count(const Raised& wider) {
    best_.work += wider.pool->statistics();
    best_.work += wider.search.work();
  }

  const std::shared_ptr<const CompiledScene>& scene_;
  Search& search_;
  const SearchTask& task_;
  const MaximumClearance& objective_;
  bool is_limited_;  ///< the path's length is limited
  double bound_;     ///< no path keeps more [m]
  double near_;      ///< the search ends at this distance below the bound [m]
  std::uint64_t runs_ = 0;
  ClearancePath best_;
};

}  // namespace

std::optional<ClearancePath> searchClearance(const std::shared_ptr<const CompiledScene>& scene,
                                             Search& search, const SearchTask& task, double bound) {
  return ClearanceSearch(scene, search, task, bound).run();
}

}  // namespace leeway::planner
