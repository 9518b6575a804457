#pragma once

// Private to planner/: the verifier's checks of a path that need no geometry.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/verify.h"

namespace leeway::planner::verification {

struct PathFault {
  std::size_t waypoint;
  std::string reason;
};

/// Returns the first fault of a path: wrong columns, a waypoint that is not finite or is outside
/// the limits, a first waypoint that is not the start, and, with `ends_in_goal`, a last waypoint
/// that is in no goal. Returns nothing if the path has no fault.
std::optional<PathFault> findFault(const Problem& problem, const ConfigurationSpace& space,
                                   const Path& path, bool ends_in_goal = true);

/// Whether a waypoint is in one of the problem's goals.
bool isInGoal(const Problem& problem, const ConfigurationSpace& space,
              const std::vector<double>& q);

/// The first state of a path that the problem's condition does not accept, of those that
/// Condition::resolution has it look at; nothing when there is none.
std::optional<VerifyResult> findUnaccepted(const Problem& problem, const ConfigurationSpace& space,
                                           const Path& path);

/// A number with 17 digits, for messages.
std::string numberText(double x);

}  // namespace leeway::planner::verification
