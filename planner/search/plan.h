#pragma once

#include <memory>

#include "leeway/planner/plan.h"

namespace leeway::planner {

/// plan() for a problem that was validated, in its scene or a variant of that.
PlanResult planIn(std::shared_ptr<const CompiledScene> scene, const Problem& problem,
                  const PlanOptions& options);

}  // namespace leeway::planner
