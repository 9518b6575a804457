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
  std::string name, kind;   ///< for a step: its name, and "move", "line", "attach", "detach"
  int first = 0, last = 0;  ///< waypoints
  planner::Problem problem;
  std::shared_ptr<const planner::CompiledScene> scene;
  std::string object = {};  ///< that the step takes hold of or lets go of
};

/// Returns the problem whose scene contains every shown body once. For a task, all objects that any
/// step attaches are attached, so that they are drawn where placedObjects() puts them.
planner::Problem shownProblem(const planner::Problem& problem);

/// The world before the first step; the problem itself without steps.
planner::Problem firstProblem(const planner::Problem& problem);

/// Returns the stages of a path; for a path without waypoints, only the first. Throws
/// robots::InputError for a path that does not have the problem's steps. Compiles the world of each
/// step.
std::vector<Stage> stagesOf(const planner::Problem& problem,
                            const std::shared_ptr<const planner::CompiledScene>& scene,
                            const planner::Path& path);

/// Returns the scenes of the stages in which something moves, which are those that a certificate
/// covers; `first` if there is none.
std::vector<std::shared_ptr<const planner::CompiledScene>> movingScenes(
    const std::vector<Stage>& stages, const std::shared_ptr<const planner::CompiledScene>& first);

/// Returns the pairs that are not checked in some of the scenes, each once, as certificates count
/// them. O(n log n) in these pairs.
std::vector<planner::CompiledScene::Dropped> uncheckedIn(
    const std::vector<std::shared_ptr<const planner::CompiledScene>>& scenes);

/// Returns the places of the shown scene's bodies that steps attach and detach, in the world of a
/// stage with the planned variables at `position`: pairs of body and X_WB. Empty without steps.
std::vector<std::pair<int, collision::Pose>> placedObjects(const planner::Problem& problem,
                                                           const planner::CompiledScene& shown,
                                                           const planner::Problem& world,
                                                           const std::vector<double>& position);

}  // namespace leeway::tools::view
