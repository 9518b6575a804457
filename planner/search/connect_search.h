#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/base/waypoints.h"
#include "planner/search/limits.h"
#include "planner/space/connect_trees.h"

namespace leeway::planner {

/// How Connect searches: the settings of its trees, and how many searches run side by side.
struct ConnectChoice {
  ConnectSettings settings;
  bool own_range = true, own_balance = true, own_domain = true;  ///< not asked for: may vary
  int workers = 1;
  int threads = 1;     ///< 0: as many as the machine has
  double improve = 0;  ///< how long shorter paths are searched once there is one [s]
};
/// From parameters that plannerError() accepts.
ConnectChoice connectChoice(const std::map<std::string, std::string>& parameters,
                            const ConfigurationSpace& space);

/// What Connect searches. All must outlive the search.
struct ConnectQuery {
  std::shared_ptr<const CompiledScene> scene;
  const std::vector<double>& start;
  const Waypoints& goals;  ///< valid ones, at least one
  std::uint64_t seed;
  /// Whether a path that was found will do; may change it. The last argument: whether every edge is
  /// proven free as it stands. Called by several threads.
  const std::function<bool(Waypoints&, EdgeCertifier&, bool)>& accept;
  Limits& limits;
  std::uint64_t most;  ///< iterations of this search, beside the limits
  /// Told of the free edges of the first worker, from one thread at a time; may be empty.
  const std::function<void(std::span<const double>, std::span<const double>)>& on_edge;
  double bound = std::numeric_limits<double>::infinity();  ///< of the path's length
  std::uint64_t run = kConnectRun;                         ///< iterations of a first run, at least
  /// Appends batch k = 0, 1, ... of further goals to a worker's own; false when there is none. May
  /// be empty. Called by several threads.
  std::function<bool(std::size_t k, Waypoints& goals)> more_goals = {};
  /// The problem whose constraints edges keep; null: none.
  const Problem* constrained = nullptr;
};

struct ConnectResult {
  std::optional<Waypoints> path;
  EdgeCertifier::Statistics work;  ///< of all certifiers but the caller's
  std::size_t goal_batches = 0;    ///< asked for by the winner; without one the most
};

/// Runs with rising budgets: most problems are solved soon or by luck, so a run that is late is
/// started again with another seed (Luby, Sinclair, Zuckerman, "Optimal speedup of Las Vegas
/// algorithms", 1993). After the first, which finds most paths and goes on while an arm's edges are
/// few, each other run is narrow: where an edge meets something, it slides along it. One worker
/// searches with `certifier`, narrow runs with one of their own.
///
/// Several have certifiers, seeds and, where the choice leaves them open, settings of their own;
/// the first is what one worker would be. The path that took its worker the fewest iterations
/// wins, of equals that of the lowest worker: neither the path nor what is counted depends on the
/// number of threads. Iterations are the winner's.
ConnectResult searchConnect(const ConnectQuery& query, const ConnectChoice& choice,
                            EdgeCertifier& certifier);

}  // namespace leeway::planner
