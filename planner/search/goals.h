#pragma once

#include <ompl/base/goals/GoalStates.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/ompl_state_space.h"
#include "leeway/planner/plan.h"

namespace leeway::planner {

/// Writes the point of a goal's ranges that is nearest to q in the space's distance; q itself when
/// it is in the goal. Angles count modulo 2 pi; an orientation is given whole (a quaternion without
/// width) or free (ranges of [-1, 1]).
void nearestInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<const double> q,
                   std::span<double> nearest);

/// True when q is a point of the goal to the bit, angles modulo 2 pi.
bool goalHolds(const ConfigurationSpace& space, const Goal& goal, std::span<const double> q);

/// Moves the angles of a point in the goal by whole turns into the goal's ranges.
void writeAsInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<double> q);

struct GoalPoints {
  std::vector<std::vector<double>> points;
  std::vector<std::string> warnings;  ///< goals left out, and why
  bool stopped = false;               ///< by `stop`, with points left to try
  StateCheck closest;                 ///< without a point: the one tried with the most clearance
};

/// Valid points of the goals: of a goal of one point that point; of a range up to kGoalSamples,
/// drawn from `seed`. Throws robots::InputError for a goal that no configuration can meet.
GoalPoints validGoalPoints(EdgeCertifier& certifier, const Problem& problem, std::uint64_t seed,
                           const std::function<bool()>& stop);

/// The goals for OMPL: sampled from their valid points, reached at any point of their ranges.
class GoalRegions : public ompl::base::GoalStates {
 public:
  GoalRegions(const ompl::base::SpaceInformationPtr& space_information,
              const ConfigurationSpace& space, const Problem& problem, const GoalPoints& points);
  double distanceGoal(const ompl::base::State* state) const override;

 private:
  const ConfigurationSpace& space_;
  const Problem& problem_;
  bool has_ranges_ = false;
};

}  // namespace leeway::planner
