#pragma once

namespace leeway::planner {

/// The angle of the vector (x, y) in [0, pi/2] for x >= 0, y >= 0, not both zero [rad]. Only +, -,
/// *, / and sqrt, so that the bits do not depend on the C library; within 4 ulp, tiny angles
/// included (relative error, not absolute).
double firstQuadrantAngle(double y, double x);

}  // namespace leeway::planner
