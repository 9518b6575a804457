#include "tools/lab/bench/asked_edges.h"

#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>

#include <algorithm>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_state_space.h"
#include "leeway/planner/ompl_validity.h"
#include "leeway/planner/simplify.h"
#include "planner/edge/ompl_point.h"

namespace leeway::bench {

using namespace planner;
namespace ob = ompl::base;

std::vector<AskedEdge> AskedEdges::some(int most) const {
  std::vector<AskedEdge> all, some;
  for (const auto* ends : {&planning, &simplifying})
    for (std::size_t i = 0; i + 1 < ends->size(); i += 2)
      all.push_back({(*ends)[i], (*ends)[i + 1]});
  const std::size_t wanted = std::min(all.size(), static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < wanted; ++i) some.push_back(all[i * all.size() / wanted]);
  return some;
}

AskedEdges askedEdges(const planner::Problem& problem,
                      const std::shared_ptr<const planner::CompiledScene>& scene,
                      unsigned long long iterations) {
  AskedEdges asked;
  const std::vector<double> start = startPoint(problem);
  std::vector<double> goal;  // middle of the first goal's range
  for (const auto& [low, high] : problem.goals.front().ranges)
    goal.push_back(low + (high - low) / 2);
  const auto pool = std::make_shared<CertifierPool>(scene);
  EdgeCertifier& certifier = pool->local().certifier;
  if (certifier.decide(start) != Verdict::kFree || certifier.decide(goal) != Verdict::kFree)
    return asked;
  const ob::SpaceInformationPtr information = makeSpaceInformation(scene, problem.seed, pool);
  const auto definition = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> from(information), to(information);
  std::copy(start.begin(), start.end(), pointOf(from.get(), *scene).begin());
  std::copy(goal.begin(), goal.end(), pointOf(to.get(), *scene).begin());
  definition->setStartAndGoalStates(from, to);
  const auto planner = std::make_shared<ompl::geometric::RRTConnect>(information);
  planner->setProblemDefinition(definition);
  planner->setRange(0.08 * information->getMaximumExtent());
  certifier.trace = &asked.planning;
  unsigned long long looks = 0;
  const bool solved =
      planner->solve(ob::PlannerTerminationCondition([&] { return ++looks > iterations; })) ==
      ob::PlannerStatus::EXACT_SOLUTION;
  certifier.trace = &asked.simplifying;
  if (solved) {
    auto* path = definition->getSolutionPath()->as<ompl::geometric::PathGeometric>();
    std::vector<std::vector<double>> rows;
    for (const ob::State* state : path->getStates()) {
      const auto point = pointOf(state, *scene);
      rows.emplace_back(point.begin(), point.end());
    }
    SimplifyOptions options;
    options.seed = problem.seed;
    simplify(certifier, rows, options);
  }
  certifier.trace = nullptr;
  return asked;
}

}  // namespace leeway::bench
