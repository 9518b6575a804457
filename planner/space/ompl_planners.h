#pragma once

#include <ompl/base/Planner.h>

#include <cstdint>
#include <map>
#include <string>

#include "leeway/planner/planners.h"

namespace leeway::planner {

/// A planner for that space information. Call under omplSeedLock(), after seedOmpl(). Throws
/// std::invalid_argument with plannerError()'s words.
ompl::base::PlannerPtr makePlanner(const std::string& name,
                                   const std::map<std::string, std::string>& parameters,
                                   const ompl::base::SpaceInformationPtr& space_information);

/// Puts OMPL's generator of seeds at a place that depends on `seed` only: until omplSeedLock() is
/// given back, whatever is made gets the same seeds each time.
void seedOmpl(std::uint64_t seed);

}  // namespace leeway::planner
