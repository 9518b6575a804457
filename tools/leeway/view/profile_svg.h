#pragma once

#include <string>
#include <vector>

namespace leeway::tools {

/// The bounds on the clearance on one stretch of a path.
struct ProfileStretch {
  double begin = 0, end = 0;  ///< of the axis along the path
  double lower = 0;           ///< proven on the whole stretch [m]; -infinity: no bound
  double upper = 0;           ///< found on the stretch [m]; infinity: nothing is near
};

/// Returns the clearance along a path as an SVG document: the proven lower bound as steps, the
/// upper bound, and the margin. `axis`: the quantity of the stretches' ends, with its unit. Names
/// and titles may contain any characters. O(stretches).
std::string profileSvg(const std::string& title, const std::string& note, const std::string& axis,
                       const std::vector<ProfileStretch>& stretches, double margin);

}  // namespace leeway::tools
