#pragma once

#include <ompl/base/goals/GoalStates.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/ompl_state_space.h"
#include "leeway/planner/plan.h"

namespace leeway::planner {

/// The point of a goal's ranges nearest to q in the space's distance; q itself when the goal holds
/// it. Angles count modulo 2 pi; an orientation is given whole (a quaternion without width) or free
/// (ranges of [-1, 1]).
void nearestInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<const double> q,
                   std::span<double> nearest);

/// True when q is one of the goal's points, to the bit (angles modulo 2 pi).
bool goalHolds(const ConfigurationSpace& space, const Goal& goal, std::span<const double> q);

/// Puts angles of a point that the goal holds into the goal's ranges as they are written there.
void writeAsInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<double> q);

/// Valid points of the goals, ready for a planner.
struct GoalPoints {
  std::vector<std::vector<double>> points;
  std::vector<std::string> warnings;  ///< goals left out, and why
  bool stopped = false;               ///< by `stop`, with points left to try
  StateCheck closest;                 ///< when there is no point: the least bad of what was tried
};

/// A goal of one point is that point when it is valid; of a range come up to kGoalSamples valid
/// points, drawn from `seed`. Throws robots::InputError for a goal that no configuration can meet.
GoalPoints validGoalPoints(EdgeCertifier& certifier, const Problem& problem, std::uint64_t seed,
                           const std::function<bool()>& stop);

/// The goals as OMPL knows goals: their valid points to sample from, reached at any point of their
/// ranges.
class GoalRegions : public ompl::base::GoalStates {
 public:
  GoalRegions(const ompl::base::SpaceInformationPtr& space_information,
              const ConfigurationSpace& space, const Problem& problem, const GoalPoints& points);
  double distanceGoal(const ompl::base::State* state) const override;

 private:
  const ConfigurationSpace& space_;
  const Problem& problem_;
  bool ranges_ = false;  ///< some goal is more than its points
};

}  // namespace leeway::planner
