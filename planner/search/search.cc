#include "planner/search/search.h"

#include <ompl/base/PlannerData.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/util/Exception.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/edge/ompl_point.h"
#include "planner/search/run_seed.h"
#include "planner/space/ompl_lock.h"
#include "planner/space/ompl_planners.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;

/// A search for a shorter path: iterations of its first run, which terms of Luby's series multiply,
/// and total iterations before the best path is simplified again instead.
constexpr std::uint64_t kImproveRun = 500;
constexpr std::uint64_t kImproveBudget = 2000;

/// A parameter's text. It does not use std::to_string, which follows the program's locale.
std::string digits(double x) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

}  // namespace

Search::Search(std::shared_ptr<const CompiledScene> scene, std::shared_ptr<CertifierPool> pool,
               const SearchTask& task)
    : scene_(std::move(scene)),
      pool_(std::move(pool)),
      task_(task),
      parameters_(task.problem.planner.parameters),
      traits_(findPlanner(task.problem.planner.name)),
      own_(traits_->name == kOwnPlanner) {
  if (own_) return;
  space_information_ = makeSpaceInformation(scene_, task.problem.seed, pool_);
  const double extent = space_information_->getMaximumExtent();
  if (traits_->name == "RRTConnect")
    parameters_.emplace("range", digits(kConnectRange * usefulExtent(scene_->space())));
  if (traits_->name == "SST") {  // OMPL's defaults are lengths of 3 and 5 for every space
    parameters_.emplace("range", digits(kStepRange * extent));
    parameters_.emplace("selection_radius", digits(kSelectionRadius * extent));
    parameters_.emplace("pruning_radius", digits(kPruningRadius * extent));
  }
}

std::optional<Waypoints> Search::shortest(std::uint64_t seed) {
  return search(seed, 0, !traits_->optimizing);
}

std::optional<Waypoints> Search::any(std::uint64_t seed, std::uint64_t budget) {
  return search(seed, budget, true);
}

std::optional<Waypoints> Search::search(std::uint64_t seed, std::uint64_t budget, bool first) {
  if (own_) return connect(seed, budget, kInfinity);
  auto objective = std::make_shared<OmplLengthObjective>(space_information_);
  // Some planners that do not optimise still check whether their first path is good enough; it
  // always is.
  objective->setCostThreshold(ob::Cost(first ? kInfinity : 0));
  return run(objective, seed, budget);
}

std::optional<Waypoints> Search::widest(std::uint64_t seed, double enough) {
  const auto* wanted = std::get_if<MaximumClearance>(&task_.problem.objective);
  auto objective = std::make_shared<OmplClearanceObjective>(
      space_information_, pool_, kClearanceTolerance, wanted != nullptr ? wanted->of : Pairs::kAll);
  objective->setCostThreshold(ob::Cost(enough));
  return run(objective, seed, 0);
}

std::optional<Waypoints> Search::cheapest(std::uint64_t seed, const std::shared_ptr<PathCost>& cost,
                                          double enough) {
  auto objective = std::make_shared<OmplCostObjective>(space_information_, pool_, cost);
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
    if (auto path = runOnce(objective, runSeed(seed, round), last, round)) return path;
    // A planner that gives up without an iteration would always do so.
    idle = limits.iterations() == before ? idle + 1 : 0;
    if (idle == kIdleRuns) break;
  }
  return std::nullopt;
}

std::optional<Waypoints> Search::shorter(std::uint64_t seed, double bound) {
  return connect(seed, kImproveBudget, bound);
}

double Search::improves() const {
  return own_ ? connectChoice(parameters_, scene_->space()).improve : 0;
}

std::optional<Waypoints> Search::connect(std::uint64_t seed, std::uint64_t budget, double bound) {
  Waypoints goals = task_.goals.points;
  if (task_.checked_in != scene_.get()) {  // raised margins may exclude the ends
    std::erase_if(goals, [this](const std::vector<double>& goal) {
      return certifier().decide(goal) != Verdict::kFree;
    });
    if (goals.empty() || certifier().decide(task_.start) != Verdict::kFree) return std::nullopt;
  }
  const std::function<bool(Waypoints&, EdgeCertifier&, bool)> accept =
      [this](Waypoints& path, EdgeCertifier& own, bool is_certified) {
        const Waypoints::size_type size = path.size();
        const std::vector<double> end = path.back();
        if (!endInGoal(path)) return false;
        return (is_certified && path.size() == size && path.back() == end) ||
               (isCertified(own, path) && keepsConstraints(path));
      };
  ConnectQuery query{scene_,
                     task_.start,
                     goals,
                     seed,
                     accept,
                     task_.limits,
                     budget > 0 ? budget : std::numeric_limits<std::uint64_t>::max(),
                     task_.on_edge,
                     bound,
                     bound < kInfinity ? kImproveRun : kConnectRun,
                     {},
                     isConstrained(task_.problem) ? &task_.problem : nullptr};
  const ConnectChoice choice = connectChoice(parameters_, scene_->space());
  GoalSupply* supply = bound < kInfinity ? nullptr : task_.supply;
  if (supply != nullptr) {
    supply->open(choice.workers > 1);
    query.more_goals = [supply](std::size_t k, Waypoints& more) { return supply->add(k, more); };
  }
  ConnectResult result = searchConnect(query, choice, certifier());
  if (supply != nullptr) supply->close(result.goal_batches);
  work_ += result.work;
  hindrance_ += result.hindrance;
  return std::move(result.path);
}

Hindrance Search::hindrance() const {
  Hindrance all = hindrance_;
  all += {pool_->blocked(), {}};
  return all;
}

std::optional<Waypoints> Search::runOnce(const ob::OptimizationObjectivePtr& objective,
                                         std::uint64_t seed, std::uint64_t last_iteration,
                                         std::uint64_t round) {
  auto definition = std::make_shared<ob::ProblemDefinition>(space_information_);
  ob::State* start = space_information_->allocState();
  std::copy(task_.start.begin(), task_.start.end(), pointOf(start, *scene_).begin());
  definition->addStartState(start);
  space_information_->freeState(start);
  definition->setOptimizationObjective(objective);

  ob::PlannerPtr planner;
  {
    const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
    seedOmpl(seed);
    planner = makePlanner(task_.problem.planner.name, parameters_, space_information_);
    definition->setGoal(goalFor(*planner, round));
    planner->setProblemDefinition(definition);
    planner->setup();
  }
  Limits& limits = task_.limits;
  const bool tells_length = traits_->optimizing && traits_->deterministic &&
                            dynamic_cast<const OmplLengthObjective*>(objective.get()) != nullptr;
  if (tells_length) limits.describe([&] { return describeBest(*planner); });
  const std::shared_ptr<void> forget(nullptr, [&limits](void*) { limits.describe(nullptr); });
  try {
    planner->solve(ob::PlannerTerminationCondition([&limits, last_iteration] {
      return limits.iterations() >= last_iteration || limits.iterate();
    }));
  } catch (const ompl::Exception&) {
    return std::nullopt;  // an internal error of OMPL; the next run may find a path
  }
  if (task_.on_edge) reportGraph(*planner);
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
  if (!endInGoal(path) || !isCertified(certifier(), path)) return std::nullopt;
  return path;
}

std::string Search::describeLength(double length) const {
  if (!std::isfinite(length)) return {};
  const auto text = [](double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.3f", x);
    return std::string(buffer);
  };
  double straight = kInfinity;
  for (const Goal& goal : task_.problem.goals) {
    if (!isPoint(goal)) return ", length " + text(length);
    std::vector<double> point;
    for (const auto& [lower, upper] : goal.ranges) point.push_back(lower);
    straight = std::min(straight, scene_->space().distance(task_.start, point));
  }
  // Rounded down, because it is a bound.
  return ", length " + text(length) + ", none is below " + text(std::floor(1e3 * straight) / 1e3);
}

/// The progress that OMPL's planners report while they run; empty for those that report none.
std::string Search::describeBest(const ob::Planner& planner) const {
  for (const auto& [name, value] : planner.getPlannerProgressProperties())
    if (name.rfind("best cost", 0) == 0)
      return describeLength(std::strtod(value().c_str(), nullptr));
  return {};
}

ob::GoalPtr Search::goalFor(const ob::Planner& planner, std::uint64_t round) {
  if (planner.getSpecs().recognizedGoal == ob::GOAL_STATE) {  // takes one goal per run, in turn
    auto goal = std::make_shared<ob::GoalState>(space_information_);
    ob::State* state = space_information_->allocState();
    const std::vector<double>& point = task_.goals.points[round % task_.goals.points.size()];
    std::copy(point.begin(), point.end(), pointOf(state, *scene_).begin());
    goal->setState(state);
    space_information_->freeState(state);
    return goal;
  }
  auto goal = std::make_shared<GoalRegions>(space_information_, scene_->space(), task_.problem,
                                            task_.goals);
  if (!traits_->exact) goal->setThreshold(kNearGoal * space_information_->getMaximumExtent());
  return goal;
}

void Search::reportGraph(const ob::Planner& planner) const {
  ob::PlannerData graph(space_information_);
  planner.getPlannerData(graph);
  std::vector<unsigned int> ends;
  for (unsigned int v = 0; v < graph.numVertices(); ++v) {
    graph.getEdges(v, ends);
    for (const unsigned int end : ends)
      task_.on_edge(pointOf(graph.getVertex(v).getState(), *scene_),
                    pointOf(graph.getVertex(end).getState(), *scene_));
  }
}

/// Makes the path end in a goal, as the goal is written. If the planner only came near, adds a
/// certified edge from the last waypoint that has one. False if that fails.
bool Search::endInGoal(Waypoints& path) {
  const ConfigurationSpace& space = scene_->space();
  if (!traits_->exact) {
    const std::vector<double>& last = path.back();
    const std::vector<double> goal = *std::min_element(
        task_.goals.points.begin(), task_.goals.points.end(), [&](const auto& a, const auto& b) {
          return space.distance(last, a) < space.distance(last, b);
        });
    while (!path.empty() &&
           certifier().certify(path.back(), goal, EdgeRequest::persistent()).verdict !=
               Verdict::kFree)
      path.pop_back();
    if (path.empty()) return false;
    path.push_back(goal);
  }
  if (path.size() == 1) path.push_back(path.front());
  const auto& goals = task_.problem.goals;
  const auto goal = std::find_if(goals.begin(), goals.end(), [&](const planner::Goal& g) {
    return goalHolds(*scene_, g, path.back());
  });
  if (goal == goals.end()) return false;
  writeAsInGoal(space, *goal, path.back());
  return true;
}

bool Search::keepsConstraints(const Waypoints& path) const {
  if (!isConstrained(task_.problem)) return true;
  ConstraintProof proof(*scene_, task_.problem);
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!proof.holds(path[i - 1], path[i])) return false;
  return true;
}

bool Search::isCertified(EdgeCertifier& certifier, const Waypoints& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (certifier.certify(path[i - 1], path[i], EdgeRequest::persistent()).verdict !=
        Verdict::kFree)
      return false;
  return true;
}

double pathClearance(EdgeCertifier& certifier, const Waypoints& path, double tolerance,
                     double cutoff, Pairs pairs) {
  double clearance = kInfinity;
  for (std::size_t i = 1; i < path.size() && clearance >= cutoff; ++i)
    clearance = std::min(
        clearance, certifier
                       .edgeClearance(path[i - 1], path[i],
                                      {.tolerance = tolerance, .cutoff = cutoff, .pairs = pairs})
                       .clearance.lower);
  return clearance;
}

}  // namespace leeway::planner
