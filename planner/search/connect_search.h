#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/base/waypoints.h"
#include "planner/search/limits.h"
#include "planner/space/connect_trees.h"

namespace leeway::planner {

/// The settings of Connect: those of its trees, and the number of parallel searches.
struct ConnectChoice {
  ConnectSettings settings;
  bool own_range = true, own_balance = true,
       own_domain = true;  ///< not set by the user, so workers may vary them
  int workers = 1;
  int threads = 1;     ///< 0: the number of cores
  double improve = 0;  ///< time for finding shorter paths after the first one [s]
};
/// The choice for parameters that plannerError() accepts.
ConnectChoice connectChoice(const std::map<std::string, std::string>& parameters,
                            const ConfigurationSpace& space);

/// The problem of a Connect search. All must outlive the search.
struct ConnectQuery {
  std::shared_ptr<const CompiledScene> scene;
  const std::vector<double>& start;
  const Waypoints& goals;  ///< valid goals, at least one
  std::uint64_t seed;
  /// Whether a found path is acceptable; may change it. The last argument: whether every edge is
  /// already proven free. Called by several threads.
  const std::function<bool(Waypoints&, EdgeCertifier&, bool)>& accept;
  Limits& limits;
  std::uint64_t most;  ///< iterations of this search, in addition to the limits
  /// Receives the free edges of the first worker, from one thread at a time; may be empty.
  const std::function<void(std::span<const double>, std::span<const double>)>& on_edge;
  double bound = std::numeric_limits<double>::infinity();  ///< on the path's length
  std::uint64_t run = kConnectRun;  ///< least number of iterations of a first run
  /// Appends batch k = 0, 1, ... of further goals to a worker's goals; false if there is none. May
  /// be empty. Called by several threads.
  std::function<bool(std::size_t k, Waypoints& goals)> more_goals = {};
  /// The problem whose constraints edges keep; null: none.
  const Problem* constrained = nullptr;
};

/// The reasons why a search found no path.
struct Hindrance {
  std::unordered_map<int, std::uint64_t> blocked;  ///< edges, by the pair in the way
  ConnectTrees::Gap gap;                           ///< the nearest of all runs
  Hindrance& operator+=(const Hindrance& more);
};

struct ConnectResult {
  std::optional<Waypoints> path;
  EdgeCertifier::Statistics work;  ///< of all certifiers except the caller's
  std::size_t goal_batches = 0;    ///< used by the winner; without a winner, the most of any worker
  Hindrance hindrance;             ///< without a path
};

/// Runs with rising budgets. Most problems have a path that some seed finds soon, so a long run is
/// restarted with another seed (Luby, Sinclair, Zuckerman, "Optimal speedup of Las Vegas
/// algorithms", 1993). The first run finds most paths, and continues while an arm's edges are few.
/// After it every other run is narrow: if an edge meets an obstacle, it slides along it. One worker
/// searches with `certifier`; narrow runs have their own certifier.
///
/// Several workers have their own certifiers, seeds and, unless the choice sets them, settings. The
/// first worker does the same as a single worker would. The path that took its worker the fewest
/// iterations wins; for equal counts, that of the lowest worker. So neither the path nor the counts
/// depend on the number of threads. Iterations are the winner's.
ConnectResult searchConnect(const ConnectQuery& query, const ConnectChoice& choice,
                            EdgeCertifier& certifier);

}  // namespace leeway::planner
