#pragma once

// Private to collision/: doubles to single precision, outwards.

#include <algorithm>
#include <cmath>
#include <limits>

namespace leeway::collision {

/// The nearest float lies within 2^-24 of a double's magnitude or half a denormal; moving it by
/// 2^-22 of its magnitude and the smallest normal float, one rounding of the difference included,
/// is enough and needs no branch. An overflow goes to the largest float on the near side.
inline float roundedDown(double x) {
  const float f = std::min(static_cast<float>(x), std::numeric_limits<float>::max());
  return f - (std::abs(f) * 0x1p-22f + std::numeric_limits<float>::min());
}
inline float roundedUpToFloat(double x) {
  const float f = std::max(static_cast<float>(x), -std::numeric_limits<float>::max());
  return f + (std::abs(f) * 0x1p-22f + std::numeric_limits<float>::min());
}

/// The least float that is not below x, and the largest that is not above it.
inline float floatAbove(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}
inline float floatBelow(double x) { return -floatAbove(-x); }

/// The nearest float as a double, for numbers that are neither near the ends of a float's range
/// nor 2^990 and more: Veltkamp's splitting (Dekker 1971). For what a conversion and one back would
/// do, but g++ 12 takes the two for none where it makes vectors of them.
inline double roundedToSingle(double x) {
  const double spread = (0x1p29 + 1) * x;
  return spread + (x - spread);
}

}  // namespace leeway::collision
