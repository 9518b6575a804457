#pragma once

// Private to collision/: rounding outwards.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace leeway::collision {

/// An upper bound of the exact value of which `value` >= 0 was computed in `operations` correctly
/// rounded steps, none of them a difference. A step errs by at most 2^-53 relative, which
/// (operations + 2) 2^-52 covers for fewer than 2^50 steps, or by a denormal number. A value of 0
/// counts as exact.
inline double roundedUp(double value, double operations) {
  return value == 0 ? 0 : value * (1 + (operations + 2) * 0x1p-52) + 1e-300;
}

/// A float below x, and one above it. They are branch-free and not the nearest ones. The nearest
/// float lies within 2^-24 of a double's magnitude or half a denormal. Moving it by 2^-22 of its
/// magnitude and the smallest normal float covers that and the rounding of the move. An overflow
/// gives the largest float on the near side.
inline float roundedDown(double x) {
  const float f = std::min(static_cast<float>(x), std::numeric_limits<float>::max());
  return f - (std::abs(f) * 0x1p-22f + std::numeric_limits<float>::min());
}
inline float roundedUpToFloat(double x) {
  const float f = std::max(static_cast<float>(x), -std::numeric_limits<float>::max());
  return f + (std::abs(f) * 0x1p-22f + std::numeric_limits<float>::min());
}

/// The least float that is not below x, and the largest float that is not above it.
inline float floatAbove(double x) {
  const auto f = static_cast<float>(x);
  if (!(static_cast<double>(f) < x)) return f;  // NaN and infinity, too
  // The next float, as std::nextafter() returns it, but without a call: numbers of one sign have
  // the order of their bits.
  if (f == 0) return std::numeric_limits<float>::denorm_min();
  const auto bits = std::bit_cast<std::uint32_t>(f);
  return std::bit_cast<float>(f > 0 ? bits + 1 : bits - 1);
}
inline float floatBelow(double x) { return -floatAbove(-x); }

/// The nearest float, as a double, of a number away from the ends of a float's range and below
/// 2^990: Veltkamp's splitting (Dekker 1971). It replaces a conversion to float and back, which g++
/// 12 drops in vectorized loops.
inline double roundedToSingle(double x) {
  const double spread = (0x1p29 + 1) * x;
  return spread + (x - spread);
}

}  // namespace leeway::collision
