#pragma once

#include <span>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/ompl_state_space.h"

namespace leeway::planner {

/// The numbers of a state of OmplStateSpace. Their count comes from the scene, because a planner's
/// own space may be a wrapper of ours (CForest's is).
inline std::span<const double> pointOf(const ompl::base::State* state, const CompiledScene& scene) {
  return {state->as<OmplStateSpace::StateType>()->values,
          static_cast<std::size_t>(scene.space().size())};
}

inline std::span<double> pointOf(ompl::base::State* state, const CompiledScene& scene) {
  return {state->as<OmplStateSpace::StateType>()->values,
          static_cast<std::size_t>(scene.space().size())};
}

}  // namespace leeway::planner
