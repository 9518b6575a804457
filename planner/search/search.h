#pragma once

#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/Planner.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_objectives.h"
#include "leeway/planner/planners.h"
#include "planner/objective/path_cost.h"
#include "planner/search/connect_search.h"
#include "planner/search/goal_supply.h"
#include "planner/search/goals.h"
#include "planner/search/limits.h"

namespace leeway::planner {

/// The problem of a search, in any scene.
struct SearchTask {
  const Problem& problem;
  const std::vector<double>& start;
  const GoalPoints& goals;
  Limits& limits;
  const std::function<void(std::span<const double>, std::span<const double>)>& on_edge;
  /// Further goals for Connect's first path, drawn at its request; may be null.
  GoalSupply* supply = nullptr;
  /// The scene in which the start and the goals are known to be free.
  const CompiledScene* checked_in = nullptr;
};

/// Searches in one scene with the problem's planner. A planner that gives up before the limits is
/// restarted with another seed. Every edge of a returned path is certified; returns nullopt if no
/// path is found.
class Search {
 public:
  Search(std::shared_ptr<const CompiledScene> scene, std::shared_ptr<CertifierPool> pool,
         const SearchTask& task);

  EdgeCertifier& certifier() { return pool_->local().certifier; }

  /// The shortest path that a planner finds within the limits if it optimises, otherwise its first
  /// path.
  std::optional<Waypoints> shortest(std::uint64_t seed);
  /// The first path. `budget`: maximum number of iterations; 0: the remaining limits.
  std::optional<Waypoints> any(std::uint64_t seed, std::uint64_t budget = 0);
  /// The path of greatest clearance; ends early at `enough` [m]. For planners that support any
  /// cost.
  std::optional<Waypoints> widest(std::uint64_t seed, double enough);
  /// The path of least cost, which adds up; ends early at `enough`. For planners that optimise and
  /// can minimise costs.
  std::optional<Waypoints> cheapest(std::uint64_t seed, const std::shared_ptr<PathCost>& cost,
                                    double enough);
  /// Connect only: a path shorter than `bound`, in the space's distance.
  std::optional<Waypoints> shorter(std::uint64_t seed, double bound);
  /// The time for finding shorter paths [s]; 0 for planners other than Connect.
  double improves() const;
  /// For the caller's progress: a length and, if all goals are points, the straight length, a lower
  /// bound for every path.
  std::string describeLength(double length) const;
  /// The statistics of certifiers outside the pool.
  const EdgeCertifier::Statistics& work() const { return work_; }
  /// The reasons of all searches that found no path.
  Hindrance hindrance() const;

 private:
  std::optional<Waypoints> connect(std::uint64_t seed, std::uint64_t budget, double bound);
  static bool isCertified(EdgeCertifier& certifier, const Waypoints& path);
  bool keepsConstraints(const Waypoints& path) const;
  std::optional<Waypoints> search(std::uint64_t seed, std::uint64_t budget, bool first);
  std::optional<Waypoints> run(const ompl::base::OptimizationObjectivePtr& objective,
                               std::uint64_t seed, std::uint64_t budget);
  std::optional<Waypoints> runOnce(const ompl::base::OptimizationObjectivePtr& objective,
                                   std::uint64_t seed, std::uint64_t last_iteration,
                                   std::uint64_t round);
  ompl::base::GoalPtr goalFor(const ompl::base::Planner& planner, std::uint64_t round);
  bool endInGoal(Waypoints& path);
  void reportGraph(const ompl::base::Planner& planner) const;
  std::string describeBest(const ompl::base::Planner& planner) const;

  std::shared_ptr<const CompiledScene> scene_;
  std::shared_ptr<CertifierPool> pool_;
  SearchTask task_;
  std::map<std::string, std::string> parameters_;
  ompl::base::SpaceInformationPtr space_information_;  ///< null for our own planner
  const PlannerTraits* traits_;
  bool own_;  ///< Connect: no OMPL object is made
  EdgeCertifier::Statistics work_;
  Hindrance hindrance_;  ///< of Connect
};

/// Certified lower bound on a path's clearance, to within tolerance [m]; stops once it is below
/// `cutoff`.
double pathClearance(EdgeCertifier& certifier, const Waypoints& path, double tolerance,
                     double cutoff, Pairs pairs = Pairs::kAll);

}  // namespace leeway::planner
