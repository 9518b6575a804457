#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "tools/leeway/view/timeline.h"

namespace leeway::tools::view {

/// The start or a goal, and where it is not valid what is in the way and which way is out.
struct End {
  std::string name;              ///< "start", or the goal's
  std::vector<double> position;  ///< of a range its middle
  planner::StateCheck check;
  /// Moving the first body of the closest pair so frees it of all that it is checked against, as if
  /// it were loose [m]; 0: valid, or none was found.
  Eigen::Vector3d way_out = Eigen::Vector3d::Zero();
  Pair closest = {};
  std::vector<std::pair<int, collision::Pose>> placed = {};  ///< as Moment's
  /// A goal of poses: where the frames are to be, in the middle of their regions: X_WF.
  std::vector<collision::Pose> frames = {};
  /// That no configuration was found for: where the links are to be, as `placed`; `position` is
  /// empty.
  bool unreachable = false;
};

/// The start, then all goals; of poses a configuration where one is found. `scene` is that of
/// `first`, the world before the first step.
std::vector<End> endsOf(const planner::Problem& problem, const planner::Problem& first,
                        const std::shared_ptr<const planner::CompiledScene>& scene,
                        const planner::CompiledScene& shown);

}  // namespace leeway::tools::view
