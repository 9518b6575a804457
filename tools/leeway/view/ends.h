#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"

namespace leeway::tools::view {

/// The start or a goal, and where it is not valid what is in the way and which way is out.
struct End {
  std::string name;              ///< "start", or the goal's
  std::vector<double> position;  ///< of a range its middle
  planner::StateCheck check;
  /// Moving the first body of the closest pair so frees it of all that it is checked against, as if
  /// it were loose [m]; 0: valid, or none was found.
  Eigen::Vector3d way_out = Eigen::Vector3d::Zero();
};

/// The start, then all goals.
std::vector<End> endsOf(const planner::Problem& problem,
                        const std::shared_ptr<const planner::CompiledScene>& scene);

}  // namespace leeway::tools::view
