#pragma once

#include <memory>

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// plan() for a validated problem, in its scene or a variant of it.
PlanResult planIn(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
                  const PlanOptions& options);

}  // namespace leeway::planner
