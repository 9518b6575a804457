#include "tools/lab/planning/rival_space.h"

#include <ompl/base/DiscreteMotionValidator.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/goals/GoalStates.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <span>

#include "tools/lab/planning/rival_states.h"

namespace leeway::tools::report {
namespace {

namespace ob = ompl::base;

/// A validity checker that passes states of our space to the rival's checkers.
class RivalValidity : public ob::StateValidityChecker {
 public:
  RivalValidity(const ob::SpaceInformationPtr& information, const planner::CompiledScene& scene,
                StateChecker& checker, StateChecker* distances)
      : StateValidityChecker(information), states_(scene, checker) {
    if (distances != nullptr) distances_.emplace(scene, *distances);
  }

  bool isValid(const ob::State* state) const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return si_->satisfiesBounds(state) && states_.isFree(pointOf(state));
  }
  double clearance(const ob::State* state) const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return distances_ ? distances_->distance(pointOf(state)) : 0;
  }

 private:
  std::span<const double> pointOf(const ob::State* state) const {
    return static_cast<const planner::OmplStateSpace&>(*si_->getStateSpace()).point(state);
  }

  mutable std::mutex mutex_;  ///< PRM* has a second thread, which computes path costs
  mutable RivalStates states_;
  mutable std::optional<RivalStates> distances_;
};

}  // namespace

RivalSpace::RivalSpace(std::shared_ptr<const planner::CompiledScene> scene, StateChecker& checker,
                       StateChecker* distances, double resolution, std::uint64_t seed)
    : scene_(std::move(scene)),
      space_(std::make_shared<planner::OmplStateSpace>(
          std::shared_ptr<const planner::ConfigurationSpace>(scene_, &scene_->space()), seed)),
      information_(std::make_shared<ob::SpaceInformation>(space_)) {
  information_->setStateValidityChecker(
      std::make_shared<RivalValidity>(information_, *scene_, checker, distances));
  information_->setMotionValidator(std::make_shared<ob::DiscreteMotionValidator>(information_));
  information_->setStateValidityCheckingResolution(resolution);
  information_->setup();
}

ob::ProblemDefinitionPtr RivalSpace::definition(const std::vector<double>& start,
                                                const Rows& goals) const {
  auto definition = std::make_shared<ob::ProblemDefinition>(information_);
  const auto state = [&](const std::vector<double>& point) {
    ob::ScopedState<planner::OmplStateSpace> s(space_);
    std::copy(point.begin(), point.end(), space_->point(s.get()).begin());
    return s;
  };
  definition->addStartState(state(start));
  const auto goal = std::make_shared<ob::GoalStates>(information_);
  for (const std::vector<double>& point : goals) goal->addState(state(point));
  definition->setGoal(goal);
  return definition;
}

Rows RivalSpace::rowsOf(ompl::geometric::PathGeometric& path) const {
  Rows rows;
  for (const ob::State* s : path.getStates()) {
    const auto point = space_->point(s);
    rows.emplace_back(point.begin(), point.end());
  }
  return rows;
}

Rows pointsOf(const planner::Problem& problem) {
  Rows points;
  for (const planner::Goal& goal : problem.goals) {
    const bool single = !goal.ranges.empty() && goal.poses.empty() &&
                        std::all_of(goal.ranges.begin(), goal.ranges.end(),
                                    [](const auto& range) { return range.first == range.second; });
    if (!single) continue;
    points.emplace_back();
    for (const auto& range : goal.ranges) points.back().push_back(range.first);
  }
  return points;
}

bool collides(planner::EdgeCertifier& certifier, const Rows& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (certifier.certify(path[i - 1], path[i], planner::EdgeRequest::persistent()).verdict ==
        collision::Verdict::kNotFree)
      return true;
  return false;
}

}  // namespace leeway::tools::report
