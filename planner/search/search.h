#pragma once

#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/Planner.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_objectives.h"
#include "leeway/planner/planners.h"
#include "planner/search/goals.h"
#include "planner/search/limits.h"

namespace leeway::planner {

using Waypoints = std::vector<std::vector<double>>;

/// What a search is about, apart from the scene that it is made in.
struct SearchTask {
  const Problem& problem;
  const std::vector<double>& start;
  const GoalPoints& goals;
  Limits& limits;
};

/// One scene's OMPL side, and searches in it.
class Search {
 public:
  Search(std::shared_ptr<const CompiledScene> scene, std::shared_ptr<CertifierPool> pool,
         const SearchTask& task);

  EdgeCertifier& certifier() { return pool_->local().certifier; }

  /// Runs the problem's planner for the shortest path (or any: as the planner is), anew when it
  /// gives up before the limits. A path is returned only when every edge of it is certified as it
  /// stands.
  std::optional<Waypoints> shortest(std::uint64_t seed);
  /// The same for the first path it finds. `budget`: at most so many iterations (0: what the limits
  /// leave).
  std::optional<Waypoints> any(std::uint64_t seed, std::uint64_t budget = 0);
  /// The same for the greatest clearance, ending early at `enough` [m]. For planners that optimise.
  std::optional<Waypoints> widest(std::uint64_t seed, double enough);

  bool certified(const Waypoints& path);

 private:
  std::optional<Waypoints> search(std::uint64_t seed, std::uint64_t budget, bool first);
  std::optional<Waypoints> run(const ompl::base::OptimizationObjectivePtr& objective,
                               std::uint64_t seed, std::uint64_t budget);
  std::optional<Waypoints> runOnce(const ompl::base::OptimizationObjectivePtr& objective,
                                   std::uint64_t seed, std::uint64_t last_iteration,
                                   std::uint64_t round);
  ompl::base::GoalPtr goalFor(const ompl::base::Planner& planner, std::uint64_t round);
  bool endInGoal(Waypoints& path);

  std::shared_ptr<const CompiledScene> scene_;
  std::shared_ptr<CertifierPool> pool_;
  SearchTask task_;
  std::map<std::string, std::string> parameters_;
  ompl::base::SpaceInformationPtr space_information_;
  const PlannerTraits* traits_;
};

inline void addStatistics(EdgeCertifier::Statistics& sum, const EdgeCertifier::Statistics& more) {
  sum.states += more.states;
  sum.edges += more.edges;
  sum.distance_queries += more.distance_queries;
  sum.intervals += more.intervals;
}

/// A path whose least clearance is as great as the limits allow, found by a planner that only looks
/// for any path: searches with rising margins, see clearance_search.cc. `bound`: no path can have
/// more [m].
struct ClearancePath {
  Waypoints path;
  double clearance;                ///< certified lower bound [m]
  EdgeCertifier::Statistics work;  ///< of the searches with raised margins
};
std::optional<ClearancePath> searchClearance(const std::shared_ptr<const CompiledScene>& scene,
                                             Search& search, const SearchTask& task, double bound);

/// Certified lower bound of a path's clearance to within tolerance [m]; stops below `cutoff`.
double pathClearance(EdgeCertifier& certifier, const Waypoints& path, double tolerance,
                     double cutoff);

}  // namespace leeway::planner
