#pragma once

#include <string>

namespace leeway::planner {

/// How far a path departs, at most, from what a constraint wants: proven bounds.
struct ConstraintResult {
  std::string name;
  double deviation = 0;  ///< of the frame's origin from its box [m]
  double angle = 0;      ///< of its rotation, or axis [rad]
};

}  // namespace leeway::planner
