#include "leeway/planner/ompl_connect.h"

#include <ompl/base/goals/GoalSampleableRegion.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/util/Exception.h>
#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <memory>

#include "leeway/planner/ompl_state_space.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/space/connect_trees.h"

namespace leeway::planner {

namespace ob = ompl::base;

OmplConnect::OmplConnect(const ob::SpaceInformationPtr& space_information)
    : Planner(space_information, "Connect"), seed_(ompl::RNG().getLocalSeed()) {
  specs_.recognizedGoal = ob::GOAL_SAMPLEABLE_REGION;
  specs_.directed = true;
  declareParam<double>("range", this, &OmplConnect::setRange, &OmplConnect::getRange,
                       "0.:1.:10000.");
  declareParam<bool>("balance", this, &OmplConnect::setBalance, &OmplConnect::getBalance, "0,1");
  declareParam<bool>("dynamic_domain", this, &OmplConnect::setDynamicDomain,
                     &OmplConnect::getDynamicDomain, "0,1");
  declareParam<bool>("low_discrepancy", this, &OmplConnect::setLowDiscrepancy,
                     &OmplConnect::getLowDiscrepancy, "0,1");
}

void OmplConnect::setup() {
  if (dynamic_cast<const OmplStateSpace*>(si_->getStateSpace().get()) == nullptr)
    throw ompl::Exception(getName(), "the state space must be an OmplStateSpace");
  Planner::setup();
}

void OmplConnect::clear() {
  Planner::clear();
  runs_ = 0;
}

ob::PlannerStatus OmplConnect::solve(const ob::PlannerTerminationCondition& stop) {
  checkValidity();
  const auto& space = *si_->getStateSpace()->as<OmplStateSpace>();
  const auto* goal = dynamic_cast<const ob::GoalSampleableRegion*>(pdef_->getGoal().get());
  if (goal == nullptr) return ob::PlannerStatus::UNRECOGNIZED_GOAL_TYPE;
  const ob::State* start = pis_.nextStart();
  if (start == nullptr) return ob::PlannerStatus::INVALID_START;
  std::vector<std::vector<double>> goals;
  while (pis_.getSampledGoalsCount() < goal->maxSampleCount() &&
         goals.size() < static_cast<std::size_t>(kConnectGoals)) {
    const ob::State* state = goals.empty() ? pis_.nextGoal(stop) : pis_.nextGoal();
    if (state == nullptr) break;
    const std::span<const double> point = space.point(state);
    goals.emplace_back(point.begin(), point.end());
  }
  pis_.restart();  // the next call starts with the same start
  if (goals.empty()) return ob::PlannerStatus::INVALID_GOAL;

  ob::State *a = si_->allocState(), *b = si_->allocState();
  const std::function<bool(std::span<const double>, std::span<const double>)> is_free =
      [&](std::span<const double> from, std::span<const double> to) {
        std::copy(from.begin(), from.end(), space.point(a).begin());
        std::copy(to.begin(), to.end(), space.point(b).begin());
        return si_->checkMotion(a, b);
      };
  const std::span<const double> start_point = space.point(start);
  const ConnectSettings settings{range_ > 0 ? range_ : defaultRange(space.space()), balance_,
                                 dynamic_domain_,
                                 low_discrepancy_.value_or(!isBody(space.space()))};
  ConnectTrees trees({space.space(), start_point, goals, is_free}, settings,
                     Random(seed_, runs_++).next());
  bool met = false;
  while (!met && !stop) met = trees.iterate();
  if (met) {
    auto path = std::make_shared<ompl::geometric::PathGeometric>(si_);
    for (const std::vector<double>& point : trees.path()) {
      std::copy(point.begin(), point.end(), space.point(a).begin());
      path->append(a);
    }
    pdef_->addSolutionPath(path, false, 0, getName());
  }
  si_->freeState(a);
  si_->freeState(b);
  return met ? ob::PlannerStatus::EXACT_SOLUTION : ob::PlannerStatus::TIMEOUT;
}

}  // namespace leeway::planner
