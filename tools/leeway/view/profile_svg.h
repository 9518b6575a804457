#pragma once

#include <set>
#include <string>

#include "tools/view/timeline.h"

namespace leeway::tools {

/// The clearance along a path over time as an SVG document: the proven lower bound as steps, what
/// was measured from the world and of the robot from itself, and the margins of pairs [m]. Names
/// and titles may hold anything. O(moments).
std::string profileSvg(const std::string& title, const std::string& note,
                       const view::Timeline& timeline, const std::set<double>& margins);

}  // namespace leeway::tools
