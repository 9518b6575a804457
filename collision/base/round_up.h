#pragma once

namespace leeway::collision {

/// An upper bound of the exact value of which `value` >= 0 was computed in `operations` steps, each
/// correctly rounded and none a difference: every step errs by at most 2^-53 relative, which
/// (operations + 2) times 2^-52 covers for less than 2^50 of them, or by a denormal number. 0 is
/// taken for exact.
inline double roundedUp(double value, double operations) {
  return value == 0 ? 0 : value * (1 + (operations + 2) * 0x1p-52) + 1e-300;
}

}  // namespace leeway::collision
