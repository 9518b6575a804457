#pragma once

#include <ompl/base/goals/GoalStates.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/ompl_state_space.h"
#include "leeway/planner/problem.h"
#include "planner/base/random.h"

namespace leeway::planner {

/// Whether all ranges of a goal without poses have zero width.
bool isPoint(const Goal& goal);

/// A point of a goal's ranges within the limits, drawn uniformly.
void drawPoint(const ConfigurationSpace& space, const Goal& goal, Random& random,
               std::span<double> q);

/// Writes the point of a goal's ranges that is nearest to q in the space's distance; q itself if it
/// is in the goal. Angles count modulo 2 pi. An orientation is either fixed (a quaternion without
/// width) or free (ranges of [-1, 1]).
void nearestInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<const double> q,
                   std::span<double> nearest);

/// True if q is a point of the goal: exactly, with angles modulo 2 pi; for poses to within their
/// tolerances.
bool goalHolds(const CompiledScene& scene, const Goal& goal, std::span<const double> q);

/// Moves the angles of a point in the goal by whole turns into the goal's ranges, if it has any.
void writeAsInGoal(const ConfigurationSpace& space, const Goal& goal, std::span<double> q);

/// Valid points of the goals, from GoalSampler.
struct GoalPoints {
  std::vector<std::vector<double>> points;
  std::vector<std::string> warnings;  ///< goals that were left out, with the reason
  bool stopped = false;               ///< by `stop`, before all points were tried
  StateCheck closest;  ///< without a point: the tried one with the greatest clearance
  /// Without a point: the reason why the first unreached goal of poses has none; empty if `closest`
  /// is the reason.
  std::string reason;
  bool unreachable = false;  ///< this is proven
};

/// The goals for OMPL: sampled from their valid points, reached at any point of their ranges.
class GoalRegions : public ompl::base::GoalStates {
 public:
  GoalRegions(const ompl::base::SpaceInformationPtr& space_information,
              const ConfigurationSpace& space, const Problem& problem, const GoalPoints& points);
  double distanceGoal(const ompl::base::State* state) const override;

 private:
  const ConfigurationSpace& space_;
  const Problem& problem_;
  bool has_ranges_ = false;  ///< of joints
};

}  // namespace leeway::planner
