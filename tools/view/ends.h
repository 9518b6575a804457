#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "tools/view/timeline.h"

namespace leeway::tools::view {

/// The start or a goal. If it is not valid, also the obstacle and the shortest way out.
struct End {
  std::string name;              ///< "start", or the goal's name
  std::vector<double> position;  ///< the middle of a range
  planner::StateCheck check;
  /// If the first body of the closest pair moved by this vector as a free body, it would keep its
  /// margins from all bodies that it is checked against [m]; 0 if the end is valid or no vector was
  /// found.
  Eigen::Vector3d way_out = Eigen::Vector3d::Zero();
  Pair closest = {};
  std::vector<std::pair<int, collision::Pose>> placed = {};  ///< see Moment::placed
  /// For a goal of poses: the frames in the middle of their regions, X_WF.
  std::vector<collision::Pose> frames = {};
  /// Why no configuration was found; empty if one was. `placed` has the places that the links
  /// should have, and `position` is empty.
  std::string fault = {};
  bool unreachable() const { return !fault.empty(); }
  bool isValid() const { return fault.empty() && check.verdict == planner::Verdict::kFree; }
};

/// Returns the start, then all goals; for poses, a configuration if one is found. `scene` belongs
/// to `first`, the world before the first step.
std::vector<End> endsOf(const planner::Problem& problem, const planner::Problem& first,
                        const std::shared_ptr<const planner::CompiledScene>& scene,
                        const planner::CompiledScene& shown);

}  // namespace leeway::tools::view
