#pragma once

#include <numbers>

namespace leeway::collision {

/// A whole turn [rad], rounded once.
inline constexpr double kTwoPi = 2 * std::numbers::pi;

/// Sine and cosine of x [rad], the same bytes with every C library and instruction set: within
/// 1.5 ulp for |x| <= 1e5 rad. NaN for an argument that is not finite. O(1).
void sineCosine(double x, double& sine, double& cosine);

}  // namespace leeway::collision
