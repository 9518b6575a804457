#pragma once

namespace leeway::planner {

/// The angle of the vector (x, y) in [0, pi/2] for x >= 0, y >= 0, not both zero [rad]. The error
/// is at most 4 ulp, also for tiny angles. Uses only +, -, *, / and sqrt, so that the bits do not
/// depend on the C library.
double firstQuadrantAngle(double y, double x);

}  // namespace leeway::planner
