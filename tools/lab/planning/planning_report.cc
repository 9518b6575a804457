#include "tools/lab/planning/planning_report.h"

#include <fmt/format.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/simplify.h"
#include "leeway/robots/input_error.h"
#include "planner/base/clock.h"
#include "planner/space/ompl_lock.h"
#include "planner/space/ompl_planners.h"
#include "tools/lab/planning/rival_space.h"

namespace leeway::tools::report {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using planner::Clock;
using planner::secondsSince;

/// OMPL's RRTConnect and simplifier in steps.
class RivalPlan {
 public:
  RivalPlan(std::shared_ptr<const planner::CompiledScene> scene, StateChecker& checker,
            const PlanningReportOptions& options, std::uint64_t seed)
      : space_(std::move(scene), checker, nullptr, options.resolution, seed), seed_(seed) {}

  Rows run(const std::vector<double>& start, const Rows& goals, double time, PlanningRow& row) {
    const auto begin = Clock::now();
    const ob::ProblemDefinitionPtr definition = space_.definition(start, goals);
    std::optional<og::RRTConnect> planner;
    std::optional<og::PathSimplifier> simplifier;
    {
      const std::lock_guard<std::recursive_mutex> lock(planner::omplSeedLock());
      planner::seedOmpl(seed_);
      planner.emplace(space_.information());
      simplifier.emplace(space_.information());
    }
    planner->setProblemDefinition(definition);
    planner->setup();
    planner->solve(ob::timedPlannerTerminationCondition(time));
    row.plan_s = secondsSince(begin);
    row.status = definition->hasExactSolution() ? "solved" : "unsolved";
    if (!row.solved()) return {};
    auto path = std::static_pointer_cast<og::PathGeometric>(definition->getSolutionPath());
    const auto simplify = Clock::now();
    simplifier->simplify(*path, std::max(0.0, time - row.plan_s), true);
    row.simplify_s = secondsSince(simplify);
    return space_.rowsOf(*path);
  }

 private:
  RivalSpace space_;
  std::uint64_t seed_;
};

PlanningRow ours(const PlanningProblem& named, std::uint64_t seed, double time, Rows& path) {
  planner::Problem problem = named.problem;
  problem.seed = seed;
  problem.limits.time = time;
  const planner::PlanResult result = planner::plan(problem);
  PlanningRow row{named.name, named.set, "Leeway", seed};
  row.status = planner::toString(result.status);
  row.compile_s = result.compile_s, row.plan_s = result.plan_s;
  row.simplify_s = result.simplify_s, row.improve_s = result.improve_s;
  row.push_s = result.push_s, row.certify_s = result.certify_s;
  row.iterations = result.iterations, row.length = result.length;
  path = result.path.positions;
  return row;
}

/// Runs after our plan, whose last point is the goal if no goal of the problem is a single
/// configuration.
PlanningRow theirs(const PlanningProblem& named, const StateEngine& engine,
                   const PlanningReportOptions& options, std::uint64_t seed, const Rows& path) {
  PlanningRow row{named.name, named.set,
                  fmt::format("RRTConnect, {} at {:g} %", engine.name(), 100 * options.resolution),
                  seed};
  row.status = "left out";
  Rows goals = pointsOf(named.problem);
  if (goals.empty() && !path.empty()) goals.push_back(path.back());
  if (goals.empty()) return row;
  planner::Problem problem = named.problem;
  problem.margins = {};
  const auto scene = std::make_shared<const planner::CompiledScene>(problem);
  const auto begin = Clock::now();
  const auto checker = engine.prepare(scene->scene());
  if (!checker) return row;
  row.compile_s = secondsSince(begin);
  const planner::QuietOmpl quiet;
  RivalPlan plan(scene, *checker, options, seed);
  const Rows rows = plan.run(startPoint(problem), goals, options.time, row);
  if (!row.solved()) return row;
  row.length = planner::pathLength(scene->space(), rows);
  planner::EdgeCertifier certifier(scene);
  row.colliding = collides(certifier, rows);
  return row;
}

}  // namespace

std::vector<PlanningRow> measurePlanning(const std::vector<PlanningProblem>& problems,
                                         const std::vector<const StateEngine*>& rivals,
                                         const PlanningReportOptions& options) {
  std::vector<PlanningRow> rows;
  for (const PlanningProblem& named : problems)
    for (int k = 0; k < options.seeds; ++k) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(k);
      if (options.progress) options.progress(fmt::format("{}, seed {}", named.name, seed));
      Rows path;
      std::vector<PlanningRow> added{ours(named, seed, options.time, path)};
      if (added.back().solved()) {
        const auto scene = std::make_shared<const planner::CompiledScene>(named.problem);
        planner::EdgeCertifier certifier(scene);
        added.back().colliding = collides(certifier, path);
      }
      for (const StateEngine* engine : rivals)
        added.push_back(theirs(named, *engine, options, seed, path));
      if (options.on_rows) options.on_rows(added);
      rows.insert(rows.end(), added.begin(), added.end());
    }
  return rows;
}

}  // namespace leeway::tools::report
