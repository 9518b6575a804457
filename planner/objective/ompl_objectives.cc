#include "leeway/planner/ompl_objectives.h"

#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/samplers/informed/RejectionInfSampler.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/edge/ompl_point.h"
#include "planner/objective/path_cost.h"
#include "planner/space/ompl_lock.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;

ob::InformedSamplerPtr rejectionSampler(const ob::ProblemDefinitionPtr& problem,
                                        unsigned int attempts) {
  const std::lock_guard<std::recursive_mutex> lock(omplSeedLock());
  return std::make_shared<ob::RejectionInfSampler>(problem, attempts);
}

double smallestMargin(const collision::Scene& scene) { return scene.pairs().leastMargin(); }

}  // namespace

OmplLengthObjective::OmplLengthObjective(const ob::SpaceInformationPtr& space_information)
    : PathLengthOptimizationObjective(space_information) {}

ob::InformedSamplerPtr OmplLengthObjective::allocInformedStateSampler(
    const ob::ProblemDefinitionPtr& problem, unsigned int attempts) const {
  return rejectionSampler(problem, attempts);
}

OmplClearanceObjective::OmplClearanceObjective(const ob::SpaceInformationPtr& space_information,
                                               std::shared_ptr<CertifierPool> pool,
                                               double tolerance, Pairs pairs)
    : OptimizationObjective(space_information),
      pool_(std::move(pool)),
      tolerance_(tolerance),
      cutoff_(smallestMargin(pool_->scene().scene())),
      pairs_(pairs) {
  description_ = "Least clearance, certified";
  threshold_ = ob::Cost(kInfinity);
}

bool OmplClearanceObjective::isSatisfied(ob::Cost cost) const {
  return cost.value() >= threshold_.value();
}

bool OmplClearanceObjective::isCostBetterThan(ob::Cost a, ob::Cost b) const {
  return a.value() > b.value();
}

ob::Cost OmplClearanceObjective::stateCost(const ob::State* state) const {
  return motionCost(state, state);
}

ob::Cost OmplClearanceObjective::motionCost(const ob::State* s1, const ob::State* s2) const {
  return ob::Cost(pool_->local()
                      .certifier
                      .edgeClearance(pointOf(s1, pool_->scene()), pointOf(s2, pool_->scene()),
                                     {.tolerance = tolerance_, .cutoff = cutoff_, .pairs = pairs_})
                      .clearance.lower);
}

ob::Cost OmplClearanceObjective::combineCosts(ob::Cost a, ob::Cost b) const {
  return ob::Cost(std::min(a.value(), b.value()));
}

ob::Cost OmplClearanceObjective::identityCost() const { return ob::Cost(kInfinity); }
ob::Cost OmplClearanceObjective::infiniteCost() const { return ob::Cost(-kInfinity); }
ob::Cost OmplClearanceObjective::initialCost(const ob::State* state) const {
  return stateCost(state);
}

ob::InformedSamplerPtr OmplClearanceObjective::allocInformedStateSampler(
    const ob::ProblemDefinitionPtr& problem, unsigned int attempts) const {
  return rejectionSampler(problem, attempts);
}

OmplCostObjective::OmplCostObjective(const ob::SpaceInformationPtr& space_information,
                                     const std::shared_ptr<CertifierPool>& pool,
                                     const Problem& problem)
    : OmplCostObjective(
          space_information, pool,
          (pool->scene().requireProblem(problem), PathCost::of(pool->scene(), problem))) {}

OmplCostObjective::OmplCostObjective(const ob::SpaceInformationPtr& space_information,
                                     std::shared_ptr<CertifierPool> pool,
                                     std::shared_ptr<PathCost> cost)
    : OptimizationObjective(space_information), pool_(std::move(pool)), cost_(std::move(cost)) {
  if (cost_ == nullptr)
    throw std::invalid_argument(
        "OmplCostObjective: the problem has no costs; a MinimumCost, or "
        "wishes, are expected");
  if (!cost_->isAdditive())
    throw std::invalid_argument(
        "OmplCostObjective: the cost of a path's worst place does not add "
        "up; integrals are expected");
  description_ = "Cost of length and nearness, certified";
  threshold_ = ob::Cost(0);
}

bool OmplCostObjective::isSatisfied(ob::Cost cost) const {
  return cost.value() <= threshold_.value();
}

ob::Cost OmplCostObjective::stateCost(const ob::State*) const { return identityCost(); }

ob::Cost OmplCostObjective::motionCost(const ob::State* s1, const ob::State* s2) const {
  return ob::Cost(cost_
                      ->edge(pointOf(s1, pool_->scene()), pointOf(s2, pool_->scene()),
                             {.work_limit = kSearchCostWork})
                      .sum.upper);
}

ob::Cost OmplCostObjective::motionCostHeuristic(const ob::State* s1, const ob::State* s2) const {
  return ob::Cost(cost_->leastBetween(pointOf(s1, pool_->scene()), pointOf(s2, pool_->scene())));
}

ob::InformedSamplerPtr OmplCostObjective::allocInformedStateSampler(
    const ob::ProblemDefinitionPtr& problem, unsigned int attempts) const {
  return rejectionSampler(problem, attempts);
}

}  // namespace leeway::planner
