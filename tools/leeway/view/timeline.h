#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "tools/leeway/view/stages.h"

namespace leeway::tools::view {

/// Two bodies of the shown scene, as a check names its closest pair.
struct Pair {
  int a = -1, b = -1;  ///< -1: nothing is near
  double margin = 0;   ///< [m]
};
/// The pair `check` found in the scene that it asked.
Pair pairOf(const planner::StateCheck& check, const planner::CompiledScene& asked,
            const planner::CompiledScene& shown);

/// What is known at one instant.
struct Moment {
  double time = 0;               ///< [s]
  std::vector<double> position;  ///< of the planned variables
  planner::StateCheck check;     ///< closest pair of its scene, clearance to kMomentTolerance
  Pair closest;
  /// Bodies of the shown scene that are not where its robot would hold them: X_WB.
  std::vector<std::pair<int, collision::Pose>> placed = {};
};

/// A deforming obstacle's vertices at some instants, in its frame.
struct Frames {
  int body = -1;
  std::vector<double> times;                            // [s]
  std::vector<std::vector<Eigen::Vector3d>> positions;  // [m]
};

/// A motion and the room that it leaves.
struct Timeline {
  std::vector<Moment> moments;  ///< at least one
  /// Proven on the whole stretch from a moment to the next [m]; one fewer than moments.
  std::vector<planner::Interval> stretches;
  /// Clearance of each moving body at each moment, [moment][body of the scene], and the least of
  /// every body over all moments. Upper ends [m]; infinity: nothing that it is checked against, or
  /// not asked because there is too much.
  std::vector<std::vector<double>> body_clearance;
  std::vector<double> least_clearance;
  std::vector<int> least_moment;
  std::vector<Frames> frames;
  std::vector<double> waypoint_times;  // [s]
};

/// Width of the intervals of moments [m].
inline constexpr double kMomentTolerance = 1e-6;

/// The path at the velocities of the problem's execution, at rest in each waypoint, among the
/// obstacles as they stand at the start of the execution. About 250 moments and one for each
/// waypoint; fewer where a scene has very many pairs. Of a task each stretch in its world.
Timeline timelineOfPath(const planner::Problem& problem,
                        const std::shared_ptr<const planner::CompiledScene>& scene,
                        const planner::Path& path, const std::vector<Stage>& stages);

/// What was executed, a moment a step, with the obstacles as they moved.
Timeline timelineOfSteps(const planner::Problem& problem,
                         const std::shared_ptr<const planner::CompiledScene>& scene,
                         const std::vector<planner::ReplanStep>& steps);

/// A single moment at the given point of the space, in the world of a stage.
Timeline timelineOfState(const planner::Problem& problem,
                         const std::shared_ptr<const planner::CompiledScene>& scene,
                         const Stage& stage, const std::vector<double>& position);

}  // namespace leeway::tools::view
