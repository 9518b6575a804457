#pragma once

#include <span>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"
#include "leeway/planner/compiled_scene.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {

/// The poses of the links at a point of the space.
std::vector<robots::Pose> linksAt(const planner::CompiledScene& scene,
                                  std::span<const double> point);

/// The distance of a pair with the links at X_WL [m].
collision::Interval distanceOf(const planner::CompiledScene& scene,
                               const collision::ScenePair& pair, std::span<const robots::Pose> X_WL,
                               const collision::DistanceRequest& request,
                               collision::Scratch& scratch);

/// All pairs of bodies that are not proven to keep their margin at a point of the space, each once.
/// `known`, which an earlier query found, comes first. One distance query per pair of geometries.
std::vector<PairNames> pairsTooNear(const planner::CompiledScene& scene,
                                    std::span<const double> point, const PairNames& known);

/// The text "a and b; c and d" with all pairs.
std::string pairsText(const std::vector<PairNames>& pairs);

}  // namespace leeway::tools
