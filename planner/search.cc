#include "planner/search.h"

#include <ompl/base/ProblemDefinition.h>
#include <ompl/geometric/PathGeometric.h>

#include <algorithm>
#include <limits>

#include "planner/ompl_lock.h"
#include "planner/ompl_point.h"
#include "planner/planners.h"
#include "planner/tolerances.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The k-th run of a planner within one plan has seeds of its own.
std::uint64_t runSeed(std::uint64_t seed, std::uint64_t run) {
  return Random(seed, kRunStream + run).next();
}

}  // namespace

Search::Search(std::shared_ptr<const CompiledScene> scene, std::shared_ptr<CertifierPool> pool,
               const SearchTask& task)
    : scene_(std::move(scene)),
      pool_(std::move(pool)),
      task_(task),
      parameters_(task.problem.planner_parameters),
      space_information_(makeSpaceInformation(scene_, task.problem.seed, pool_)) {
  const PlannerTraits* traits = findPlanner(task_.problem.planner);
  if (traits != nullptr && traits->name == "RRTConnect" && parameters_.count("range") == 0)
    parameters_["range"] = std::to_string(kConnectRange * space_information_->getMaximumExtent());
}

std::optional<Waypoints> Search::shortest(std::uint64_t seed, std::uint64_t budget) {
  auto objective = std::make_shared<OmplLengthObjective>(space_information_);
  // A planner that does not optimise must be content with its first path; some of them look here.
  const PlannerTraits* traits = findPlanner(task_.problem.planner);
  objective->setCostThreshold(ob::Cost(traits != nullptr && traits->optimizing ? 0 : kInfinity));
  return run(objective, seed, budget);
}

std::optional<Waypoints> Search::widest(std::uint64_t seed, double enough) {
  auto objective =
      std::make_shared<OmplClearanceObjective>(space_information_, pool_, kClearanceTolerance);
  objective->setCostThreshold(ob::Cost(enough));
  return run(objective, seed, 0);
}

std::optional<Waypoints> Search::run(const ob::OptimizationObjectivePtr& objective,
                                     std::uint64_t seed, std::uint64_t budget) {
  Limits& limits = task_.limits;
  const std::uint64_t last =
      budget > 0 ? limits.iterations() + budget : std::numeric_limits<std::uint64_t>::max();
  int idle = 0;
  for (std::uint64_t round = 0; !limits.searchOver() && limits.iterations() < last; ++round) {
    const std::uint64_t before = limits.iterations();
    if (auto path = runOnce(objective, runSeed(seed, round), last)) return path;
    // A planner that gives up without an iteration would do so for ever.
    idle = limits.iterations() == before ? idle + 1 : 0;
    if (idle == kIdleRuns) break;
  }
  return std::nullopt;
}

std::optional<Waypoints> Search::runOnce(const ob::OptimizationObjectivePtr& objective,
                                         std::uint64_t seed, std::uint64_t last_iteration) {
  auto definition = std::make_shared<ob::ProblemDefinition>(space_information_);
  ob::State* start = space_information_->allocState();
  std::copy(task_.start.begin(), task_.start.end(), pointOf(start, *scene_).begin());
  definition->addStartState(start);
  space_information_->freeState(start);
  definition->setGoal(std::make_shared<GoalRegions>(space_information_, scene_->space(),
                                                    task_.problem, task_.goals));
  definition->setOptimizationObjective(objective);

  ob::PlannerPtr planner;
  {
    const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
    seedOmpl(seed);
    planner = makePlanner(task_.problem.planner, parameters_, space_information_);
    planner->setProblemDefinition(definition);
    planner->setup();
  }
  Limits& limits = task_.limits;
  planner->solve(ob::PlannerTerminationCondition([&limits, last_iteration] {
    return limits.iterations() >= last_iteration || limits.iterate();
  }));
  if (!definition->hasExactSolution()) return std::nullopt;

  const auto solution =
      std::dynamic_pointer_cast<ompl::geometric::PathGeometric>(definition->getSolutionPath());
  if (!solution) return std::nullopt;
  Waypoints path;
  for (const ob::State* state : solution->getStates()) {
    const std::span<const double> q = pointOf(state, *scene_);
    path.emplace_back(q.begin(), q.end());
  }
  if (path.empty() || path.front() != task_.start) return std::nullopt;
  if (path.size() == 1) path.push_back(path.front());
  const auto goal = std::find_if(
      task_.problem.goals.begin(), task_.problem.goals.end(),
      [&](const planner::Goal& g) { return goalHolds(scene_->space(), g, path.back()); });
  if (goal == task_.problem.goals.end()) return std::nullopt;
  writeAsInGoal(scene_->space(), *goal, path.back());
  if (!certified(path)) return std::nullopt;
  return path;
}

bool Search::certified(const Waypoints& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (certifier().certify(path[i - 1], path[i]).verdict != Verdict::kFree) return false;
  return true;
}

double pathClearance(EdgeCertifier& certifier, const Waypoints& path, double tolerance,
                     double cutoff) {
  double clearance = kInfinity;
  for (std::size_t i = 1; i < path.size() && clearance >= cutoff; ++i)
    clearance =
        std::min(clearance,
                 certifier.edgeClearance(path[i - 1], path[i], tolerance, cutoff).clearance.lower);
  return clearance;
}

}  // namespace leeway::planner
