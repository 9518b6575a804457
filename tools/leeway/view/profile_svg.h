#pragma once

#include <string>
#include <vector>

namespace leeway::tools {

/// What is known of the clearance on one stretch of a path.
struct ProfileStretch {
  double begin = 0, end = 0;  ///< of the axis along the path
  double lower = 0;           ///< proven on the whole stretch [m]; -infinity: nothing is
  double upper = 0;           ///< met somewhere on it [m]; infinity: nothing is near
};

/// The clearance along a path as an SVG document: the proven lower bound as steps, the upper end,
/// and the margin. `axis`: what the stretches' ends count, with its unit. Names and titles may hold
/// anything. O(stretches).
std::string profileSvg(const std::string& title, const std::string& note, const std::string& axis,
                       const std::vector<ProfileStretch>& stretches, double margin);

}  // namespace leeway::tools
