#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "tools/view/executed_clearance.h"
#include "tools/view/least_clearance.h"
#include "tools/view/stages.h"

namespace leeway::tools::view {

/// Two bodies of the shown scene: the closest pair of a check.
struct Pair {
  int a = -1, b = -1;  ///< -1: nothing is near
  double margin = 0;   ///< [m]
};
/// The pair that `check` found in the scene `asked`.
Pair pairOf(const planner::StateCheck& check, const planner::CompiledScene& asked,
            const planner::CompiledScene& shown);

/// The nearest pair at one instant, with the world or of the robot with itself.
struct Nearest {
  planner::Interval clearance{kInfinity, kInfinity};  ///< [m]
  Pair pair;
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();  ///< world
};

/// The state and the clearances at one instant.
struct Moment {
  double time = 0;               ///< [s]
  std::vector<double> position;  ///< of the planned variables
  planner::StateCheck check;     ///< closest pair of its scene, clearance to kMomentTolerance
  Pair closest;
  Nearest world = {}, self = {};  ///< one of them equals `check`
  int stage = 0;                  ///< of a path
  /// Bodies of the shown scene that are not where its robot would carry them, or that move by a
  /// motion of their own: X_WB.
  std::vector<std::pair<int, collision::Pose>> placed = {};
};

/// A deforming obstacle's vertices at some instants, in its frame.
struct Frames {
  int body = -1;
  std::vector<double> times;                            // [s]
  std::vector<std::vector<Eigen::Vector3d>> positions;  // [m]
};

/// The distances of two bodies at all moments; NaN if the pair is not checked.
struct PairCurve {
  Pair pair;
  std::vector<double> distance;                   // upper ends [m]
  std::vector<Eigen::Vector3d> point_a, point_b;  // in the world
};

/// A motion and its clearances.
struct Timeline {
  std::vector<Moment> moments;  ///< at least one
  /// Proven on the whole stretch from one moment to the next [m]; one fewer than moments.
  std::vector<planner::Interval> stretches;
  /// The same for the world and for the robot itself; empty for an execution.
  std::vector<planner::Interval> world_stretches, self_stretches;
  /// The moments of the least clearances; -1: nothing is near. For a path, these are the places of
  /// leastClearance(), with its intervals; for an execution, those of executedClearance(), unless a
  /// moment was nearer that is not certified.
  int least_world = -1, least_self = -1;
  /// The nearest pairs, nearest first; of a single moment, those that do not keep their margins.
  std::vector<PairCurve> pairs;
  /// Index in `pairs` of a pair that breaks its margin although the nearest pair keeps its own.
  /// -1: no such pair.
  int failing = -1;
  /// The clearance of each moving body at each moment, [moment][body of the scene], and the least
  /// of every body over all moments. Upper bounds [m]. Infinity: nothing is near that it is checked
  /// against, or it was not measured because there is too much to measure.
  std::vector<std::vector<double>> body_clearance;
  std::vector<double> least_clearance;
  std::vector<int> least_moment;
  std::vector<Frames> frames;
  std::vector<double> waypoint_times;  // [s]
};

/// The path at the velocities of the problem's execution, at rest in each waypoint, among the
/// obstacles as they are at the start of the execution. Has about 250 moments, one for each
/// waypoint, those of `least` and those of `failures`; fewer if a scene has very many pairs. Each
/// stretch of a task is in the world of its step. `stages` belong to `edges.path`. `certified`: all
/// margins are kept. `failures`: edges and places on them where one is not.
Timeline timelineOfPath(const planner::Problem& problem,
                        const std::shared_ptr<const planner::CompiledScene>& scene,
                        const planner::PathEdges& edges, const std::vector<Stage>& stages,
                        const LeastClearance& least, bool certified,
                        const std::vector<std::pair<int, double>>& failures = {});

/// The executed motion with one moment per step and those of `executed`, and the obstacles as they
/// moved.
Timeline timelineOfSteps(const planner::Problem& problem,
                         const std::shared_ptr<const planner::CompiledScene>& scene,
                         const std::vector<planner::ReplanStep>& steps,
                         const ExecutedClearance& executed);

/// A single moment at the given point of the space, in the world of a stage.
Timeline timelineOfState(const planner::Problem& problem,
                         const std::shared_ptr<const planner::CompiledScene>& scene,
                         const Stage& stage, const std::vector<double>& position);

}  // namespace leeway::tools::view
