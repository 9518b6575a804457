#pragma once

// Private to planner/: what the verifier demands of a path before it looks at any geometry.

#include <cstddef>
#include <optional>
#include <string>

#include "leeway/planner/plan.h"

namespace leeway::planner::verification {

struct PathFault {
  std::size_t waypoint;
  std::string reason;
};

/// The first fault of a path: wrong columns, a waypoint that is not finite or outside the limits,
/// a first one that is not the start, a last one in no goal. Nothing when there is none.
std::optional<PathFault> findFault(const Problem& problem, const ConfigurationSpace& space,
                                   const Path& path);

/// A number with 17 digits, for messages.
std::string numberText(double x);

}  // namespace leeway::planner::verification
