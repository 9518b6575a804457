#pragma once

#include <ompl/base/Planner.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "leeway/planner/planners.h"

namespace leeway::planner {

/// The name of our own planner: ConnectTrees, which plan() uses without OMPL.
inline constexpr const char* kOwnPlanner = "Connect";

/// A planner's parameter as a number; true and false are 1 and 0.
std::optional<double> parameterNumber(std::string_view text);

/// A planner by name. Call under omplSeedLock(), after seedOmpl(). Throws std::invalid_argument
/// with plannerError()'s message.
ompl::base::PlannerPtr makePlanner(const std::string& name,
                                   const std::map<std::string, std::string>& parameters,
                                   const ompl::base::SpaceInformationPtr& space_information);

/// Seeds OMPL's generator of seeds. Objects that are made next, under the same omplSeedLock(), have
/// seeds that depend only on `seed`.
void seedOmpl(std::uint64_t seed);

}  // namespace leeway::planner
