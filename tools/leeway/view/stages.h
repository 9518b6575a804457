#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"

namespace leeway::tools::view {

/// A stretch of a path in one world: a step of a task, or the whole path of a problem without
/// steps.
struct Stage {
  std::string name, kind;   ///< of a step: its name, and "move", "line", "attach", "detach"
  int first = 0, last = 0;  ///< waypoints
  planner::Problem problem;
  std::shared_ptr<const planner::CompiledScene> scene;
};

/// The problem whose scene has everything that is shown, once. Of a task: all that any step takes
/// hold of is held, so that it is drawn where placedObjects() says.
planner::Problem shownProblem(const planner::Problem& problem);

/// The world before the first step; the problem itself without steps.
planner::Problem firstProblem(const planner::Problem& problem);

/// The stages of a path; of a path without waypoints one, the first. Throws robots::InputError for
/// a path that does not have the problem's steps. Compiles the world of each step.
std::vector<Stage> stagesOf(const planner::Problem& problem,
                            const std::shared_ptr<const planner::CompiledScene>& scene,
                            const planner::Path& path);

/// Where the shown scene's bodies are that steps take and put down, in the world of a stage with
/// the planned variables at `position`: pairs of body and X_WB. Empty without steps.
std::vector<std::pair<int, collision::Pose>> placedObjects(const planner::Problem& problem,
                                                           const planner::CompiledScene& shown,
                                                           const planner::Problem& world,
                                                           const std::vector<double>& position);

}  // namespace leeway::tools::view
