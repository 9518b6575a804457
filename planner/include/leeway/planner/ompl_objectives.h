#pragma once

#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>

#include <memory>

#include "leeway/planner/ompl_validity.h"

namespace leeway::planner {

/// The length of a path in the space's distance; smaller is better. Informed planners sample by
/// rejection from our samplers, because OMPL's direct sampler supports only its own spaces and the
/// process's seed.
class OmplLengthObjective : public ompl::base::PathLengthOptimizationObjective {
 public:
  explicit OmplLengthObjective(const ompl::base::SpaceInformationPtr& space_information);
  ompl::base::InformedSamplerPtr allocInformedStateSampler(
      const ompl::base::ProblemDefinitionPtr& problem, unsigned int attempts) const override;
};

/// The least clearance along a path, of all pairs or some [m]; larger is better. Costs combine by
/// minimum. An edge's cost is a certified lower bound over the whole edge. It is at most
/// `tolerance` below the true value if the edge keeps the margins, otherwise any value up to the
/// smallest margin. Satisfied at getCostThreshold(), infinity unless set.
class OmplClearanceObjective : public ompl::base::OptimizationObjective {
 public:
  OmplClearanceObjective(const ompl::base::SpaceInformationPtr& space_information,
                         std::shared_ptr<CertifierPool> pool, double tolerance = 1e-3,
                         Pairs pairs = Pairs::kAll);

  bool isSatisfied(ompl::base::Cost cost) const override;
  bool isCostBetterThan(ompl::base::Cost a, ompl::base::Cost b) const override;
  ompl::base::Cost stateCost(const ompl::base::State* state) const override;
  ompl::base::Cost motionCost(const ompl::base::State* s1,
                              const ompl::base::State* s2) const override;
  ompl::base::Cost combineCosts(ompl::base::Cost a, ompl::base::Cost b) const override;
  ompl::base::Cost identityCost() const override;
  ompl::base::Cost infiniteCost() const override;
  /// The start's cost, which bounds every path from it.
  ompl::base::Cost initialCost(const ompl::base::State* state) const override;
  ompl::base::InformedSamplerPtr allocInformedStateSampler(
      const ompl::base::ProblemDefinitionPtr& problem, unsigned int attempts) const override;

 private:
  std::shared_ptr<CertifierPool> pool_;
  double tolerance_;
  double cutoff_;  ///< smallest margin of the scene [m]
  Pairs pairs_;
};

class PathCost;

/// The cost of a path by a problem's MinimumCost, or by its length and its wishes; smaller is
/// better. Costs add up. An edge's cost is the upper end of a certified interval over the whole
/// edge, so a path never costs more than its reported cost. The interval is 1 % wide, or wider if
/// that would take more than a millisecond. The heuristic is the weight of length times the
/// distance of two states, a lower bound of every cost between them. Satisfied at
/// getCostThreshold(), 0 unless set. For planners whose arithmetic supports any cost, see
/// PlannerTraits::costs. Thread-safe.
class OmplCostObjective : public ompl::base::OptimizationObjective {
 public:
  /// Throws std::invalid_argument for a problem without such costs, or with a cost for the worst
  /// place of a path, because that does not add up. Throws robots::InputError for a problem that is
  /// invalid or does not match the scene: CompiledScene::requireProblem().
  OmplCostObjective(const ompl::base::SpaceInformationPtr& space_information,
                    const std::shared_ptr<CertifierPool>& pool, const Problem& problem);
  OmplCostObjective(const ompl::base::SpaceInformationPtr& space_information,
                    std::shared_ptr<CertifierPool> pool, std::shared_ptr<PathCost> cost);

  bool isSatisfied(ompl::base::Cost cost) const override;
  ompl::base::Cost stateCost(const ompl::base::State* state) const override;
  ompl::base::Cost motionCost(const ompl::base::State* s1,
                              const ompl::base::State* s2) const override;
  ompl::base::Cost motionCostHeuristic(const ompl::base::State* s1,
                                       const ompl::base::State* s2) const override;
  ompl::base::InformedSamplerPtr allocInformedStateSampler(
      const ompl::base::ProblemDefinitionPtr& problem, unsigned int attempts) const override;

 private:
  std::shared_ptr<CertifierPool> pool_;
  std::shared_ptr<PathCost> cost_;
};

}  // namespace leeway::planner
