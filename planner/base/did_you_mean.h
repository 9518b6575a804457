#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::planner {

/// The end of a message about an unknown name: "; did you mean 'NAME'?" if robots::nearestName()
/// finds one of `known` near, otherwise "; known: a, b, c" (the first twelve), or "; there is none"
/// for an empty list. O(known * length^2).
std::string didYouMean(std::string_view name, const std::vector<std::string>& known);

/// The same for the name of a part of a robot. If the part was left out, returns the reason instead
/// (robots::RobotDescription::whyLeftOut(), which explains `kind`).
std::string didYouMean(const robots::RobotDescription& robot, std::string_view kind,
                       std::string_view name, const std::vector<std::string>& known);

}  // namespace leeway::planner
