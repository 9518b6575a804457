#pragma once

#include <string>

#include "tools/view/timeline.h"

namespace leeway::tools {

/// The clearance along a path over time as an SVG document: the proven lower bound as steps, what
/// was measured from the world and of the robot from itself, and the margin [m]. Names and titles
/// may hold anything. O(moments).
std::string profileSvg(const std::string& title, const std::string& note,
                       const view::Timeline& timeline, double margin);

}  // namespace leeway::tools
