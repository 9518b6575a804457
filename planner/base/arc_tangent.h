#pragma once

namespace leeway::planner {

/// The angle of the vector (x, y) in [0, pi/2] for x >= 0, y >= 0, not both zero [rad]. Within 4
/// ulp, of tiny angles, too. Uses only +, -, *, / and sqrt, so that the bits do not depend on the C
/// library.
double firstQuadrantAngle(double y, double x);

}  // namespace leeway::planner
